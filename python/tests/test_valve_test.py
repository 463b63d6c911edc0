"""A test of a valve, planned and read."""

import pathlib

import pytest

import stiction

TESTED = pathlib.Path(__file__).parents[2] / "samples" / "test" / "FIC106-tested.csv"


def test_a_test_is_planned_and_read() -> None:
    [recording] = stiction.read(TESTED)
    reading = stiction.valve_test.read(recording)
    assert reading.class_ == "sticks"
    assert reading.known_by == "mode"
    assert reading.S is not None
    assert reading.S.low < 3.24 < reading.S.high
    assert reading.S_below is None
    assert len(reading.steps) > 20
    assert "sticks" in repr(reading)
    assert reading.to_dict()["steps"][0]["travel"] is None

    plan = stiction.valve_test.plan(recording, pv_allowed=(0.8, 0.9))
    assert plan.pv_low == pytest.approx(0.815)
    assert plan.grow[0].op == -plan.grow[1].op
    assert sum(turn.hold_s for turn in plan.grow) <= plan.total_s and plan.expected_s <= plan.total_s
    short = stiction.valve_test.plan(recording, time_s=600)
    assert short.total_s == 600 and len(short.grow) < len(plan.grow)


def test_a_list_of_what_was_done_stands_for_the_mode() -> None:
    [recording] = stiction.read(TESTED)
    by_mode = stiction.valve_test.read(recording)
    done = [(step.at_s, step.op) for step in by_mode.steps]
    reading = stiction.valve_test.read(recording, done=[*done, (by_mode.to_s, None)])
    assert reading.known_by == "sheet"
    assert reading.class_ == "sticks"


def test_two_tests_show_what_a_repair_changed() -> None:
    [before] = stiction.read(TESTED.with_name("FIC107-tested.csv"))
    [after] = stiction.read(TESTED.with_name("FIC107-repaired.csv"))
    repair = stiction.valve_test.compare(before, after)
    assert repair.effect == "lowered"
    assert repair.before.class_ == "sticks"
    assert repair.after.S_below is not None
    assert repair.before.S is not None
    assert repair.difference is not None
    assert repair.difference.value is None
    assert repair.difference.high == pytest.approx(repair.after.S_below - repair.before.S.low)
    assert "The repair lowered S from" in repr(repair)
    same = stiction.valve_test.compare(before, before)
    assert same.effect == "unchanged"
    done = [(step.at_s, step.op) for step in repair.before.steps]
    sheet = stiction.valve_test.compare(before, after, before_done=[*done, (repair.before.to_s, None)])
    assert sheet.before.known_by == "sheet"


def test_a_test_is_compared_with_its_plan() -> None:
    [recording] = stiction.read(TESTED)
    plan = stiction.valve_test.plan(recording)
    reading = stiction.valve_test.read(recording, plan=plan)
    assert reading.plan is not None
    assert reading.plan.turns == len(reading.steps)
    assert reading.plan.remarks
    assert stiction.valve_test.read(recording).plan is None
    [other] = stiction.read(TESTED.with_name("FIC107-tested.csv"))
    with pytest.raises(ValueError, match="the plan is for loop FIC106-tested, but the recording is of FIC107-tested"):
        stiction.valve_test.read(other, plan=plan)
    same = stiction.valve_test.compare(recording, recording, before_plan=plan)
    assert same.before.to_dict()["plan"] == reading.to_dict()["plan"]
    assert same.after.plan is None
    with pytest.raises(ValueError, match="the plan is for loop FIC106-tested"):
        stiction.valve_test.compare(recording, other, after_plan=plan)


def test_a_signature_shows_s_along_the_stroke() -> None:
    [recording] = stiction.read(TESTED.with_name("LV104-signature.csv"))
    found = stiction.valve_test.signature(recording)
    assert (found.class_, found.ramps, len(found.places)) == ("sticks", 4, 10)
    assert found.S is not None
    assert found.S.low < 2.2 < found.S.high
    assert found.binds is not None
    assert 35 < found.binds[0] < 45
    assert 55 < found.binds[1] < 65
    [bound] = [place.S for place in found.places if place.from_ < 50 < place.to]
    assert bound.low < 5.4 < bound.high
    assert "sticks, 4 ramps" in repr(found)
    same = stiction.valve_test.compare_signatures(recording, recording)
    assert same.effect == "unchanged"
    with pytest.raises(ValueError, match="an OP range of at least 10 %"):
        stiction.valve_test.plan_signature(op=(40, 45))
    [turns] = stiction.read(TESTED)
    with pytest.raises(ValueError, match="no slow ramp of the OP"):
        stiction.valve_test.signature(turns)


def test_what_cannot_be_done_is_reported() -> None:
    wave = [50 + (k % 9) * 0.3 for k in range(300)]
    recording = stiction.recording(wave, wave, sample_time=1, name="FIC1")
    with pytest.raises(ValueError, match="loop FIC1: the recording has no test"):
        stiction.valve_test.read(recording)
    with pytest.raises(ValueError, match="lower limit of the PV is not below"):
        stiction.valve_test.plan(recording, pv_allowed=(3, 1))
    with pytest.raises(TypeError, match="rises"):
        stiction.valve_test.plan(recording, rises="up")  # type: ignore[arg-type]
