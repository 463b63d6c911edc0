"""A watch of a second server, of node-opcua: what is recorded is what was played, and verdicts are those of a scan."""

import pytest

pytest.importorskip("asyncua")

import stiction.plant
from processes import wait_for
from stiction.live import hours, opcua
from test_watch import all_judged, gaps, state
from trial import judged_otherwise, node_modules, node_server, of_plant, recorded, unequal

SERVICES = {kind.__name__ for kind in opcua.SERVICES}


@pytest.fixture(scope="module")
def modules(tmp_path_factory):
    folder, why = node_modules(tmp_path_factory.mktemp("node"))
    if folder is None:
        pytest.skip(why)
    return folder


@pytest.fixture
def node(modules, live, tmp_path):
    """Begins a server that plays data, which is ended with the test."""
    started = []

    def begin(data, speed, *more):
        started.append(node_server(modules, live.port, tmp_path, data, speed, *more))
        started[-1].info = started[-1].answer("listening", 60)
        return started[-1]

    yield begin
    for each in started:
        each.end(kill=True)


def requests(server):
    server.tell("requests")
    return server.answer("requests")["requests"]


def open_hours(live):
    """Writes the files of all hours, of those that have not ended, too."""
    hours.Recorder(live.watched, []).release(1 << 62)
    hours.fold(live.watched, live.watched / "data")


@pytest.mark.parametrize("encrypted", [False, True], ids=["open", "encrypted"])
def test_what_is_recorded_was_played(node, live, encrypted):
    data = of_plant(live.plant, 600)
    server = node(data, 200)
    if encrypted:
        made = live.run("-m", "stiction.live", "watch", "--make-certificate", "-C", live.watched)
        assert made.process.wait(150) == 0
    watch = live.watch(*(["--trust-first"] if encrypted else ["--security", "none"]))
    watch.says("connected to", 60)
    server.tell("play")
    wait_for(lambda: (state(live).get("known_until") or 0) > 1e-6 * server.info["end"] + 1, 60, "the end")
    asked = requests(server)
    assert watch.end() == 0
    open_hours(live)
    assert unequal(live.watched, data) == []
    assert asked["PublishRequest"] > 1 and set(asked) <= SERVICES
    assert any("is trusted from now on" in line for line in watch.log) == encrypted


def test_200_loops_of_4_tags_at_100_times_the_speed(node, live, tmp_path):
    # More than 10,000 values a second.
    stiction.plant.demo(tmp_path / "large", loops=200, days=1)
    data = of_plant(tmp_path / "large", 3600, modes=True)
    (live.watched / "plant.toml").write_text((tmp_path / "large/plant.toml").read_text().replace("data/*", "data/**/*"))
    server = node(data, 120)
    watch = live.watch("--security", "none", "--queue", "5000")
    assert "800 of 800 tags" in watch.says("connected to", 60)
    server.tell("play")
    server.answer("played", 120)
    wait_for(all_judged(live, server), 120, "the judgement of the hour")
    asked = requests(server)
    assert watch.end() == 0
    open_hours(live)
    assert unequal(live.watched, data) == [] and not any(gaps(live.watched).values())
    assert judged_otherwise(live.watched, data, tmp_path / "other") == []
    assert asked["PublishRequest"] > 1 and set(asked) <= SERVICES


@pytest.mark.parametrize("history", [True, False], ids=["history", "no history"])
def test_what_the_server_dropped_comes_from_its_history(node, live, history):
    data = of_plant(live.plant, 600)
    server = node(data, 100, *([100_000] if history else []))
    # Three to ten values of most tags a second, and room for two.
    watch = live.watch("--security", "none", "--publish", "1s", "--queue", "2")
    watch.says("connected to", 60)
    server.tell("play")
    watch.says("the server dropped values of")
    wait_for(lambda: (state(live).get("known_until") or 0) > 1e-6 * server.info["end"] + 1, 60, "the end")
    assert watch.end() == 0
    open_hours(live)
    if history:
        assert unequal(live.watched, data) == []
        # Of some tags nothing was dropped but what has the time of the state before it.
        assert {time for times in gaps(live.watched).values() for time in times} <= {server.info["begin"] + 1}
        return
    # No wrong value, and a gap in each tag that lacks one.
    found, marked = recorded(live.watched), gaps(live.watched)
    lacking = set(unequal(live.watched, data))
    assert lacking and lacking == {tag for tag, times in marked.items() if times}
    assert all(set(found[tag]) <= set(zip(*(each.tolist() for each in data[tag]))) for tag in data)
