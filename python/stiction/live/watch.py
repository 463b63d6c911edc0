"""Collects the values of a plant from an OPC UA server, and starts a judgement every hour.

The server's clock decides when an hour is over, so a server that replays a recording works like a plant. A broken connection is
made again. The missed values come from the server's history, if the server has a history. Otherwise a gap remains.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import os
import random
import re
import signal
import statistics
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from stiction import _core
from stiction.live import history, hours, opcua, push, tags
from stiction.live.clocks import Belief, SourceClocks
from stiction.live.errors import Refused
from stiction.live.words import number_of

__all__: list[str] = []

US = 1_000_000
FRESH = 60 * US
"""Age above which a value at the beginning of a connection is stored as held, at the time of the connection."""
AHEAD = 600 * US
"""Largest lead over the server's clock of the time of a stored value."""
LATE = 600 * US
"""Delay behind the server's clock above which a new value is late, or the source of the value has a wrong clock."""
BEHIND = 7 * 86_400 * US
"""Largest delay behind the server's clock of the time of a stored new value."""
CHUNK = 6 * hours.HOUR
"""Duration of the parts in which history is read. Short parts complete the first hours soon."""
AGAIN_S = 30.0
"""Seconds until hours whose judgement failed are judged again."""
LONGEST_PAUSE = 60.0
"""Longest time between two attempts to connect, s."""
LASTING_S = 60.0
"""Duration of a connection, s, after which the next attempt to connect comes soon."""
DOUBT = hours.HOUR
"""Time by the server's clock after a jump of this clock in which no later hour is judged, because the clock may go back."""
LAST_WAIT_S = 2.0
"""Longest time for which a stop waits for the server, s. A stop then waits equally long for the judgement and the webhook."""
PROGRESS_S = 50.0
"""Seconds between two lines on the progress of reading a history."""
MOST_LINES = 20
"""Maximum number of lines of one kind in `KIND_S` seconds; further lines are only counted."""
KIND_S = 600.0


@dataclass
class Options:
    """The settings of a watch."""

    url: str
    plant: Path
    security: opcua.Security
    history_s: float = 0.0
    publish_s: float = 1.0
    sample_s: float = 1.0
    grace_s: float = 120.0
    queue: int = 600
    keep_s: float | None = 400 * 86_400.0
    most_bytes: float | None = None
    time_limit_s: int | None = None
    timeout_s: float = 10.0
    check_s: float = 60.0
    webhook: str | None = None
    metrics: str | None = None
    say: Callable[[str], None] = field(default=lambda text: print(text, file=sys.stderr, flush=True))
    emit: Callable[[str], None] = field(default=lambda line: print(line, flush=True))


def matches(pattern: str, path: str) -> bool:
    """Whether a pattern of ``plant.toml`` matches a path."""
    parts = re.split(r"(\*\*/|\*|\?)", pattern)
    known = {"**/": "(?:.*/)?", "*": "[^/]*", "?": "[^/]"}
    return re.fullmatch("".join(known.get(part, re.escape(part)) for part in parts), path) is not None


class Watcher:
    """Collects and judges the values of a plant until a stop."""

    def __init__(self, options: Options) -> None:
        self.options = options
        self._said: dict[str, float] = {}
        # Of a kind of lines: since when they are counted, how many were written, and how many were left out since the last one.
        self._kinds: dict[str, tuple[float, int, int]] = {}
        folder = options.plant
        path = folder / "plant.toml"
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            proposal = f"stiction plant -C {folder} init {options.url}"
            raise Refused(f"{path}: {error.strerror}; write it, or have it proposed: {proposal}") from None
        try:
            self.file = _core.Plant(text, str(path))
        except ValueError as error:
            raise Refused(str(error)) from None
        self.data = options.plant / "data"
        sample = "data/2026-03-02/05.parquet"
        if not any(matches(pattern, sample) for pattern in self.file.data):
            raise Refused(f'{path}, data: does not name the files of the hours, such as {sample}; add "data/**/*.parquet"')
        self.tags: dict[str, str] = {}
        self.modes = tags.mode_words(text)
        self.server: opcua.Server | None = None
        self.recorder: hours.Recorder
        self.stopping = asyncio.Event()
        self.judging, self.is_judging = asyncio.Event(), False
        self.pusher = push.Pusher(options.plant, options.webhook, self.say)
        # The server's clock, the time up to which all values are stored, and the start of what is still to be filled in.
        self.clock = 0
        self.until = self.stored = 0
        self.fill_from: int | None = None
        # What the server dropped of a tag: after a time, and before another. And the first of these times.
        self.dropped: dict[int, tuple[int, int]] = {}
        self.dropped_from: int | None = None
        self.filling: asyncio.Task[None] | None = None
        self.began = time.time()
        self.connected_since: float | None = None
        self.full = False
        self.counts = {"values": 0, "misdated": 0, "gaps": 0, "connections": 0, "windows": 0, "scans": 0}
        self.result: dict[str, Any] = {}
        self._rate: deque[tuple[float, int]] = deque(maxlen=60)
        self._steps: deque[float] = deque(maxlen=20)
        self._early: list[tuple[int, Any]] = []
        # How fast the server's clock runs: 1, or more while it plays a recording.
        self.speed, self._compared = 1.0, 0.0
        self._speeds: deque[float] = deque(maxlen=20)
        self._told_difference: float | None = None
        self._turned: dict[str, list[int]] = {}
        self.clocks, self.wall = SourceClocks(), time.monotonic
        # Tags whose values are not stored because of their times.
        self.misdating: set[int] = set()
        # When the last gap of a tag began because of them.
        self.lost: dict[int, int] = {}
        # When an older value of a tag was last stored as still valid.
        self.held: dict[int, int] = {}
        # The server's clock before and after its last jumps ahead, and this computer's clock.
        self.jumps: list[tuple[int, int, int]] = []
        # The server's clock before and after it last went back, from when on values are asked for again when it is right, and this
        # computer's clock.
        self.back: tuple[int, int, int, int] | None = None
        # Of each tag, the last time that this connection stored before.
        self._before_back: list[int] = []
        # Whether the gap to be filled is that of a wrong clock.
        self.was_wrong = False
        # After a wrong clock: up to when a present value is believed.
        self._ceiling = 1 << 62
        # What an earlier run left open. An attempt to connect that fails states it again.
        status = read_status(folder) or {}
        self.fill_from = status.get("fill_from")
        self.jumps = [tuple(each) for each in status.get("jumps") or ()]
        back = status.get("back")
        self.back = (back[0], back[1], back[2], back[3]) if back and len(back) == 4 else None

    # What a person reads.

    def say(self, text: str) -> None:
        """Write a line of the log."""
        self.options.say(f"{datetime.now(timezone.utc):%Y-%m-%d %H:%M:%S} {text}")

    def say_once(self, key: str, text: str, again_s: float = 600.0) -> None:
        """Write a line unless the last minutes had a line with this key, or many lines of this kind (the first word of the key).
        The next line states how many were left out.
        """
        now, kind = time.monotonic(), key.partition(" ")[0]
        begin, lines, left_out = self._kinds.get(kind, (now, 0, 0))
        if now - begin >= KIND_S:
            begin, lines = now, 0
        if now - self._said.get(key, -math.inf) < again_s or lines >= MOST_LINES:
            self._kinds[kind] = begin, lines, left_out + (again_s < math.inf)
            return
        if len(self._said) > 10_000:
            self._said.clear()
        self._said[key], self._kinds[kind] = now, (begin, lines + 1, 0)
        self.say(f"{text} ({left_out} more of this kind were left out)" if left_out else text)

    # The whole.

    async def run(self) -> int:
        """Watch until a signal comes."""
        loop = asyncio.get_running_loop()
        for name in ("SIGTERM", "SIGINT"):
            with contextlib.suppress(NotImplementedError, RuntimeError):
                loop.add_signal_handler(getattr(signal, name), self.stopping.set)
        with hours.alone(self.options.plant, "lock", f"another stiction watch collects for {self.options.plant}; stop it first"):
            helpers = [asyncio.create_task(self._judge()), asyncio.create_task(self.pusher.run())]
            if self.options.metrics:
                helpers.append(await push.serve(self.options.metrics, self.metrics, self.say))
            connections, stop = asyncio.create_task(self._connections()), asyncio.create_task(self.stopping.wait())
            try:
                await asyncio.wait({connections, stop}, return_when=asyncio.FIRST_COMPLETED)
                # A server that is silent is not waited for.
                await asyncio.wait({connections}, timeout=LAST_WAIT_S)
                if connections.done():
                    connections.result()
            finally:
                for helper in (connections, stop, *helpers):
                    helper.cancel()
                await asyncio.wait({connections, stop, *helpers}, timeout=LAST_WAIT_S)
                if hasattr(self, "recorder"):
                    with contextlib.suppress(OSError):
                        self.recorder.close()
                self._write_status()
        self.say("stopped")
        return 0

    async def _connections(self) -> None:
        pause, last = 1.0, ""
        while not self.stopping.is_set():
            self.server = opcua.Server(
                self.options.url, self.options.security, timeout=self.options.timeout_s, say=lambda text: self.say_once(f"server {text}", text, math.inf)
            )
            try:
                await self._connection(self.server)
            except Refused as error:
                if not self.counts["connections"]:
                    raise
                problem = str(error)
            except asyncio.CancelledError:
                raise
            except Exception as error:
                problem = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
            else:
                problem = ""
            finally:
                if self.connected_since is not None and time.time() - self.connected_since > LASTING_S:
                    pause, last = 1.0, ""
                self.connected_since = None
                with contextlib.suppress(OSError):
                    if hasattr(self, "recorder"):
                        self.recorder.flush()
                await self.server.close()
                self._write_status()
            if self.stopping.is_set():
                return
            # Not all collectors of a plant come back at the same moment.
            seconds = pause * random.uniform(0.8, 1.2)
            if problem != last:
                self.say(f"no connection to {self.options.url}: {problem}; next attempt in {seconds:.0f} s")
                last = problem
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self.stopping.wait(), seconds)
            pause = min(2.0 * pause, LONGEST_PAUSE)

    async def _connection(self, server: opcua.Server) -> None:
        """Collect from the start of a connection until an exception or the signal to stop ends it."""
        await server.connect()
        self.clock = await server.clock()
        if not hasattr(self, "recorder"):
            await self._begin(server)
        names = list(self.tags)
        nodes = {k: node for k, name in enumerate(names) if (node := server.node_of(self.tags[name])) is not None}
        for k in range(len(names)):
            if k not in nodes:
                self.say_once(f"space {names[k]}", f"{names[k]}: the server has no namespace of {self.tags[names[k]]}")
        self._believe(hours.known(self.options.plant, self.clock + AHEAD) if self.until > self.clock + AHEAD else None)
        self._undo(self.clock)
        if (back := self.back) is not None and self.clock >= back[0] and self._is_undone(self.clock, back[0], back[1], back[3]):
            # It was set right while there was no connection.
            self._set_right(back)
        gap = min(filter(None, (self.until, self._filled())), default=0)
        gap = min(gap, self.clock)
        self._first = set(nodes)
        self._floor, self._ceiling = gap or self.clock - FRESH, self.clock if self.was_wrong else 1 << 62
        self._ticked, self._early, self._before_back = 0, [], []
        last = list(self.last) if gap else [0] * len(self.last)
        refused = await server.subscribe(
            nodes,
            self._values,
            self._alive,
            publish_s=self.options.publish_s,
            sample_s=self.options.sample_s,
            queue=self.options.queue,
        )
        for k, code in refused.items():
            self.say_once(f"refused {k}", f"{names[k]}: the server does not monitor it ({opcua.code_name(code)})")
        self.counts["connections"] += 1
        self.connected_since = time.time()
        good = len(nodes) - len(refused)
        self.say(f"connected to {self.options.url}: {good} of {len(names)} tags")
        self._write_status()
        # Until the subscription was there, values may have changed more than once.
        begin = gap or self.clock - int(self.options.history_s * US)
        self.clock = await server.clock()
        present = await server.read(nodes)
        if gap:
            self.counts["gaps"] += 1
            self.say(f"gap of {span(self.clock - gap)}, from {hours.shown(gap)} to {hours.shown(self.clock)} by the server's clock")
        self.fill_from = begin if begin < self.clock else None
        self.filling = asyncio.create_task(self._fill(server, nodes, present, last, (gap, begin, self.clock)))
        try:
            await self._ticks(server, nodes)
        finally:
            self.filling.cancel()
            await asyncio.gather(self.filling, return_exceptions=True)

    async def _begin(self, server: opcua.Server) -> None:
        """Finds the tags and the state that earlier runs left."""
        self.tags = await tags.of_plant(self.options.plant, self.file, server, self.say)
        self.names = list(self.tags)
        place = {name: k for k, name in enumerate(self.names)}
        known = hours.known(self.options.plant, self.clock + AHEAD)
        until = known.until
        self.last = [-(1 << 62)] * len(self.names)
        for name, at in known.last.items():
            if name in place:
                self.last[place[name]] = at
        self.lost = {place[name]: at for name, at in known.lost.items() if name in place}
        self.types: dict[int, Any] = {}
        self.bad: set[int] = set()
        self.until = self.stored = until or 0
        # If the clock went back, what was stored before is later than all that is known.
        if not until:
            self.fill_from, self.jumps = None, []
        self.recorder = hours.Recorder(self.options.plant, self.names)
        self.recorder.sequence = hours.known(self.options.plant).sequence

    def _believe(self, known: hours.Known | None) -> None:
        """Voids times that a wrong clock of the server gave."""
        if known is not None:
            was, self.until = self.until, known.until or self.clock
            self.stored = self.until
            self.last = [min(at, self.until) for at in self.last]
            self.say(
                f"the server's clock is {hours.shown(self.clock)}, and was {hours.shown(was)} before; values are stored up to "
                f"{hours.shown(self.until)}"
            )

    # Values.

    def _values(self, items: Sequence[tuple[int, Any]]) -> None:
        """Stores the values of a notification."""
        try:
            for index, value in items:
                if 0 <= index < len(self.names):
                    self._value(index, value, live=True)
                else:
                    self.say_once("handle", f"the server sent a value of a tag without a subscription (handle {index}); it was not stored")
        except OSError as error:
            self._cannot_store(error)

    def _cannot_store(self, error: OSError) -> None:
        # What waited for the write is lost, too.
        self.until = min(self.until, self.stored)
        self.last = [min(at, self.until) for at in self.last]
        if not self.full:
            self.full = True
            self.say(f"values cannot be stored ({error.strerror}), and are missing until then; free space on the disk")

    def _settle(self) -> None:
        """Judges values that were ahead of the last clock reading, with the present reading."""
        early, self._early = self._early, []
        for index, value in early:
            self._value(index, value, live=True, settled=True)

    def _value(self, index: int, value: Any, live: bool, settled: bool = False) -> None:
        status = value.StatusCode.value if value.StatusCode is not None else 0
        at = value.SourceTimestamp
        if at is None or at.year <= 1970:
            at = value.ServerTimestamp
            if at is not None and at.year <= 1970:
                at = None
        if at is None:
            self.say_once(f"timeless {index}", f"{self.names[index]}: its values have no time; the server's clock is used")
        moment = self.clock if at is None else opcua.microseconds(at)
        if live and index in self._first:
            self._first.discard(index)
            if moment <= self._floor or moment > self._ceiling:
                return  # It was stored when it changed, or is stored as held.
        # The time of most values is near the server's clock, and nothing is known against their source.
        is_near = -AHEAD <= self.clock - moment <= LATE
        is_usual = is_near and index not in self.misdating and not self.clocks.was_late(index)
        if not is_usual and not self._is_dated_rightly(index, value, moment, live, settled):
            return
        if status & opcua.OVERFLOW == opcua.OVERFLOW:
            if live:
                self._drop(index, moment)
            # It is not about this value.
            status &= ~(opcua.OVERFLOW if status & 0x3FF == 0x80 else 0x80)
        number = self._number(index, value, status)
        if math.isnan(number) and status < hours.BAD:
            status = 0x8074_0000  # BadTypeMismatch
        if live:
            bad = status >= hours.BAD
            if bad and index not in self.bad:
                self.bad.add(index)
                self._turned.setdefault(f"bad value ({opcua.code_name(status)})", []).append(index)
            elif not bad and index in self.bad:
                self.bad.discard(index)
                self._turned.setdefault("good values again", []).append(index)
        if self.full:
            return
        self.recorder.add(index, moment, number, status)
        if moment > self.last[index]:
            self.last[index] = moment

    def _is_dated_rightly(self, index: int, value: Any, moment: int, live: bool, settled: bool) -> bool:
        """Whether a value with an unusual time, or from a source with unusual times, is stored now. If not, a gap begins."""
        latest = self.clock + int(AHEAD * self.speed)
        if live and moment > latest and not settled:
            # The last reading of the clock may be an old one.
            self._early.append((index, value))
            return False
        if moment > latest or (live and moment < self.clock - BEHIND):
            self.counts["misdated"] += 1
            side = "ahead of" if moment > self.clock else "far behind"
            self.say_once(
                f"{side} {index}",
                f"{self.names[index]}: a value of {hours.shown(moment)} is {side} the server's clock ({hours.shown(self.clock)}) and was "
                "not stored; correct the clock of the source",
            )
            if live:
                self._misdate(index)
            return False
        if live and not self._is_believed(index, moment):
            self.counts["misdated"] += 1
            return False
        return True

    def _is_believed(self, index: int, moment: int) -> bool:
        """Whether a value's time can be right. If not, a gap begins."""
        known = max(self.last[index], self._floor)
        # A recording that is played runs fast, and has begun to a moment ago.
        fastest = max(self._speeds, default=1.0)
        belief = self.clocks.judge(index, moment, self.clock, known, int(LATE * max(self.speed, fastest)), self.wall())
        if belief in (Belief.RIGHT, Belief.LATE):
            if index in self.misdating and belief is Belief.RIGHT:
                self.misdating.discard(index)
                self._turned.setdefault("values with right times again", []).append(index)
            return True
        if self._misdate(index):
            what = (
                f"values are dated {span(self.clock - moment)} behind the server's clock, and are not stored; correct the clock of the source"
            )
            self._turned.setdefault(what, []).append(index)
        return False

    def _misdate(self, index: int) -> bool:
        """Begins a gap of a tag whose values are not stored, and returns whether values were stored until now."""
        is_new = index not in self.misdating
        self.misdating.add(index)
        last = max(self.last[index], self.held.get(index, 0))
        # A connection may have stored a present value in the midst of it.
        if last >= max(1, self.lost.get(index, 0)) and not self.full:
            self.lost[index] = last + 1
            self.recorder.add(index, last + 1, math.nan, hours.LOST)
        return is_new

    def _number(self, index: int, value: Any, status: int) -> float:
        """The value as a number; NaN for a bad value or a value without a number."""
        if status >= hours.BAD or value.Value is None:
            return math.nan
        kind, content = value.Value.VariantType, value.Value.Value
        known = self.types.setdefault(index, kind)
        if kind is not known:
            self.types[index] = kind
            self.say_once(f"type {index}", f"{self.names[index]}: its type changed from {known.name} to {kind.name}")
        number = number_of(content, self.modes)
        if not math.isnan(number) or isinstance(content, float):
            return number
        self.say_once(
            f"kind {index}", f"{self.names[index]}: {str(content)[:40]!r} is neither a number nor a known mode; the value was stored as bad", 3600.0
        )
        return math.nan

    def _alive(self) -> None:
        """Records that all values up to the last clock reading have arrived."""
        if self._ticked > self.until and not self.full:
            self.until = self._ticked
            with contextlib.suppress(OSError):
                self.recorder.mark(self.until)

    # Gaps.

    def _filled(self) -> int | None:
        """The time from which values may still come from the server's history; None if no gap is open."""
        return min(filter(None, (self.fill_from, self.dropped_from)), default=None)

    def _drop(self, index: int, before: int) -> None:
        """Records that the server dropped values of a tag between the last value and this time."""
        after = self.last[index] if self.last[index] > 0 else self._floor
        after = self.dropped.get(index, (after, 0))[0]
        if self.back is not None and self._before_back:
            # It may have dropped them before its clock went back.
            clock, now, begin, computer = self.back
            if (last := max(self._before_back[index], self._floor)) < begin:
                self.back = clock, now, last, computer
                self._write_status()
        if before <= after:
            return  # They came from the history already.
        self.dropped[index] = (after, before)
        if self.dropped_from is None or after < self.dropped_from:
            self.dropped_from = after
            # A start after kill -9 finds it there.
            self._write_status()

    async def _refill(self, server: opcua.Server, nodes: Mapping[int, Any]) -> None:
        """Reads dropped values from the server's history, and marks the remaining gaps."""
        dropped, found = dict(self.dropped), dict.fromkeys(self.dropped, 0)
        begin, end = min(after for after, _ in dropped.values()), max(before for _, before in dropped.values())
        async for index, values in server.history({k: nodes[k] for k in dropped if k in nodes}, begin, end):
            after, before = dropped[index]
            if isinstance(values, history.Unread):
                self._unread(index, values)
                continue
            for value in [] if isinstance(values, int) else values:
                at = after - 1 if value.SourceTimestamp is None else opcua.microseconds(value.SourceTimestamp)
                if after <= at < before:
                    self._value(index, value, live=False)
                    found[index] += at > after
            await asyncio.sleep(0)
        # Without a value before them, none is held.
        lost = [index for index, count in found.items() if not count and dropped[index][0] != self._floor]
        for index in lost:
            after, before = dropped[index]
            held = self.held.get(index, 0)
            self.recorder.add(index, 1 + (held if after < held < before else after), math.nan, hours.LOST)
        self.recorder.flush()
        for index, (_, before) in dropped.items():
            if self.dropped[index][1] == before:
                del self.dropped[index]
            else:
                # More was dropped meanwhile.
                self.dropped[index] = (before, self.dropped[index][1])
        self.dropped_from = min((after for after, _ in self.dropped.values()), default=None)
        count = sum(found.values())
        came = f"{count} values came from its history" if count else "none of them is in its history"
        stays = f", and a gap remains in {self._some(lost)}" if lost else ""
        self.say_once("dropped", f"the server dropped values of {self._some(list(dropped))}, because its queue was full; {came}{stays}", 60.0)

    async def _fill(
        self,
        server: opcua.Server,
        nodes: Mapping[int, Any],
        present: Mapping[int, Any],
        last: Sequence[int],
        times: tuple[int, int, int],
    ) -> None:
        """Reads missing values from the server's history, and marks the remaining gaps."""
        gap, begin, now = times
        # A source whose clock is ahead of the server's has values after its present moment.
        limit = now + int(AHEAD * self.speed)
        end = max([now, *(at for at in map(_moment_of, present.values()) if at is not None and at <= limit)])
        found: dict[int, int] = {}
        without: dict[int, int] = {}
        # The last value of a tag in the history, and its time.
        newest: dict[int, tuple[int, Any]] = {}
        told = time.monotonic()
        if begin < now:
            at = begin
            while at < end:
                until = min(at - at % CHUNK + CHUNK, end)
                asked = {k: node for k, node in nodes.items() if k not in without}
                # The value at the seam comes with the next part.
                async for index, values in server.history(asked, at, until - (until < end)):
                    if isinstance(values, int):
                        without[index] = values
                        continue
                    if isinstance(values, history.Unread):
                        self._unread(index, values)
                        continue
                    for value in values:
                        self._past(index, value, begin)
                    # A later one may be newer than the present value.
                    value = next((each for each in reversed(values) if _is_value(each) and _is_until(each, now)), None)
                    if value is not None and (moment := opcua.microseconds(value.SourceTimestamp)) >= newest.get(index, (moment,))[0]:
                        newest[index] = moment, value
                    found[index] = found.get(index, 0) + sum(_is_value(value) for value in values)
                    if time.monotonic() - told > PROGRESS_S:
                        told = time.monotonic()
                        self.say(f"the server's history is read up to {hours.shown(at)}: {sum(found.values())} values so far")
                    await asyncio.sleep(0)
                self.recorder.flush()
                self.fill_from = at = until
            count, tags_ = sum(found.values()), sum(1 for each in found.values() if each)
            if count:
                self.say(f"{count} values of {tags_} tags came from the server's history")
            if without:
                why = opcua.code_name(next(iter(without.values())))
                self.say(f"the server has no history of {len(without)} tags ({why})")
        lost = 0
        for index, value in present.items():
            source = _moment_of(value)
            moment = now if source is None else source
            status = value.StatusCode.value if value.StatusCode is not None else 0
            if gap and not found.get(index) and (self.was_wrong or moment > max(gap, last[index])):
                # It has changed meanwhile, perhaps more than once. A wrong clock may have dated it before.
                self.recorder.add(index, max(gap, last[index]) + 1, math.nan, hours.LOST)
                lost += 1
            elif gap and moment < newest.get(index, (moment,))[0] and value.Value != newest[index][1].Value:
                # The clock of its source was set back, and the history has what followed at other times.
                self.recorder.add(index, max(gap, newest[index][0]) + 1, math.nan, hours.LOST)
                lost += 1
            if status >= hours.BAD:
                self.recorder.add(index, now, math.nan, status)
            elif self._ceiling < moment <= now:
                self._value(index, value, live=False)
            elif now - moment > FRESH or moment > self._ceiling:
                self._hold(index, value, now)
        for index in range(len(self.names)):
            if index not in nodes:
                self.recorder.add(index, now, math.nan, 0x8034_0000)  # BadNodeIdUnknown
        if lost:
            self.say(f"the gap remains in {lost} tags that have neither values nor held values")
        self.recorder.flush()
        self.fill_from, self.was_wrong = None, False

    def _unread(self, index: int, part: history.Unread) -> None:
        """Reports a part of the history that was not read completely, and marks the part as a gap."""
        self.say_once(
            f"unread {index} {part.begin}",
            f"{self.names[index]}: the server's history from {hours.shown(part.begin)} to {hours.shown(part.end)} was not read to its end "
            f"({part.why})",
        )
        if part.end > part.begin:
            self.recorder.add(index, part.begin + 1, math.nan, hours.LOST)

    def _past(self, index: int, value: Any, begin: int) -> None:
        """Stores a value of the history. The last value before `begin` is held from `begin` on, unless a gap of the tag began
        after that value.
        """
        status = value.StatusCode.value if value.StatusCode is not None else 0
        if status == opcua.NO_BOUND:
            return
        if value.SourceTimestamp is not None and (at := opcua.microseconds(value.SourceTimestamp)) < begin:
            if not at < self.lost.get(index, at) <= begin:
                self._hold(index, value, begin)
        else:
            self._value(index, value, live=False)

    def _hold(self, index: int, value: Any, at: int) -> None:
        """Stores an older value as still valid."""
        status = value.StatusCode.value if value.StatusCode is not None else 0
        number = self._number(index, value, status)
        self.held[index] = at
        self.recorder.add(index, at, number, 0x8074_0000 if math.isnan(number) else status & 0xC000_0000 | hours.HELD)

    # The clock.

    async def _ticks(self, server: opcua.Server, nodes: Mapping[int, Any]) -> None:
        self._steps.clear()
        self._compared = 0.0
        checked = time.monotonic()
        ticks = 0
        while not self.stopping.is_set():
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self.stopping.wait(), min(1.0, self.options.publish_s))
            if (why := server.failed()) is not None:
                raise why
            if self.filling is not None and self.filling.done():
                # Its exception ends the connection.
                self.filling.result()
                if self.dropped:
                    self.filling = asyncio.create_task(self._refill(server, nodes))
            now = await server.clock()
            self._compare(now)
            self.clock = self._ticked = now
            self._settle()
            self._say_turned()
            ticks += 1
            was_full = self.full
            try:
                if was_full:
                    self.recorder.mark(self.until)
                self.recorder.flush(durable=ticks % 5 == 0)
                self.full, self.stored = False, self.until
            except OSError as error:
                self._cannot_store(error)
            if was_full and not self.full:
                self.say("values are stored again")
                # What is missing is a gap, which the next connection fills.
                raise ConnectionError("values were missing while the disk was full")
            if not self.full:
                limit = now - int(self.options.grace_s * US)
                if (filled := self._filled()) is not None:
                    limit = min(limit, filled)
                self.jumps = [each for each in self.jumps if now - each[1] < DOUBT]
                limit = min([limit, *(before for before, _, _ in self.jumps)])
                if self.back is not None and now - self.back[1] >= DOUBT:
                    self.back = None
                with contextlib.suppress(OSError):
                    if self.recorder.release(limit):
                        self.judging.set()
            self._rate.append((time.monotonic(), self.recorder.values))
            if ticks % 5 == 0:
                self._write_status()
            if time.monotonic() - checked > self.options.check_s:
                checked = time.monotonic()
                await self._check(server, nodes)

    def _say_turned(self) -> None:
        """Names the tags whose quality changed, in one line for each kind of change."""
        for what, places in self._turned.items():
            some = self._some(places)
            self.say_once(f"{what} {some}", f"{some}: {what}", 60.0)
        self._turned.clear()

    def _some(self, places: Sequence[int]) -> str:
        """Names tags, but only the first tags of many."""
        first = ", ".join(self.names[k] for k in places[:3])
        return f"{len(places)} tags ({first}{', ...' if len(places) > 3 else ''})" if len(places) > 1 else first

    async def _check(self, server: opcua.Server, nodes: Mapping[int, Any]) -> None:
        """Finds tags that the server no longer knows."""
        for index, value in (await server.read(nodes)).items():
            status = value.StatusCode.value if value.StatusCode is not None else 0
            if status in (0x8034_0000, 0x8033_0000) and index not in self.bad:
                self.bad.add(index)
                self.say_once(f"gone {index}", f"{self.names[index]}: the server no longer knows it ({opcua.code_name(status)})")
                if not self.full:
                    self.recorder.add(index, self.clock, math.nan, status)
            elif status < hours.BAD and index in self.bad:
                raise ConnectionError(f"{self.names[index]} exists again; all tags are subscribed again")

    def _compare(self, now: int) -> None:
        """Reports how the server's clock differs from this computer's clock, and when the server's clock jumps."""
        step, wall = (now - self.clock) / US, time.monotonic()
        passed = wall - self._compared if self._compared else math.inf
        if self._compared and wall > self._compared:
            self._speeds.append(step / (wall - self._compared))
            self.speed = max(1.0, statistics.median(self._speeds))
        self._compared = wall
        usual = statistics.median(self._steps) if len(self._steps) >= 5 else None
        if step < -1.0:
            self.say_once("back", f"the server's clock went back by {span(self.clock - now)}, to {hours.shown(now)}")
            self._went_back(now)
        elif usual is not None and step - usual > max(60.0, 20.0 * usual):
            # A pause of this process is no jump.
            if step - self.speed * passed > 60.0:
                self.say_once("jump", f"the server's clock jumped ahead by {span(now - self.clock)}, to {hours.shown(now)}", 60.0)
                self._jumped(now)
        self._steps.append(step)
        difference = now / US - time.time()
        told = self._told_difference
        if abs(difference) > 10.0 and (told is None or abs(difference - told) > max(10.0, 0.1 * abs(told))):
            ahead = "ahead of" if difference > 0 else "behind"
            self.say_once("clock", f"the server's clock is {span(int(abs(difference) * US))} {ahead} the clock of this computer")
            self._told_difference = difference

    def _jumped(self, now: int) -> None:
        """Handles a clock that jumped ahead: permanently, temporarily, or back to the right time."""
        back = self.back
        if back is None or not back[0] <= now <= back[0] + (self.clock - back[1]) + int(AHEAD * self.speed):
            self.jumps.append((self.clock, now, int(time.time() * US)))
            # A start after a kill finds it there.
            self._write_status()
            return
        self._set_right(back)
        self._ask_again(now)

    def _set_right(self, back: tuple[int, int, int, int]) -> None:
        """Handles a clock that went back and is right again, so all values are known up to the time of the jump."""
        self.back, self.was_wrong = None, True
        self.until = self.stored = back[0]
        if back[2] < back[0]:
            self.fill_from = min(back[2], self.fill_from or back[2])
        if not self.full:
            with contextlib.suppress(OSError):
                self.recorder.mark(self.until)
                self.recorder.flush()
                # Values of the moment before it went back are right.
                self._recall(self.until + int(5 * US * self.speed))

    def _went_back(self, now: int) -> None:
        """Handles a clock that went back: permanently, temporarily, or to the right time."""
        if self._undo(now):
            self._ask_again(now)
        if self.back is None and self.clock - now > FRESH:
            self.back, self._before_back = (self.clock, now, self.clock, int(time.time() * US)), list(self.last)
        # A clock that goes back by more is not believed.
        if self.clock - now < BEHIND:
            self._take_back(now)
        self._write_status()

    def _undo(self, now: int) -> bool:
        """Voids values that jumps of the server's clock dated wrongly, and returns whether such values existed."""
        undone = [each for each in self.jumps if self._is_undone(now, *each)]
        if not undone:
            return False
        self.jumps = [each for each in self.jumps if each not in undone]
        self.was_wrong = True
        before, after, _ = min(undone)
        # Values of the last moments before the jump are right.
        self._take_back(min(now, before), before + (after - before) // 2)
        return True

    def _is_undone(self, now: int, before: int, after: int, computer: int) -> bool:
        """Whether a jump of the clock is undone: the clock is behind the time after the jump, or, by this computer's clock,
        nearer to the time without the jump.
        """
        passed = int(max(0.0, time.time() * US - computer) * self.speed)
        return before < after and now < after or abs(now - before - passed) < abs(now - after - passed)

    def _take_back(self, until: int, void: int | None = None) -> None:
        """Voids the values from the time `void` on, and counts nothing after the time `until` as known."""
        self.until = self.stored = min(self.until, until)
        self.last = [min(at, until) for at in self.last]
        self.held = {index: min(at, until) for index, at in self.held.items()}
        self.lost = {index: at for index, at in self.lost.items() if at <= until}
        if self.full:
            return
        try:
            if void is not None:
                self.recorder.void(void)
            # Before the first values nothing is known up to a time.
            if self.until > 0:
                self.recorder.mark(self.until)
            self.recorder.flush()
            if void is not None:
                self._recall(void - 1)
        except OSError as error:
            self._cannot_store(error)

    def _recall(self, until: int) -> None:
        """Finds the last stored values up to a time, after which a gap begins."""
        known = hours.known(self.options.plant, until).last
        self.last = [known.get(name, at) for name, at in zip(self.names, self.last)]

    def _ask_again(self, now: int) -> None:
        """Ends the connection, so that the next connection fills the gap."""
        self.clock, self._ticked = now, 0
        raise ConnectionError("the server's clock was wrong for a time; its values for that time are requested again")

    # Judgement.

    async def _judge(self) -> None:
        """Runs the judgement whenever hours are ready, one at a time, in a separate process."""
        ready = hours.live_folder(self.options.plant) / "ready"
        if ready.is_dir() and any(ready.iterdir()):
            self.judging.set()
        while True:
            await self.judging.wait()
            self.judging.clear()
            # The state says so before a file changes.
            self.is_judging = True
            self._write_status()
            try:
                await self._judge_once()
            except OSError as error:
                self.say(f"the hours could not be judged: {error}")
            self.is_judging = False
            self._write_status()

    async def _judge_once(self) -> None:
        settings = {
            "plant": str(self.options.plant),
            "data": str(self.data),
            "keep_s": self.options.keep_s,
            "most_bytes": self.options.most_bytes,
            "now": self.clock,
            "time_limit_s": self.options.time_limit_s,
        }
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "stiction.live.judging",
            stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
            start_new_session=True,
        )  # fmt: skip
        try:
            out, errors = await process.communicate(json.dumps(settings).encode())
        except asyncio.CancelledError:
            # Files are written whole or not at all, and the rest is judged after a start.
            with contextlib.suppress(ProcessLookupError):
                process.terminate()
            await process.wait()
            raise
        try:
            found = json.loads(out.decode().strip().rpartition("\n")[2])
        except ValueError:
            found = {"error": errors.decode(errors="replace").strip().rpartition("\n")[2] or f"the judgement ended with exit code {process.returncode}"}
        if "error" in found:
            self.say_once("judging", f"the hours could not be judged; a later attempt follows: {found['error']}", 60.0)
            # Such as while a person scans.
            asyncio.get_running_loop().call_later(AGAIN_S, self.judging.set)
            return
        self.result = found
        self.counts["scans"] += 1
        self.counts["windows"] += found["windows"]
        for note in found["notes"]:
            self.say_once(f"note {note}", note)
        if found["hours"]:
            first, more = found["hours"][0], len(found["hours"]) - 1
            and_more = f" and {more} more" if more else ""
            self.say(
                f"hour {first}{and_more}: {found['rows']} values; {found['windows']} windows judged in {found['scan_s']:.1f} s"
            )
        if found["removed"]:
            self.say(f"{len(found['removed'])} old files were removed, from {found['removed'][0]}")
        for event in found["events"]:
            self.say(f"event: {event['text']}")
            self.options.emit(json.dumps(event, ensure_ascii=False))
        self.pusher.wake()

    # What others ask for.

    def status(self) -> dict[str, Any]:
        """The state of the watch."""
        rate = 0.0
        if len(self._rate) > 1:
            (t0, v0), (t1, v1) = self._rate[0], self._rate[-1]
            rate = (v1 - v0) / (t1 - t0) if t1 > t0 else 0.0
        newest = max(self.last, default=0) if hasattr(self, "last") else 0
        return {
            "url": self.options.url,
            "pid": os.getpid(),
            "written": time.time(),
            "started": self.began,
            "connected_since": self.connected_since,
            "tags": len(self.tags),
            "bad_tags": sorted(self.names[k] for k in self.bad)[:100] if hasattr(self, "bad") else [],
            "server_clock": self.clock / US or None,
            "known_until": self.until / US or None,
            "newest_value": newest / US if newest > 0 else None,
            "values": self.recorder.values if hasattr(self, "recorder") else 0,
            "values_per_s": round(rate, 1),
            "connections": self.counts["connections"],
            "gaps": self.counts["gaps"],
            "misdated": self.counts["misdated"],
            "misdating_tags": sorted(self.names[k] for k in self.misdating)[:100],
            "disk_full": self.full,
            "fill_from": self._filled(),
            "jumps": self.jumps,
            "back": self.back,
            "judging": self.is_judging or self.judging.is_set(),
            "scans": self.counts["scans"],
            "windows": self.counts["windows"],
            "scan_s": self.result.get("scan_s"),
            "write_s": self.result.get("write_s"),
            "last_hour": (self.result.get("hours") or [None])[-1],
            "words": self.result.get("words", {}),
            "unknown": self.result.get("unknown", {}),
            "events_unsent": self.pusher.unsent(),
        }

    def _write_status(self) -> None:
        folder = hours.live_folder(self.options.plant)
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            part = folder / "status.part"
            part.write_text(json.dumps(self.status()), encoding="utf-8")
            part.replace(folder / "status.json")

    def metrics(self) -> str:
        """The state as Prometheus metrics."""
        return push.metrics(self.status())


def _is_value(value: Any) -> bool:
    """Whether the answer is a value, and not the statement that a bound has no value."""
    return value.StatusCode is None or value.StatusCode.value != opcua.NO_BOUND


def _is_until(value: Any, time: int) -> bool:
    """Whether the source time of a value is not after a time."""
    return value.SourceTimestamp is not None and opcua.microseconds(value.SourceTimestamp) <= time


def _moment_of(value: Any) -> int | None:
    """The time of a value of the server; None without a time."""
    at = value.SourceTimestamp or value.ServerTimestamp
    return None if at is None else opcua.microseconds(at)


def read_status(plant: Path) -> dict[str, Any] | None:
    """The last status that `stiction watch` wrote for a plant; None if no file with it can be read."""
    try:
        found: dict[str, Any] = json.loads((hours.live_folder(plant) / "status.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    whole = isinstance(found, dict) and isinstance(found.get("written"), (int, float)) and {"url", "tags", "bad_tags", "words"} <= found.keys()
    return found if whole else None


def span(us: int) -> str:
    """A duration in words."""
    seconds = us / US
    for unit, name in ((86_400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= unit * (2.0 if name == "days" else 1.0):
            return f"{seconds / unit:.1f} {name}"
    return f"{seconds:.0f} s"
