"""Reads whole series from a source that may cut answers.

A source limits the number of values in an answer, and not every source states the limit. An answer therefore covers only the
times from the first to the last value in the answer. `Reading` asks for the times before and after an answer until nothing new
comes. This module does not depend on a protocol. The module states the next request, and receives the answers.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

__all__: list[str] = []

MOST_ANSWERS = 5_000
"""Maximum number of answers about a series. Values that are missing after this number of answers are reported as unread."""
MOST_VALUES = 5_000_000
"""Maximum number of values of a series."""
IDLE = 10
"""Maximum number of successive answers of a continuation that bring nothing new."""
MOST_S = 3600.0
"""Time limit for a part of the times of all series, s."""
NEAR = 60_000_000
"""Times that differ by less than this, in microseconds, are asked for together."""


@dataclass(frozen=True)
class Unread:
    """A part of a series that the source did not give completely."""

    begin: int
    end: int
    why: str


@dataclass
class Answer:
    """The answer of a source about a series."""

    values: Sequence[Any] = ()
    point: bytes | None = None
    """The point at which the source continues this answer."""
    code: int = 0
    """Status code of the failure; 0 for an answer."""
    retry: bool = False
    """Whether the source may answer a request for this series alone."""


@dataclass
class Span:
    """A part of a series whose values are not known yet, except perhaps at the edges of the part."""

    index: int
    begin: int
    end: int
    is_whole: bool = False
    is_alone: bool = False
    """Whether the span is requested alone, with its own edges."""
    point: bytes | None = None
    asked: tuple[int, int] = (0, 0)
    shared: bool = False
    """Whether the span was requested together with other spans."""
    low: int | None = None
    high: int | None = None
    is_new: bool = False
    idle: int = 0
    crowded: int | None = None
    """A time before the span that may have more values than an answer holds."""


@dataclass
class _Series:
    """The known part of a series."""

    answers: int = 0
    values: int = 0
    largest: int = 0
    edges: dict[int, set[Hashable]] = field(default_factory=dict)


class Reading:
    """The reading of some series between two times, both included.

    `time_of` returns the time of a value (None without a time). `key_of` returns what distinguishes a value from other values at
    that time.
    """

    def __init__(
        self,
        places: Sequence[int],
        begin: int,
        end: int,
        *,
        together: int,
        time_of: Callable[[Any], int | None],
        key_of: Callable[[Any], Hashable],
    ) -> None:
        self.together, self.time_of, self.key_of = together, time_of, key_of
        self._series = {index: _Series() for index in places}
        self.waiting = [Span(index, begin, end, is_whole=True) for index in places]

    def next(self) -> list[Span]:
        """Return the spans to ask for in one request, all from and to the times of `Span.asked`; none at the end."""
        if not self.waiting:
            return []
        first = self.waiting[0]
        chosen = [first]
        if not first.is_alone:
            for span in self.waiting[1:]:
                if len(chosen) >= self.together:
                    break
                if self._fits(first, span) and all(span.index != each.index for each in chosen):
                    chosen.append(span)
        taken = {id(span) for span in chosen}
        self.waiting = [span for span in self.waiting if id(span) not in taken]
        if first.point is None:
            # A time is known to the microsecond, and a source may know it better.
            asked = min(span.begin for span in chosen), max(span.end + (not span.is_whole) for span in chosen)
            for span in chosen:
                span.asked, span.shared = asked, len(chosen) > 1
        return chosen

    @staticmethod
    def _fits(first: Span, span: Span) -> bool:
        if span.is_alone or (first.point is None) != (span.point is None):
            return False
        if first.point is not None:
            return first.asked == span.asked
        return first.is_whole == span.is_whole and abs(first.begin - span.begin) < NEAR and abs(first.end - span.end) < NEAR

    def take(self, span: Span, answer: Answer, count: int) -> Iterator[list[Any] | int | Unread]:
        """Take the answer about a span, for which `count` values were requested, and yield the new values in the answer.

        Also yields the code of a series without history, and a part that stays unread.
        """
        series = self._series[span.index]
        if answer.retry and not span.is_alone:
            span.is_alone = True
            self.waiting.insert(0, span)
            return
        if answer.code:
            if series.values == 0 and span.is_whole:
                yield answer.code
            else:
                yield Unread(span.begin if span.high is None else span.high, span.end, f"code {answer.code:#x}")
            return
        times = [self.time_of(value) for value in answer.values]
        size, largest = len(times), series.largest
        new = self._new(span, series, times, answer.values)
        series.answers += 1
        series.values += len(new)
        series.largest = max(largest, size)
        self._know(span, series, times, answer.values, count)
        span.is_new |= bool(new)
        span.idle = 0 if new else span.idle + 1
        if new:
            yield new
            if span.crowded is not None:
                yield Unread(span.crowded, span.crowded, "the source has more values of one time than fit in one of its answers")
                span.crowded = None
        if size == 0 and span.is_whole and not span.is_alone and span.shared:
            # The values of the others may have filled the answer.
            span.is_alone = True
            self.waiting.insert(0, span)
            return
        if answer.point is not None and span.idle < IDLE:
            span.point = answer.point
            rest = [span]
        else:
            rest = self._rest(span, times, size, largest)
        if series.answers >= MOST_ANSWERS or series.values >= MOST_VALUES:
            for each in rest:
                begin = each.begin if each.high is None else max(each.begin, each.high)
                yield Unread(begin, each.end, f"{series.values} values in {series.answers} answers were not the end")
            return
        self.waiting = rest + self.waiting

    def _new(self, span: Span, series: _Series, times: Sequence[int | None], values: Sequence[Any]) -> list[Any]:
        """Return the values that no earlier answer brought."""
        if span.is_whole and span.low is None and span.point is None:
            # Of the values before, only the last one may still be valid.
            before = max((time for time in times if time is not None and time < span.begin), default=None)
            return [value for time, value in zip(times, values) if time is None or before is None or time >= before]
        new = []
        for time, value in zip(times, values):
            if time is None or not span.begin <= time <= span.end:
                continue
            known = series.edges.get(time)
            if known is not None and self.key_of(value) in known:
                continue
            new.append(value)
        if span.low is not None and span.high is not None:
            # A continuation that only repeats what it gave brings nothing.
            fresh = any(
                time is not None and span.begin <= time <= span.end and (not span.low < time < span.high)
                and self.key_of(value) not in series.edges.get(time, ())
                for time, value in zip(times, values)
            )  # fmt: skip
            return new if fresh else []
        return new

    def _know(self, span: Span, series: _Series, times: Sequence[int | None], values: Sequence[Any], count: int) -> None:
        """Extend the known part of a span, and remember the values at the edges of the span."""
        known = [time for time in times if time is not None]
        if not known:
            return
        inside = [time for time in known if span.begin <= time <= span.end]
        edges = {min(inside), max(inside)} if inside else set()
        for time, value in zip(times, values):
            if time in edges:
                series.edges.setdefault(time, set()).add(self.key_of(value))
        low, high = min(inside, default=None), max(inside, default=None)
        if span.is_whole and len(known) < count:
            # A value outside states that none is missing up to it.
            if min(known) <= span.begin:
                low = span.begin
            if max(known) >= span.end:
                high = span.end
        if low is not None:
            span.low = low if span.low is None else min(span.low, low)
        if high is not None:
            span.high = high if span.high is None else max(span.high, high)

    def _rest(self, span: Span, times: Sequence[int | None], size: int, largest: int) -> list[Span]:
        """Return the parts of a span that are still unknown after an answer about the span."""
        index, begin, end = span.index, span.begin, span.end
        if span.is_new:
            rest = []
            low = span.low if span.low is not None else span.high
            high = span.high if span.high is not None else span.low
            if low is None or high is None:
                return []
            if low > begin:
                rest.append(Span(index, begin, low))
            if high < end:
                rest.append(Span(index, high, end))
            return rest
        if span.is_whole:
            return []
        at = {time for time in times if time is not None and begin <= time <= end}
        if span.asked != (begin, end + 1):
            # It was asked for with others, so a cut may have come before its own begin.
            return [] if at and size < largest else [Span(index, begin, end, is_alone=True)]
        if len(at) == 1 and size >= largest and begin < end:
            # All of the answer is of one time, of which there may be more values than an answer holds.
            [time] = at
            begin, end = (time + 1, end) if time == begin else (begin, time - 1)
            return [Span(index, begin, end, is_alone=True, crowded=time)] if begin <= end else []
        return []
