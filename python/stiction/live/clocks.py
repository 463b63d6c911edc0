"""Decides whether the time of a new value is right.

The times of late values are right: a device that was disconnected delivers old values afterwards and catches up. A source with a
wrong clock stays behind. Values of a source with a wrong clock would be written between the values of past hours, so the tags of
a loop would no longer match in time.
"""

from __future__ import annotations

from enum import Enum

__all__: list[str] = []


class Belief(Enum):
    """The judgement of a time."""

    RIGHT = "right"
    LATE = "late"
    """The time is later than all known times of the tag, so the value is stored."""
    KNOWN = "known"
    """The time lies among times that are already known, so the value is not stored."""
    BEHIND = "behind"
    """The source stays behind. The clock of the source is wrong, and the value is not stored."""


LASTING_S = 60.0
"""Time for which a source must be behind before the clock of the source counts as wrong, s by this computer's clock. A busy
computer is behind for a shorter time.
"""


class SourceClocks:
    """How far the sources of tags are behind the server's clock."""

    def __init__(self) -> None:
        # The lag of a tag, and the server's clock and this computer's when it began.
        self._late: dict[int, tuple[int, int, float]] = {}

    def was_late(self, index: int) -> bool:
        """Return whether the last value of a tag was behind."""
        return index in self._late

    def judge(self, index: int, moment: int, clock: int, known: int, tolerance: int, now_s: float) -> Belief:
        """Judge the time of a value of a tag whose times are known up to `known`. All times are in microseconds, except this
        computer's time `now_s`.
        """
        lag = clock - moment
        if lag <= tolerance:
            self._late.pop(index, None)
            return Belief.RIGHT
        first, since, since_s = self._late.setdefault(index, (lag, clock, now_s))
        if lag < first / 2:
            # It catches up.
            since, since_s = clock, now_s
            self._late[index] = (lag, since, since_s)
        if moment <= known:
            return Belief.KNOWN
        return Belief.BEHIND if clock - since > tolerance and now_s - since_s > LASTING_S else Belief.LATE
