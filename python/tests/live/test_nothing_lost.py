"""Whatever happens to the server, the connection, the clocks and the collector: a value that was offered is stored at its time, or a row
without a value begins a gap there and a line of the log says so. What was stored stays."""

import asyncio
import bisect
import random
from datetime import timedelta
from types import SimpleNamespace

import pytest

pytest.importorskip("asyncua")

from asyncua import ua
from stiction.live import hours, opcua, tags, watch

START = 1_772_409_600_000_000 + 40 * 60_000_000
SECOND = 1_000_000
NAMES = ("A.OP", "A.PV", "B.PV")
DURATION_S = 2 * 3600
KEEP_S = 400 * 86_400.0
PLANT = 'name = "N"\ndata = ["data/**/*.parquet"]\n'


class Virtual(asyncio.SelectorEventLoop):
    """A loop that does not wait, because its time goes on by itself."""

    def __init__(self):
        super().__init__()
        self.now, select = 0.0, self._selector.select

        def skipped(timeout):
            found = select(0)
            if not found:
                assert timeout is not None, "nothing is left to do"
                self.now += timeout
            return found

        self._selector.select = skipped

    def time(self):
        return self.now


class World:
    """A plant and its server: values, clocks, and what goes wrong."""

    def __init__(self, loop, own, has_history, sources_follow):
        self.loop, self.own, self.has_history, self.sources_follow = loop, own, has_history, sources_follow
        self.shift = self.computer_shift = 0
        self.out, self.servers, self.present = False, [], {}
        # The right times and values, those of the history, and the times that were sent by the right ones.
        self.truth, self.past, self.sent = {name: [] for name in NAMES}, {name: [] for name in NAMES}, {name: {} for name in NAMES}
        self.source_shift = dict.fromkeys(NAMES, 0)
        # Values still to be dropped of a tag, those that were, and those of which no server could tell any more.
        self.dropping, self.dropped, self.untold = dict.fromkeys(NAMES, 0), {name: [] for name in NAMES}, set()
        # Values that the history has at other times and nobody was connected to hear.
        self.unheard = {name: [] for name in NAMES}
        self.number = 0

    def true(self):
        return START + int(self.loop.now * SECOND)

    def clock(self):
        return self.true() + self.shift

    def present_at(self, name, time):
        own = self.truth[name]
        return own[max(0, bisect.bisect_right(own, (time, 1e300)) - 1)][1]

    def computer(self):
        return self.true() + self.computer_shift

    def value(self, at, number, status=0):
        return ua.DataValue(ua.Variant(float(number), ua.VariantType.Double), ua.StatusCode(status), SourceTimestamp=opcua.EPOCH + timedelta(microseconds=at))

    async def play(self):
        second = 0
        while True:
            await asyncio.sleep(1.0)
            second += 1
            items = []
            for k, name in enumerate(NAMES):
                # One tag changes seldom.
                if second % (10, 7, 300)[k] == 0:
                    self.number += 1
                    at = START + second * SECOND
                    self.truth[name].append((at, float(self.number)))
                    bisect.insort(self.past[name], (at + self.source_shift[name], float(self.number)))
                    sent = at + (self.shift if self.sources_follow else 0) + self.source_shift[name]
                    self.sent[name][at, float(self.number)] = sent
                    self.present[k] = self.value(sent, self.number)
                    if self.source_shift[name] and (self.out or not any(each.on_values for each in self.servers)):
                        self.unheard[name].append(float(self.number))
                    if self.dropping[name] > 0:
                        self.dropping[name] -= 1
                        self.dropped[name].append(float(self.number))
                        if self.dropping[name] == 0:
                            self.dropped[name].clear()
                            items.append((k, self.value(sent, self.number, opcua.OVERFLOW)))
                    else:
                        items.append((k, self.present[k]))
            for server in [each for each in self.servers if each.on_values and not self.out]:
                if items:
                    server.on_values([item for item in items if item[0] in server.nodes])
                server.on_alive()


class Server:
    """A connection to the world."""

    namespaces = ()

    def __init__(self, world):
        self.world, self.on_values, self.problem, self.nodes = world, None, None, {}
        world.servers.append(self)

    def check(self):
        if self.world.out or self.problem:
            raise ConnectionError(self.problem or "the network is down")

    async def connect(self):
        self.check()

    async def clock(self):
        await asyncio.sleep(0.01)
        self.check()
        return self.world.clock()

    def node_of(self, text):
        return int(text)

    async def subscribe(self, nodes, on_values, on_alive, **_):
        self.check()
        self.nodes = nodes
        first = [(k, self.world.present[k]) for k in nodes if k in self.world.present]
        for k, value in first:
            # The present value tells of the wrong clock of its source, unless this is right again.
            if value.Value.Value not in self.world.unheard[NAMES[k]]:
                self.world.untold.update(self.world.unheard[NAMES[k]])
            self.world.unheard[NAMES[k]].clear()
        on_values(first)
        self.on_values, self.on_alive = on_values, on_alive
        return {}

    async def read(self, nodes):
        self.check()
        return {k: self.world.present.get(k, ua.DataValue(StatusCode=ua.StatusCode(ua.StatusCodes.BadWaitingForInitialData))) for k in nodes}

    async def history(self, nodes, begin, end):
        for k in nodes:
            await asyncio.sleep(0.01)
            self.check()
            own = self.world.past[NAMES[k]]
            first = bisect.bisect_left(own, (begin, -1.0))
            found = own[max(0, first - 1) : bisect.bisect_right(own, (end, 1e300))]
            yield k, [self.world.value(*each) for each in found] if self.world.has_history else opcua.NO_HISTORY[0]

    def failed(self):
        return ConnectionError("the network is down") if self.world.out else None if not self.problem else ConnectionError(self.problem)

    async def close(self):
        self.on_values = None
        for name in NAMES:
            self.world.untold.update(self.world.dropped[name])
            self.world.dropped[name].clear()
        if self in self.world.servers:
            self.world.servers.remove(self)


def stored(folder):
    found = {name: [] for name in NAMES}
    for path in sorted((folder / "data").glob("*/*.parquet")):
        for tag, rows in hours.tables_by_tag(path):
            found[tag] += zip(rows.time.tolist(), rows.value.tolist(), rows.status.tolist())
    return found


class Trial:
    """A collector of a world, which is stopped, killed and started again."""

    def __init__(self, folder, seed, has_history, sources_follow, monkeypatch, events=None):
        self.folder, self.own, self.log, self.told = folder, random.Random(seed), [], []
        (folder / "plant.toml").write_text(PLANT)
        (folder / tags.NAME).write_text(tags.text_of({name: str(k) for k, name in enumerate(NAMES)}, "opc.tcp://host"))
        self.loop = Virtual()
        self.world = World(self.loop, self.own, has_history, sources_follow)
        fake = SimpleNamespace(monotonic=lambda: self.loop.now, time=lambda: self.world.computer() / SECOND)
        monkeypatch.setattr(watch, "time", fake)
        monkeypatch.setattr(watch.opcua, "Server", lambda *_, **__: Server(self.world))
        monkeypatch.setattr(hours.os, "fsync", lambda _: None)
        self.events = events if events is not None else sorted(self.chosen() for _ in range(self.own.randrange(1, 8)))
        self.before = {name: set() for name in NAMES}
        self.watcher, self.task = None, None
        # Of several wrong clocks, which one is put right cannot be known.
        self.jumping = asyncio.Lock()

    def chosen(self):
        own = self.own
        what = own.choice(["outage", "drop", "stop", "kill", "jump", "jump", "computer", "source"])
        lasting = own.choice([3, 40, 300, 1500])
        # The clock of a source that is behind by less is believed.
        jump = own.choice([-1, 1]) * own.choice([20, 90, 300, 700, 3000, 14_400, 500 * 86_400][3 * (what == "source") :])
        return own.randrange(60, DURATION_S - 1700), what, lasting, jump

    def start(self):
        said = lambda text: self.log.append((self.loop.now, text))  # noqa: E731
        self.watcher = watch.Watcher(watch.Options("opc.tcp://host", self.folder, opcua.Security(), say=said))
        self.task = self.loop.create_task(self.watcher._connections())

    async def end(self, kill):
        watcher, self.watcher = self.watcher, None
        if watcher is None:
            return
        if kill and hasattr(watcher, "recorder"):
            # What waits is lost, and nothing more is written.
            watcher.recorder._waiting.clear()
            watcher.recorder.flush = watcher._write_status = lambda *_, **__: None
        watcher.stopping.set()
        if kill:
            self.task.cancel()
        await asyncio.gather(self.task, return_exceptions=True)
        if hasattr(watcher, "recorder"):
            watcher.recorder.close()

    async def happen(self, what, lasting, jump):
        world = self.world
        self.told.append((int(self.loop.now), what, lasting, jump))
        if what == "outage":
            world.out = True
            await asyncio.sleep(lasting)
            world.out = False
        elif what == "drop":
            world.dropping[self.own.choice(NAMES)] = self.own.randrange(2, 6)
        elif what in ("stop", "kill"):
            await self.end(what == "kill")
            await asyncio.sleep(lasting)
            if self.watcher is None:
                self.start()
        elif what == "source":
            async with self.jumping:
                name = self.own.choice(NAMES)
                world.source_shift[name] += jump * SECOND
                await asyncio.sleep(lasting)
                world.source_shift[name] -= jump * SECOND
        elif what == "jump":
            async with self.jumping:
                world.shift += jump * SECOND
                await asyncio.sleep(lasting)
                world.shift -= jump * SECOND
                await asyncio.sleep(100.0)
        else:
            world.computer_shift += jump * SECOND
            await asyncio.sleep(lasting)
            world.computer_shift -= jump * SECOND

    async def judge(self):
        """Writes hours as they end, and removes what is too old."""
        while True:
            await asyncio.sleep(60.0)
            self.fold()

    def fold(self):
        done = hours.fold(self.folder, self.folder / "data")
        self.log += [(self.loop.now, note) for folded in done for note in folded.problems]
        now = hours.steady(self.folder, self.world.clock(), self.world.computer())
        removed = hours.retain(self.folder / "data", keep_s=KEEP_S, most_bytes=None, now=now)
        # What a clock dated that was far behind is older than that.
        assert all(hours._file_hour(path) < START - KEEP_S * SECOND for path in removed), self.told
        if not done:
            return
        for name, rows in stored(self.folder).items():
            own = {(at, value) for at, value, status in rows if status == 0} & set(self.world.truth[name])
            assert self.before[name] <= own, (name, self.told, sorted(self.before[name] - own)[:3])
            self.before[name] = own

    async def whole(self):
        playing, judging = asyncio.create_task(self.world.play()), asyncio.create_task(self.judge())
        await asyncio.sleep(30.0)
        self.start()
        happening = []
        for at, *what in self.events:
            await asyncio.sleep(max(0.0, at - self.loop.now))
            happening.append(asyncio.create_task(self.happen(*what)))
        await asyncio.gather(*happening)
        await asyncio.sleep(max(0.0, DURATION_S - self.loop.now))
        playing.cancel()
        await self.end(kill=False)
        judging.cancel()
        hours.Recorder(self.folder, NAMES).release(1 << 62)
        self.fold()

    def run(self):
        try:
            self.loop.run_until_complete(self.whole())
        finally:
            self.loop.close()

    def faults(self):
        """Values that are missing without a gap or a line, and values that never were."""
        found, faults = stored(self.folder), []
        lines = [text for _, text in self.log]
        for name, rows in found.items():
            sent = self.world.sent[name]
            truth = [(at, value) for at, value in self.world.truth[name] if START + 90 * SECOND <= at < START + (DURATION_S - 5) * SECOND]
            good = {(at, value) for at, value, status in rows if status == 0}
            offered = {value: {right, at} for (right, value), at in sent.items()}
            for at, value in self.world.past[name]:
                offered[value].add(at)
            false = sorted((at, value) for at, value in good if at not in offered.get(value, ()))
            if false:
                faults.append((name, "false", [(at - START) / SECOND for at, _ in false[:5]], len(false)))
            # What a wrong clock dated holds nothing. No collector can tell that the history holds a value of another time.
            right = {value: at for at, value in self.world.truth[name]}
            moved = {value for at, value in self.world.past[name] if right[value] != at}
            is_right = lambda at, value, status: (  # noqa: E731
                right.get(value) == at if status == 0 else value not in moved or value == self.world.present_at(name, at)
            )
            series = rows, [each for each in rows if is_right(*each)]
            missing, told = [], []
            for at, value in truth:
                # As a wrong clock dated it, or as the history dates it.
                if any((each, value) in good for each in offered[value]) or value in self.world.untold:
                    continue
                lasts = [own[k - 1][2] for own in series for each in offered[value] if (k := bisect.bisect_right(own, (each, 1e300, 0)))]
                (missing if lasts and max(lasts) < hours.BAD else told).append((at - START) / SECOND)
            if missing:
                faults.append((name, "lost without a gap", missing[:5], len(missing)))
            if told and not any("gap" in line or "not stored" in line or "dropped" in line or "clock" in line for line in lines):
                faults.append((name, "lost without a line", told[:5], len(told)))
            if told and self.world.has_history and not any(what == "source" for _, what, *_ in self.told):
                faults.append((name, "has a history", told[:5], len(told)))
        return faults


# Later ones are of faults that were found.
@pytest.mark.parametrize("seed", [*range(8), 85, 101, 116, 128, 152, 153, 158, 185])
def test_any_sequence_of_faults_leaves_each_value_or_a_gap_and_a_line(tmp_path, monkeypatch, seed):
    trial = Trial(tmp_path, seed, seed % 2 == 0, seed // 2 % 2 == 0, monkeypatch)
    trial.run()
    assert trial.faults() == [], trial.told


@pytest.mark.parametrize("ends", ["stop", "kill", "outage"])
def test_a_value_from_before_a_gap_is_not_held_after_it(tmp_path, monkeypatch, ends):
    """The clock of a source is behind, so its values are not stored, and the last one of the history is older than the gap."""
    trial = Trial(tmp_path, 1, True, True, monkeypatch, [(2655, "source", 1500, -3000), (2741, ends, 300, 0)])
    trial.run()
    assert trial.faults() == [], trial.told


@pytest.mark.parametrize("has_history", [False, True])
def test_a_clock_that_was_far_behind_leaves_a_gap_though_the_collector_was_stopped_meanwhile(tmp_path, monkeypatch, has_history):
    trial = Trial(tmp_path, 1, has_history, True, monkeypatch, [(360, "jump", 1500, -500 * 86_400), (518, "stop", 300, 0)])
    trial.run()
    assert trial.faults() == [], trial.told


def test_a_source_whose_clock_goes_back_while_the_collector_is_stopped_leaves_a_gap(tmp_path, monkeypatch):
    trial = Trial(tmp_path, 1, True, False, monkeypatch, [(586, "stop", 1500, 0), (1617, "source", 1500, -500 * 86_400)])
    trial.run()
    assert trial.faults() == [], trial.told


def test_a_start_that_finds_no_server_forgets_nothing_of_the_run_before(tmp_path, monkeypatch):
    """The clock of the server is wrong when the collector is killed, and the server is down when it starts again."""
    trial = Trial(tmp_path, 1, True, True, monkeypatch, [(2910, "jump", 1500, 3000), (4017, "kill", 1500, 0), (5338, "outage", 300, 0)])
    trial.run()
    assert trial.faults() == [], trial.told


def test_values_of_sources_that_are_ahead_of_the_server_come_from_the_history_after_an_outage(tmp_path, monkeypatch):
    trial = Trial(tmp_path, 1, True, False, monkeypatch, [(726, "outage", 300, 0), (900, "jump", 1500, -20)])
    trial.run()
    assert trial.faults() == [], trial.told


def test_a_present_value_that_a_wrong_clock_dated_ahead_does_not_move_a_later_gap(tmp_path, monkeypatch):
    trial = Trial(tmp_path, 152, True, True, monkeypatch, [(1819, "jump", 1500, 300), (1989, "source", 40, 3000)])
    trial.run()
    assert trial.faults() == [], trial.told


@pytest.mark.parametrize("has_history", [False, True])
@pytest.mark.parametrize("jump", [-3000, -500 * 86_400])
def test_what_a_server_dropped_before_its_clock_went_back_is_in_the_gap(tmp_path, monkeypatch, has_history, jump):
    """The seldom tag loses values, the server tells of it with the next value, and its clock goes back between."""
    trial = Trial(tmp_path, 5, has_history, True, monkeypatch, [(3451, "drop", 3, 0), (4246, "jump", 1500, jump)])
    trial.run()
    assert trial.faults() == [], trial.told
