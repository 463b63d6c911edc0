"""Events are what the ranking newly says, each once."""

import json

from stiction.live import events

ROW = dict.fromkeys(
    ["area", "unit", "grade", "probability", "S", "change_day", "change_from", "change_to", "until", "override", "test", "error"]
) | {"loop": "FIC1", "verdict": "cannot tell", "change": "none", "health": "good"}


def kinds(reported, *rows):
    """The kinds of events of judgements one after the other."""
    found = []
    for row in rows:
        new, reported = events.derive(reported, [ROW | row])
        found.append([event["event"] for event in new])
    return found, reported


def test_a_valve_is_accused_by_two_judgements_and_once():
    sticks = {"verdict": "sticks"}
    assert kinds({}, sticks, sticks, sticks, {}, sticks)[0] == [[], ["new sticking"], [], [], []]
    assert kinds({}, sticks, {}, sticks, {})[0] == [[], [], [], []]
    silent = {"verdict": "does not respond"}
    assert kinds({}, silent, silent, sticks, sticks)[0] == [[], ["no response"], [], ["new sticking"]]


def test_a_repair_ends_the_accusation_and_a_relapse_begins_another():
    sticks, gone = {"verdict": "sticks"}, {"change": "gone", "change_day": "2026-03-07"}
    found, reported = kinds({}, sticks, sticks, gone, gone, sticks, {"verdict": "sticks", "change": "returned", "change_day": "2026-03-09"})
    assert found == [[], ["new sticking"], ["repaired"], [], [], ["new sticking"]]
    [event], _ = events.derive({"FIC1": {"valve before": "new sticking"}}, [ROW | {"verdict": "sticks", "change": "new", "change_day": "2026-03-04"}])
    assert event["text"] == "FIC1: the valve sticks, since 2026-03-04" and event["change_day"] == "2026-03-04"
    assert kinds(reported, {"verdict": "does not stick"})[0] == [["repaired"]]


def test_a_person_and_a_decisive_test_have_precedence():
    sticks = {"verdict": "sticks"}
    assert kinds({}, *[sticks | {"override": "does not stick"}] * 2)[0] == [[], []]
    assert kinds({}, *[sticks | {"test": "does not stick"}] * 2)[0] == [[], []]
    assert kinds({}, *[sticks | {"test": "cannot tell"}] * 2)[0] == [[], ["new sticking"]]


def test_data_die_and_come_back():
    for health in ("no data", "errors", "dead or frozen"):
        assert kinds({}, {"health": health}, {"health": health}, {}, {})[0] == [[], ["data dead"], ["data back"], []]
    assert kinds({}, *[{"health": "always in manual"}] * 3)[0] == [[], [], []]


def test_events_and_state_are_kept(tmp_path):
    (tmp_path / ".stiction/live").mkdir(parents=True)
    assert events.load(tmp_path) == {}
    new, reported = events.derive({"FIC1": {"valve before": "new sticking"}}, [ROW | {"verdict": "sticks"}])
    events.keep(tmp_path, new, reported)
    events.keep(tmp_path, new, reported)
    assert events.load(tmp_path) == reported
    assert [json.loads(line) for line in events.path_of(tmp_path).read_text().splitlines()] == 2 * new
