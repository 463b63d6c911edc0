"""A watch of a played plant: what is recorded is what was played, through all faults, and verdicts are those of a scan."""

import asyncio
import contextlib
import json
import os
import signal
import socket
import stat
import threading
import time
import urllib.request
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("asyncua")

import stiction.plant
from processes import HERE, free_port, wait_for
from server import played
from stiction.live import hours, opcua
from stiction.live.events import KINDS
from trial import judged_otherwise, recorded

SECOND = 1_000_000
TWO_HOURS = ["--speed", "900", "--last", "7200"]


def of_plant(plant, first, last):
    return {
        tag: [(int(t), float(v)) for t, v in zip(times, values) if first <= t < last]
        for tag, (times, values) in played(plant, None).items()
    }


def gaps(folder):
    found = {}
    for path in sorted((folder / "data").glob("*/*.parquet")):
        for tag, rows in hours.tables_by_tag(path):
            found.setdefault(tag, []).extend(rows.time[rows.status == hours.LOST].tolist())
    return found


def state(live):
    path = live.watched / ".stiction/live/status.json"
    return json.loads(path.read_text()) if path.exists() else {}


def hour_is_there(live, number):
    return lambda: (live.watched / "data" / "2026-03-02" / f"{number:02d}.parquet").exists()


def all_judged(live, server, grace_s=120.0):
    """All values have come, also late ones, which have an hour written and judged again, and nothing is left to be judged."""

    scans = None

    def found():
        nonlocal scans
        end = hours.hour_of(server.info["end"] + hours.HOUR - 1)
        waiting = (live.watched / ".stiction/live").glob("*/*.values")
        if any(hours._journal_hour(path) + hours.HOUR <= end for path in waiting):
            scans = None
            return False
        now = state(live)
        if (now.get("known_until") or 0) <= 1e-6 * end + grace_s or not now["scans"]:
            return False
        # The hours are written. What wrote them judges them, and others may follow.
        if scans is None:
            scans = now["scans"]
            return False
        return not now["judging"] or now["scans"] > scans

    return found


def test_what_is_recorded_was_played_and_judged_as_by_a_scan(live, tmp_path):
    server = live.serve(*TWO_HOURS)
    port = free_port()
    watch = live.watch("--security", "none", "--metrics", f"127.0.0.1:{port}")
    watch.says("connected to")
    server.tell("play")
    wait_for(all_judged(live, server), 120, "the judgement of all hours")
    text = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5).read().decode()
    status = state(live)
    server.tell("requests")
    asked = set(server.answer("requests")["requests"])
    assert watch.end() == 0 and "stopped" in watch.log[-1]
    begin, end = server.info["begin"], server.info["end"]
    assert recorded(live.watched) == of_plant(live.plant, begin, end)
    assert not any(gaps(live.watched).values())
    data = {tag: (times[times < end], values[times < end]) for tag, (times, values) in played(live.plant, None).items()}
    assert judged_otherwise(live.watched, data, tmp_path / "other") == []
    # Events are lines of JSON, and what the ranking says.
    events = [json.loads(line) for line in watch.out]
    assert all(event["event"] in KINDS and event["text"] for event in events)
    assert events == [json.loads(line) for line in (live.watched / ".stiction/events.jsonl").read_text().splitlines()]
    assert asked <= {kind.__name__ for kind in opcua.SERVICES}
    assert "stiction_up 1" in text and 'stiction_loops{word="' in text and "stiction_scan_seconds" in text
    assert status["tags"] == len(data) and status["values"] > 0


def test_a_killed_watch_loses_nothing_with_a_history(live):
    server = live.serve(*TWO_HOURS)
    watch = live.watch("--security", "none")
    watch.says("connected to")
    server.tell("play")
    wait_for(lambda: state(live).get("values", 0) > 1000, 30, "values")
    watch.end(kill=True)
    time.sleep(1.0)
    again = live.watch("--security", "none")
    again.says("gap of")
    again.says("came from the server's history")
    wait_for(all_judged(live, server), 120, "the judgement of all hours")
    assert again.end() == 0
    assert recorded(live.watched) == of_plant(live.plant, server.info["begin"], server.info["end"])


def test_a_gap_stays_a_gap_without_a_history(live):
    server = live.serve(*TWO_HOURS, "--no-history")
    watch = live.watch("--security", "none")
    watch.says("connected to")
    server.tell("play")
    wait_for(lambda: state(live).get("values", 0) > 1000, 30, "values")
    watch.end(kill=True)
    time.sleep(1.0)
    again = live.watch("--security", "none")
    again.says("the gap remains in")
    wait_for(all_judged(live, server), 120, "the judgement of all hours")
    assert again.end() == 0
    expected = of_plant(live.plant, server.info["begin"], server.info["end"])
    found, lost = recorded(live.watched), gaps(live.watched)
    missing = 0
    for tag, own in expected.items():
        kept = set(found[tag])
        assert kept <= set(own), "no value that was not played"
        absent = [t for t, value in own if (t, value) not in kept]
        missing += len(absent)
        if absent:
            # What is missing is one piece, and a row without a value begins it, so that nothing is held across it.
            assert len(lost[tag]) == 1 and lost[tag][0] < absent[0]
            assert not [t for t, _ in kept if lost[tag][0] <= t <= absent[-1]]
    assert missing > 100


def test_a_server_that_is_killed_is_found_again(live):
    server = live.serve(*TWO_HOURS)
    watch = live.watch("--security", "none")
    watch.says("connected to")
    server.tell("play")
    wait_for(lambda: state(live).get("values", 0) > 1000, 30, "values")
    server.end(kill=True)
    watch.says("no connection to")
    # The plant went on meanwhile.
    again = live.serve("--speed", "900", "--first", "3000", "--last", "4200")
    again.tell("play")
    watch.says("gap of")
    wait_for(all_judged(live, server), 120, "the judgement of all hours")
    assert watch.end() == 0
    assert recorded(live.watched) == of_plant(live.plant, server.info["begin"], server.info["end"])


def test_history_before_the_first_start_is_read(live):
    server = live.serve("--speed", "900", "--first", "5400", "--last", "1800")
    watch = live.watch("--security", "none", "--history", "75min")
    watch.says("came from the server's history")
    server.tell("play")
    wait_for(all_judged(live, server), 120, "the judgement of all hours")
    assert watch.end() == 0
    begin, end = server.info["begin"] - 75 * 60 * SECOND, server.info["end"]
    assert recorded(live.watched) == of_plant(live.plant, begin, end)


@pytest.mark.parametrize("habit", [["--cap", "10000"], ["--cap", "700"], ["--cap", "3000", "--newest"]], ids=["no continuation", "continuations", "newest first"])
def test_a_history_is_read_to_its_end_wherever_the_server_cuts_it(live, habit):
    import capped

    server = live.run(HERE / "capped.py", "--port", live.port, *habit)
    server.answer("listening")
    live.watched.joinpath("plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    watch = live.watch("--security", "none", "--history", "8h", "--grace", "5s")
    watch.says("values of 3 tags came from the server's history")
    server.tell("play")
    wait_for(hour_is_there(live, 11), 60, "the hour before noon")
    assert watch.end() == 0
    noon = opcua.microseconds(capped.NOON)
    found = recorded(live.watched)
    for tag in capped.TAGS:
        own = [(noon + 2 * SECOND * (k - 12_000), capped.value_of(tag, k)) for k in range(12_000)]
        assert [each for each in found[tag] if each[0] < noon] == own, tag
    assert not any(gaps(live.watched).values())


def test_a_value_before_the_history_is_held_at_its_beginning(watched):
    from asyncua import ua
    from stiction.live.watch import Options, Watcher

    start = 1_772_409_600_000_000
    begin, now = start + 600 * SECOND, start + 1200 * SECOND
    of = lambda us, value, status=0: ua.DataValue(ua.Variant(value, ua.VariantType.Double), ua.StatusCode(status), opcua.EPOCH + timedelta(microseconds=us))  # noqa: E731

    class Server:
        async def history(self, nodes, at, until):
            yield 0, [of(start - 86_400 * SECOND, 1.0), of(begin + SECOND, 2.0), of(now, 0.0, 0x80D7_0000)]

    watcher = Watcher(Options("opc.tcp://127.0.0.1:1", watched, opcua.Security(), say=lambda _: None))
    watcher.names, watcher.last, watcher.types, watcher.bad, watcher.clock = ["A.MODE"], [0], {}, set(), now
    watcher.recorder = hours.Recorder(watched, watcher.names)
    asyncio.run(watcher._fill(Server(), {0: None}, {0: of(begin + SECOND, 2.0)}, [0], (0, begin, now)))
    watcher.recorder.release(1 << 62)
    hours.fold(watched, watched / "data")
    [(tag, rows)] = hours.tables_by_tag(hours.hour_file(watched / "data", start))
    assert list(zip(rows.time - begin, rows.value, rows.status)) == [(0, 1.0, hours.HELD), (SECOND, 2.0, 0), (now - begin, 2.0, hours.HELD)]


def test_a_misdated_value_is_not_stored(watched):
    from asyncua import ua
    from stiction.live.watch import Options, Watcher

    start = 1_772_409_600_000_000
    of = lambda us: ua.DataValue(ua.Variant(1.0, ua.VariantType.Double), SourceTimestamp=opcua.EPOCH + timedelta(microseconds=us))  # noqa: E731
    said = []
    watcher = Watcher(Options("opc.tcp://127.0.0.1:1", watched, opcua.Security(), say=said.append))
    watcher.names, watcher.last, watcher.types, watcher.bad, watcher.clock = ["A.PV"], [0], {}, set(), start
    watcher.recorder, watcher._first, watcher._floor = hours.Recorder(watched, watcher.names), set(), 0
    ahead = start + 700 * SECOND
    for at in (start - 8 * 86_400 * SECOND, start, ahead):
        watcher._values([(0, of(at))])
    # The clock is read again before a value is ahead of it.
    assert "is far behind the server's clock" in said[0] and len(said) == 1
    watcher._settle()
    # A gap begins.
    assert watcher.recorder.values == 2 and len(said) == 2 and "is ahead of the server's clock" in said[1]
    watcher._values([(0, of(ahead))])
    watcher.clock += 200 * SECOND
    watcher._settle()
    watcher.clock -= 200 * SECOND
    assert watcher.recorder.values == 3 and "is far behind the server's clock" in said[0]
    # While a recording is played, minutes pass between two readings of the clock.
    watcher.speed = 100.0
    watcher._values([(0, of(ahead + SECOND))])
    assert watcher.recorder.values == 4
    watcher.recorder.close()


def watcher_of(watched, names, clock, said):
    from stiction.live.watch import Options, Watcher

    watcher = Watcher(Options("opc.tcp://127.0.0.1:1", watched, opcua.Security(), say=said.append))
    watcher.tags, watcher.wall = dict.fromkeys(names, ""), lambda: watcher.clock / SECOND
    watcher.names, watcher.last, watcher.types, watcher.bad, watcher.clock = list(names), [-(1 << 62)] * len(names), {}, set(), clock
    watcher.recorder, watcher._first, watcher._floor = hours.Recorder(watched, watcher.names), set(), clock
    return watcher


def valued(us, value=1.0, status=0):
    from asyncua import ua

    return ua.DataValue(ua.Variant(value, ua.VariantType.Double), ua.StatusCode(status), SourceTimestamp=opcua.EPOCH + timedelta(microseconds=us))


def listed(watched, hour):
    path = hours.hour_file(watched / "data", hour)
    return {tag: list(zip(((own.time - hour) / SECOND).tolist(), own.status.tolist())) for tag, own in hours.tables_by_tag(path)} if path.exists() else {}


def test_a_source_whose_clock_stays_behind_rewrites_no_past_hour_and_is_reported(watched):
    start, said = 1_772_409_600_000_000 + 5 * hours.HOUR, []
    watcher = watcher_of(watched, ["A.PV", "A.OP"], start, said)
    # The clock of one source is right for a while, and then goes back by three hours.
    for second in range(0, 3600, 10):
        watcher.clock = start + second * SECOND
        behind = 3 * hours.HOUR if second >= 600 else 0
        watcher._values([(0, valued(watcher.clock - behind)), (1, valued(watcher.clock))])
        watcher._say_turned()
    watcher.recorder.flush()
    watcher.recorder.release(1 << 62)
    hours.fold(watched, watched / "data")
    assert [path.name for path in sorted((watched / "data").glob("*/*.parquet"))] == ["05.parquet"]
    own = listed(watched, start)
    assert own["A.OP"] == [(float(second), 0) for second in range(0, 3600, 10)]
    assert own["A.PV"] == [(float(second), 0) for second in range(0, 600, 10)] + [(590.000001, hours.LOST)]
    [line] = [line for line in said if "behind the server's clock" in line]
    assert "A.PV: values are dated 3.0 h behind the server's clock, and are not stored; correct the clock of the source" in line
    assert watcher.status()["misdating_tags"] == ["A.PV"] and watcher.status()["misdated"] == 300
    # The clock is put right.
    watcher._values([(0, valued(watcher.clock))])
    watcher._say_turned()
    assert "A.PV: values with right times again" in said[-1] and watcher.status()["misdating_tags"] == []
    watcher.recorder.close()


def test_a_source_that_is_behind_from_the_beginning_is_never_stored_in_the_past(watched):
    start, said = 1_772_409_600_000_000 + 5 * hours.HOUR, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    for second in range(0, 4 * 3600, 60):
        watcher.clock = start + second * SECOND
        watcher._values([(0, valued(watcher.clock - hours.HOUR))])
        watcher._say_turned()
    assert watcher.recorder.values == 0 and len(said) == 1
    watcher.recorder.close()


def test_values_that_come_late_and_catch_up_are_stored_at_their_times(watched):
    start, said = 1_772_409_600_000_000 + 5 * hours.HOUR, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    watcher._values([(0, valued(start))])
    # A device was cut off for half an hour, and delivers 3 values a second.
    for second in range(1200):
        watcher.clock = start + (1800 + second) * SECOND
        first = 1 + 3 * second
        times = [start + k * SECOND for k in range(first, first + 3) if start + k * SECOND <= watcher.clock]
        watcher._values([(0, valued(at)) for at in times])
        watcher._say_turned()
    assert watcher.counts["misdated"] == 0 and said == []
    watcher.recorder.flush()
    watcher.recorder.release(1 << 62)
    hours.fold(watched, watched / "data")
    assert [second for second, _ in listed(watched, start)["A.PV"]] == [float(k) for k in range(2700)]
    watcher.recorder.close()


def ticked(watcher, now):
    """What `_ticks` does with a reading of the server's clock; whether the connection ends."""
    watcher._compared = time.monotonic() - 1.0
    try:
        watcher._compare(now)
    except ConnectionError:
        return True
    watcher.clock = watcher._ticked = now
    watcher._alive()
    watcher.recorder.flush()
    return False


def test_after_a_jump_that_was_put_right_the_gap_is_known_and_wrong_times_are_taken_back(watched):
    start, said = 1_772_409_600_000_000, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    for second in range(1, 20):
        assert not ticked(watcher, start + second * SECOND)
        watcher._values([(0, valued(watcher.clock))])
    # The server's clock, and with it its values, jump by four hours, and back.
    for second in range(20, 25):
        assert not ticked(watcher, start + 4 * hours.HOUR + second * SECOND)
        watcher._values([(0, valued(watcher.clock))])
    assert watcher.jumps
    assert ticked(watcher, start + 25 * SECOND), "the connection ends, so that the next one fills the gap"
    assert watcher.until == start + 19 * SECOND and watcher.last == [start + 19 * SECOND] and watcher.jumps == []
    # A kill here, and a start later, find the same.
    watcher.recorder.close()
    assert hours.known(watched, start + hours.HOUR).until == start + 19 * SECOND
    hours.Recorder(watched, ["A.PV"]).release(1 << 62)
    hours.fold(watched, watched / "data")
    assert listed(watched, start)["A.PV"] == [(float(second), 0) for second in range(1, 20)]
    assert listed(watched, start + 4 * hours.HOUR).get("A.PV") in (None, [(0.0, hours.NONE)], [(0.0, hours.HELD)])
    assert any("jumped ahead by 4.0 h" in line for line in said) and any("went back by 4.0 h" in line for line in said)


def test_a_clock_that_goes_back_before_the_first_value_makes_no_file_of_1970(watched):
    start, said = 1_772_409_600_000_000, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    watcher.until = watcher.stored = 0
    watcher._take_back(start)
    watcher.recorder.close()
    assert hours.known(watched).until is None
    hours.Recorder(watched, ["A.PV"]).release(1 << 62)
    assert hours.fold(watched, watched / "data") == []


def test_a_clock_that_was_behind_for_a_time_leaves_a_gap_to_fill(watched):
    start, said = 1_772_409_600_000_000 + 5 * hours.HOUR, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    for second in range(1, 20):
        assert not ticked(watcher, start + second * SECOND)
    for second in range(20, 30):
        assert not ticked(watcher, start - hours.HOUR + second * SECOND)
    assert ticked(watcher, start + 30 * SECOND)
    assert watcher.until == start + 19 * SECOND == hours.known(watched, start + 30 * SECOND).until
    watcher.recorder.close()


def test_no_hour_is_handed_over_while_a_jump_may_be_undone(watched):
    start, said = 1_772_409_600_000_000, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    for second in range(1, 10):
        ticked(watcher, start + second * SECOND)
    ticked(watcher, start + 4 * hours.HOUR)
    assert [each[:2] for each in watcher.jumps] == [(start + 9 * SECOND, start + 4 * hours.HOUR)]
    watcher.recorder.close()


class Past:
    """A server with a history of the values of one tag, or without one."""

    def __init__(self, values):
        self.values, self.asked = values, []

    async def history(self, nodes, begin, end):
        self.asked.append((sorted(nodes), begin, end))
        for index in nodes:
            yield index, 0x8072_0000 if self.values is None else [value for value in self.values if begin <= opcua.microseconds(value.SourceTimestamp) <= end]


@pytest.mark.parametrize("kept", [True, False], ids=["history", "no history"])
def test_dropped_values_come_from_the_history_or_leave_a_gap(watched, kept):
    from asyncua import ua
    from stiction.live.watch import Options, Watcher, read_status

    start = 1_772_409_600_000_000

    def of(second, status=0):
        time = opcua.EPOCH + timedelta(microseconds=start + second * SECOND)
        return ua.DataValue(ua.Variant(float(second), ua.VariantType.Double), ua.StatusCode(status), SourceTimestamp=time)

    said = []
    watcher = Watcher(Options("opc.tcp://127.0.0.1:1", watched, opcua.Security(), say=said.append))
    watcher.names, watcher.last, watcher.types, watcher.bad, watcher.clock = ["A.PV"], [-(1 << 62)], {}, set(), start + 60 * SECOND
    watcher.recorder, watcher._first, watcher._floor = hours.Recorder(watched, watcher.names), set(), start
    server = Past([of(second) for second in range(30)] if kept else None)
    watcher._values([(0, of(1)), (0, of(2)), (0, of(5, opcua.OVERFLOW)), (0, of(6)), (0, of(9, opcua.OVERFLOW | 0x4000_0000))])
    # No hour ends before they were asked for, and a start after a kill asks for them.
    assert watcher._filled() == start + 2 * SECOND == read_status(watched)["fill_from"]

    async def refill():
        task = asyncio.create_task(watcher._refill(server, {0: None}))
        await asyncio.sleep(0)
        # Meanwhile the queue is full again.
        watcher._values([(0, of(12, opcua.OVERFLOW))])
        await task

    asyncio.run(refill())
    assert watcher._filled() == start + 9 * SECOND and "the server dropped values of A.PV, because its queue was full" in said[-1]
    asyncio.run(watcher._refill(server, {0: None}))
    assert watcher._filled() is None
    # Before the first value of a tag none is held, so there is no gap.
    watcher.last[0] = -(1 << 62)
    watcher._values([(0, of(20, opcua.OVERFLOW))])
    assert watcher._filled() == watcher._floor
    asyncio.run(watcher._refill(Past(None), {0: None}))
    assert watcher._filled() is None
    assert server.asked == [([0], start + 2 * SECOND, start + 9 * SECOND), ([0], start + 9 * SECOND, start + 12 * SECOND)]
    watcher.recorder.release(1 << 62)
    hours.fold(watched, watched / "data")
    [(_, rows)] = hours.tables_by_tag(hours.hour_file(watched / "data", start))
    found = [((int(time) - start) / SECOND, int(status)) for time, status in zip(rows.time, rows.status)]
    if kept:
        assert [(t, s) for t, s in found if s < 0x4000_0000] == [(second, 0) for second in [*range(1, 13), 20]]
    else:
        assert found == [(1, 0), (2, 0), (2 + 1e-6, hours.LOST), (5, 0), (6, 0), (9, 0x4000_0000), (9 + 1e-6, hours.LOST), (12, 0), (20, 0)]


def test_a_notification_left_out_is_filled_from_the_history(live):
    server = live.serve(*TWO_HOURS)
    watch = live.watch("--security", "none")
    watch.says("connected to")
    server.tell("play")
    wait_for(lambda: state(live).get("values", 0) > 1000, 30, "values")
    server.tell("skip")
    watch.says("the server skipped a notification")
    watch.says("came from the server's history")
    wait_for(all_judged(live, server), 120, "the judgement of all hours")
    assert watch.end() == 0
    assert recorded(live.watched) == of_plant(live.plant, server.info["begin"], server.info["end"])


class Cable:
    """A connection between a port and the server, which can be cut."""

    def __init__(self, to):
        self.to, self.port, self.cut = to, free_port(), False
        self.sockets = []
        self.own = socket.create_server(("127.0.0.1", self.port))
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                near, _ = self.own.accept()
            except OSError:
                return
            if self.cut:
                near.close()
                continue
            far = socket.create_connection(("127.0.0.1", self.to))
            self.sockets += [near, far]
            for a, b in ((near, far), (far, near)):
                threading.Thread(target=self._carry, args=(a, b), daemon=True).start()

    def _carry(self, a, b):
        try:
            while data := a.recv(65536):
                while self.cut:
                    time.sleep(0.05)
                b.sendall(data)
        except OSError:
            pass
        for each in (a, b):
            each.close()

    def close(self):
        self.own.close()
        self.cut = False
        for each in self.sockets:
            each.close()


@pytest.mark.parametrize("silent", [False, True], ids=["closed", "silent"])
def test_a_cut_connection_loses_nothing_with_a_history(live, silent):
    server = live.serve(*TWO_HOURS)
    cable = Cable(live.port)
    try:
        watch = live.watch("--security", "none", "--timeout", "2s", url=f"opc.tcp://127.0.0.1:{cable.port}")
        watch.says("connected to")
        server.tell("play")
        wait_for(lambda: state(live).get("values", 0) > 1000, 30, "values")
        cable.cut = True
        if not silent:
            for each in cable.sockets:
                with contextlib.suppress(OSError):
                    each.shutdown(socket.SHUT_RDWR)
        watch.says("no connection to")
        cable.cut = False
        watch.says("gap of")
        wait_for(all_judged(live, server), 120, "the judgement of all hours")
        assert watch.end() == 0
    finally:
        cable.close()
    assert recorded(live.watched) == of_plant(live.plant, server.info["begin"], server.info["end"])


def test_jumps_removed_tags_and_other_types_are_reported_and_store_no_wrong_value(live):
    server = live.serve("--speed", "300", "--last", "3600", "--no-history")
    watch = live.watch("--security", "none", "--check", "1s")
    watch.says("connected to")
    server.tell("play")
    wait_for(lambda: state(live).get("values", 0) > 500, 30, "values")
    server.tell("type FIC1002.PV")
    watch.says("FIC1002.PV: its type changed from Double to String")
    watch.says("FIC1002.PV: 'out of order' is neither a number")
    server.tell("remove LIC1003.PV")
    watch.says("LIC1003.PV: the server no longer knows it (BadNodeIdUnknown)")
    server.tell("jump 7200")
    watch.says("the server's clock jumped ahead by 2.")
    time.sleep(1.0)
    server.tell("jump -7200")
    watch.says("the server's clock went back by")
    wait_for(all_judged(live, server), 120, "the judgement of all hours")
    assert watch.end() == 0
    expected = of_plant(live.plant, server.info["begin"], server.info["end"])
    for tag, own in recorded(live.watched).items():
        known = set(own) - set(expected[tag])
        # The clock of the plant was wrong, its values were not.
        assert {(t - 7200 * SECOND, value) for t, value in known} <= set(expected[tag]), tag
    at = [t for tag, rows in hours.tables_by_tag(live.watched / "data/2026-03-02/00.parquet") if tag == "LIC1003.PV" for t in rows.time[rows.status == 0x8034_0000]]
    assert at, "a removed tag has no value from then on"


def test_secrets_and_certificates(live, tmp_path):
    secret = "Pa55-w0rd!"
    server = live.serve(*TWO_HOURS, "--encrypted", tmp_path / "server", "--user", f"operator:{secret}")
    env = os.environ | {"STICTION_OPCUA_USER": "operator", "STICTION_OPCUA_PASSWORD": secret}
    refused = live.watch(env=env)
    assert refused.process.wait(150) == 2
    assert wait_for(lambda: refused.log, 5) and "--make-certificate" in refused.log[-1]
    # The remedy works as it is written.
    remedy = refused.log[-1].partition("with: stiction ")[2].partition(",")[0].split()
    made = live.run("-m", "stiction.live", *remedy)
    assert made.process.wait(150) == 0
    unknown = live.watch(env=env)
    assert unknown.process.wait(150) == 2
    assert wait_for(lambda: unknown.log, 5) and "is not trusted; compare the SHA-256" in unknown.log[-1]
    certificates = live.watched / "certificates"
    [kept] = (certificates / "rejected").iterdir()
    kept.rename(certificates / "trusted" / kept.name)
    wrong = live.watch(env=env | {"STICTION_OPCUA_PASSWORD": "wrong" + secret})
    wrong.says("no connection to")
    assert wrong.end() == 0
    watch = live.watch(env=env)
    watch.says("encrypted by Aes256Sha256RsaPss")
    watch.says("connected to")
    server.tell("play")
    wait_for(hour_is_there(live, 0), 60, "the first hour")
    assert watch.end() == 0
    logs = [line for each in (refused, unknown, wrong, watch) for line in each.log + each.out]
    assert not [line for line in logs if secret in line]
    for path in Path(live.watched).rglob("*"):
        if path.is_file():
            assert secret.encode() not in path.read_bytes(), path
    assert stat.S_IMODE((certificates / "client.pem").stat().st_mode) == 0o600
    server.tell("requests")
    assert set(server.answer("requests")["requests"]) <= {kind.__name__ for kind in opcua.SERVICES}


def test_an_expired_certificate_is_refused_in_words(live, tmp_path):
    live.serve(*TWO_HOURS, "--encrypted", tmp_path / "server", "--certificate-days", "0")
    made = live.run("-m", "stiction.live", "watch", "--make-certificate", "-C", live.watched)
    assert made.process.wait(150) == 0
    watch = live.watch("--trust-first")
    assert watch.process.wait(150) == 2
    assert wait_for(lambda: watch.log, 5) and "renew it on the server" in watch.log[-1]


def test_an_open_server_needs_the_word_none(live):
    live.serve(*TWO_HOURS)
    watch = live.watch()
    assert watch.process.wait(150) == 2
    assert wait_for(lambda: watch.log, 5) and "--security none" in watch.log[-1]


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="a process cannot be halted here")
def test_a_signal_ends_it_while_the_server_and_the_receiver_are_silent(live):
    server = live.serve(*TWO_HOURS)
    own = live.watched / ".stiction"
    (own / "live").mkdir(parents=True)
    (own / "live/pushed.json").write_text('{"sent": 0}')
    (own / "events.jsonl").write_text('{"event": "x"}\n')
    with socket.create_server(("127.0.0.1", 0)) as receiver:
        address = live.watched / "webhook"
        address.write_text(f"http://127.0.0.1:{receiver.getsockname()[1]}/\n")
        watch = live.watch("--security", "none", "--timeout", "1h", "--webhook", f"@{address}")
        watch.says("connected to")
        connection, _ = receiver.accept()
        server.process.send_signal(signal.SIGSTOP)
        try:
            assert watch.end() == 0 and "stopped" in watch.log[-1]
        finally:
            server.process.send_signal(signal.SIGCONT)
            connection.close()


def test_lines_of_one_kind_are_counted(watched):
    said = []
    watcher = watcher_of(watched, [f"{k}.PV" for k in range(100)], 1_772_409_600_000_000, said)
    for _ in range(3):
        for k in range(100):
            watcher.say_once(f"type {k}", f"{k}.PV: its type changed")
    watcher.say_once("back", "the clock went back")
    assert len(said) == 21 and "left out" not in "".join(said)
    watcher._kinds = {kind: (begin - 601.0, *counts) for kind, (begin, *counts) in watcher._kinds.items()}
    watcher._said.clear()
    watcher.say_once("type 7", "7.PV: its type changed")
    assert said[-1].endswith("7.PV: its type changed (280 more of this kind were left out)")
    watcher.recorder.close()


def test_a_source_ahead_of_the_clock_begins_one_gap(watched):
    start, said = 1_772_409_600_000_000, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    for second in range(0, 600, 10):
        watcher.clock = start + second * SECOND
        watcher._values([(0, valued(watcher.clock + (hours.HOUR if second >= 300 else 0)))])
        watcher._settle()
    assert watcher.status()["misdating_tags"] == ["A.PV"] and len(said) == 1
    watcher.recorder.flush()
    watcher.recorder.release(1 << 62)
    hours.fold(watched, watched / "data")
    assert listed(watched, start)["A.PV"] == [(float(second), 0) for second in range(0, 300, 10)] + [(290.000001, hours.LOST)]
    watcher.recorder.close()


def test_a_jump_that_is_put_right_after_a_new_start_is_undone(watched):
    start, said = 1_772_409_600_000_000, []
    watcher = watcher_of(watched, ["A.PV"], start, said)
    for second in (*range(1, 20), *range(4 * 3600, 4 * 3600 + 5)):
        assert not ticked(watcher, start + second * SECOND)
        watcher._values([(0, valued(watcher.clock))])
    watcher.recorder.close()
    again = watcher_of(watched, ["A.PV"], start + 25 * SECOND, said)
    again.tags, jumps = {}, json.loads((watched / ".stiction/live/status.json").read_text())["jumps"]
    again.jumps = [tuple(each) for each in jumps]
    assert [each[:2] for each in again.jumps] == [(start + 19 * SECOND, start + 4 * hours.HOUR)]
    again.until = start + 4 * hours.HOUR + 4 * SECOND
    assert again._undo(again.clock) and again.until == start + 19 * SECOND and again.jumps == []
    again.recorder.release(1 << 62)
    hours.fold(watched, watched / "data")
    assert listed(watched, start)["A.PV"] == [(float(second), 0) for second in range(1, 20)]
    assert not listed(watched, start + 4 * hours.HOUR) or all(status != 0 for _, status in listed(watched, start + 4 * hours.HOUR)["A.PV"])


def test_a_flood_is_stored(live):
    server = live.serve("--speed", "1", "--last", "7200")
    watch = live.watch("--security", "none", "--grace", "0s", "--queue", "10000")
    watch.says("connected to")
    server.tell("flood 10000 3")
    answer = server.answer("flooded", 60)
    tags = server.info["tags"]
    wait_for(lambda: state(live).get("values", 0) >= answer["flooded"], 30, "all values")
    assert watch.end() == 0
    count = sum(path.stat().st_size for path in (live.watched / ".stiction/live/open").iterdir()) // hours.RECORD.itemsize
    assert count >= answer["flooded"] and tags > 10


def test_a_full_disk_is_reported_and_its_gap_is_filled(live):
    if os.geteuid() != 0 or os.system(f"mount -t tmpfs -o size=600k none {live.watched} 2>/dev/null") != 0:
        pytest.skip("a small disk needs root")
    try:
        (live.watched / "plant.toml").write_text((live.plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
        server = live.serve("--speed", "300", "--last", "3600")
        watch = live.watch("--security", "none")
        watch.says("connected to")
        server.tell("play")
        wait_for(lambda: state(live).get("values", 0) > 200, 30, "values")
        filler = live.watched / "filler"
        with contextlib.suppress(OSError), open(filler, "wb", buffering=0) as file:
            while file.write(bytes(4096)):
                pass
        watch.says("values cannot be stored (No space left on device)")
        time.sleep(1.0)
        filler.unlink()
        watch.says("values are stored again")
        watch.says("came from the server's history")
        server.answer("played")
        wait_for(lambda: (state(live).get("known_until") or 0) > 1e-6 * server.info["end"], 30, "the end")
        assert watch.end() == 0
        # What is still open is written here.
        recorder = hours.Recorder(live.watched, [])
        recorder.release(1 << 62)
        hours.fold(live.watched, live.watched / "data")
        assert recorded(live.watched) == of_plant(live.plant, server.info["begin"], server.info["end"] + 1)
    finally:
        os.system(f"umount -l {live.watched}")


def test_status_and_wrong_use(live):
    own = live.run("-m", "stiction.live", "watch", "--status", "-C", live.watched)
    assert own.process.wait(150) == 2 and wait_for(lambda: own.log, 5) and "stiction watch has never run here" in own.log[-1]
    live.serve(*TWO_HOURS)
    watch = live.watch("--security", "none")
    watch.says("connected to")
    second = live.watch("--security", "none")
    assert second.process.wait(150) == 2 and wait_for(lambda: second.log, 5) and "another stiction watch collects" in second.log[-1]
    wait_for(lambda: state(live).get("connected_since"), 20, "the state")
    own = live.run("-m", "stiction.live", "watch", "--status", "-C", live.watched)
    assert own.process.wait(150) == 0 and wait_for(lambda: len(own.out) > 2, 5) and "connected since" in own.out[0]
    assert watch.end() == 0
    own = live.run("-m", "stiction.live", "watch", "--status", "--json", "-C", live.watched)
    assert own.process.wait(150) == 1 and wait_for(lambda: own.out, 5) and json.loads(own.out[0])["connected_since"] is None
    (live.watched / "plant.toml").write_text('name = "N"\ndata = ["export/*.csv"]\n')
    wrong = live.watch("--security", "none")
    assert wrong.process.wait(150) == 2 and wait_for(lambda: wrong.log, 5) and "add \"data/**/*.parquet\"" in wrong.log[-1]


def test_a_plant_is_proposed_from_a_server_and_watched(live, tmp_path):
    live.watched = tmp_path / "new"
    absent = live.run("-m", "stiction.live", "init", live.url, "-C", live.watched, "--security", "none")
    assert absent.process.wait(150) == 2
    assert wait_for(lambda: len(absent.log) > 1, 5) and absent.log[-1].startswith(f"stiction: no connection to {live.url}: "), absent.log
    live.serve(*TWO_HOURS)
    made = live.run("-m", "stiction.live", "init", live.url, "-C", live.watched, "--security", "none")
    assert made.process.wait(150) == 0 and wait_for(lambda: made.out, 5) and made.out[0].startswith("6 loops")
    text = (live.watched / "plant.toml").read_text()
    assert 'data = ["data/**/*.parquet"]' in text and '[loop."FIC1002"]' in text and '# op = "FIC1002.OP"' in text
    assert '"FIC1002.PV" = "nsu=urn:stiction:played;s=FIC1002.PV"' in (live.watched / "live.toml").read_text()
    again = live.run("-m", "stiction.live", "init", live.url, "-C", live.watched, "--security", "none")
    assert again.process.wait(150) == 2 and wait_for(lambda: again.log, 5) and "--force overwrites it" in again.log[-1]
    watch = live.watch("--security", "none")
    watch.says("19 of 19 tags")
    assert watch.end() == 0
