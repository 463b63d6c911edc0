"""A test that settles whether a valve sticks: planned from a recording in operation, and read back.

With the controller in manual somebody turns the controller output (OP) to and fro. A valve that sticks answers no turn
that is smaller than S. `docs/test.md` describes the test.
"""

from __future__ import annotations

from collections.abc import Iterable

from stiction import _core
from stiction._arguments import instance, number
from stiction._document import Estimate, TestPlan, Turn
from stiction._result import Result, about, result, result_of
from stiction.recordings import RecordingLike, _checked

__all__ = [
    "Between",
    "Carried",
    "CarriedSize",
    "Comparison",
    "Difference",
    "PositionReading",
    "Reading",
    "Step",
    "TestPlan",
    "Turn",
    "compare",
    "plan",
    "read",
]


@result
class Step(Result):
    """A turn of the OP, and what came of it."""

    at_s: float = about("When the OP was set, s on the recording's clock.")
    op: float = about("To what, percent.")
    travel: float | None = about(
        "How far that was from the OP before, percent; None for the first of a time in manual, before which the stem may "
        "have been anywhere."
    )
    answer: float | None = about("How far the PV went with it until the next, in its units.")
    error: float | None = about("Standard deviation of that.")
    answered: bool = about("Whether that is an answer: it goes with the turn, by more than 2.5 standard deviations.")


@result
class Between(Result):
    """A distance of the OP that moves the stem, percent: known between two turns."""

    above: float = about("The longest that did not move it; 0 if each did.")
    up_to: float | None = about("The shortest that did; None if none did.")


@result
class PositionReading(Result):
    """What the position of the stem shows, by the definitions of ANSI/ISA-75.25.01 (recalled)."""

    dead_band: Between | None = about("How far the OP goes after a reversal before the stem moves, percent.")
    resolution: Between | None = about("How far the OP goes on in one direction before the stem moves again, percent.")
    dead_time_s: float | None = about("Median time until the stem begins to move, s.")
    t63_s: float | None = about("Median time until it has gone 63.2 % of its way, s.")
    t86_s: float | None = about("Median time until it has gone 86.5 % of its way, s.")
    timed: int = about("Turns of which these times are.")


@result
class CarriedSize(Result):
    """A size of the plan, and the turns that were made of it."""

    part: int = about("The part of the test: 1, where sizes grow, or 2, where they shrink.")
    planned: float | None = about("The size as planned, percent from one turn to the next; None if the plan has no such size.")
    made: float | None = about("The size as made, percent; None if it was left out.")
    turns: int = about("Turns that were made of it.")
    answered: int = about("How many of them the PV answered.")
    hold_planned_s: float | None = about("How long each is held at most by the plan, s; None in part 2.")
    hold_s: float | None = about("How long the longest was held, s; None if it was left out.")


@result
class Carried(Result):
    """A plan beside what was carried out of it."""

    sizes: list[CarriedSize] = about("The sizes, in the order in which they were made or planned.")
    turns_planned: int = about("Turns of these sizes that the plan asks for: two of each.")
    turns: int = about("Turns that were made.")
    cut_short: int = about("Turns of part 1 that ended before their hold, although the PV had not moved by the answer of the plan.")
    held_longer: int = about("Turns of part 1 that were held longer than planned.")
    pv_beyond_s: float = about("How long the PV was outside the limits of the plan during the test, s.")
    pv_low: float = about("The lowest PV of the test, in its units.")
    pv_high: float = about("The highest.")
    remarks: list[str] = about("What was carried out in another way than planned, in sentences.")


@result
class Reading(Result):
    """What a test says of a valve."""

    class_: str = about(
        "`sticks`, `does not stick`, `does not respond` or `cannot tell`, by the test and by the operation before it."
    )
    probability: float = about("That the valve sticks, by both.")
    by_test: float = about("That it sticks, by the test alone.")
    by_operation: float | None = about("That it sticks, by the recording before the test; None where that says nothing.")
    dead_band_elsewhere: float = about(
        "Probability of a dead band behind the valve: in the process, a linkage or the transmitter."
    )
    S: Estimate | None = about("Stick band plus dead band, percent of span, with its 90 % interval, if the valve sticks.")
    J: Estimate | None = about("Slip jump, percent of span, with its 90 % interval, if the valve sticks.")
    S_below: float | None = about("S is below this with 95 % confidence, percent; None where the test sets no limit.")
    response_s: float | None = about("Dead time and lags between OP and PV, s; None where no turn was answered.")
    known_by: str = about("How it is known what was set by hand: `sheet`, `mode` or `output`.")
    from_s: float = about("When the test began, s on the recording's clock.")
    to_s: float = about("When it ended.")
    stops: int = about("How often the controller took over in between.")
    by_position: bool = about("Whether the answers are those of the stem, whose position is recorded, and not of the PV.")
    position: PositionReading | None = about("What the position shows, where it is recorded.")
    steps: list[Step] = about("The turns, in order.")
    reasons: list[str] = about("Why, in sentences.")
    advice: str | None = about("What to do differently, where the test does not tell.")
    plan: Carried | None = about("What was carried out of the plan, where one was given.")

    def _summary(self) -> list[str]:
        lines = [f"{self.class_}, p = {self.probability:.2g}, {len(self.steps)} turns, known by the {self.known_by}"]
        if self.S is not None:
            lines.append(f"S {self.S.value:.2g} % ({self.S.low:.2g} to {self.S.high:.2g})")
        elif self.S_below is not None:
            lines.append(f"S below {self.S_below:.2g} %")
        return lines


@result
class Difference(Result):
    """S after a repair less S before it."""

    value: float | None = about("The best value, percent of span; None where a test gives a limit of S alone.")
    low: float = about("Lower end of its 90 % interval, percent of span.")
    high: float = about("Upper end.")


@result
class Comparison(Result):
    """What two tests say of a repair between them."""

    effect: str = about("What became of S: `lowered`, `raised`, `unchanged` or `cannot tell`.")
    difference: Difference | None = about("S after less S before; None where a test neither finds S nor limits it.")
    sentences: list[str] = about("It in sentences.")
    before: Reading = about("The test before the repair.")
    after: Reading = about("The test after it.")

    def _summary(self) -> list[str]:
        return [self.effect, *self.sentences]


def plan(
    recording: RecordingLike,
    *,
    done: Iterable[tuple[float, float | None]] | None = None,
    rises: bool | None = None,
    pv_allowed: tuple[float, float] | None = None,
) -> TestPlan:
    """Size a test for a loop from a recording of its operation.

    Where the recording holds a test that cannot tell, the plan is of the next test. It begins where the PV answered, and
    makes more turns of each size.

    Parameters
    ----------
    recording : Recording or table
        The recording, see `stiction.read` and `stiction.recording`, or a table with the columns of one loop.
    done : iterable of (float, float or None), optional
        What was set by hand in a test that the recording holds, as for `read`.
    rises : bool, optional
        Whether the PV rises when the OP rises; the action of the controller shows it by default.
    pv_allowed : (float, float), optional
        The lowest and the highest PV that the process bears; by default what was recorded and half as much again.

    Returns
    -------
    TestPlan

    Raises
    ------
    ValueError
        If there is no segment in automatic, no PV, or nothing moves.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> test = stiction.valve_test.plan(stiction.recording(run.op, run.pv, run.sp, sample_time=1), rises=True)
    >>> [turn.op for turn in test.grow[:4]]
    [0.2, -0.2, 0.32, -0.32]
    """
    allowed = None if pv_allowed is None else (number("pv_allowed", pv_allowed[0]), number("pv_allowed", pv_allowed[1]))
    known = None if rises is None else bool(instance("rises", rises, bool))
    return result_of(TestPlan, _core.test_planned(_checked(recording), _sets("done", done), known, allowed))


def read(
    recording: RecordingLike,
    *,
    done: Iterable[tuple[float, float | None]] | None = None,
    rises: bool | None = None,
) -> Reading:
    """Find the test in a recording, and judge the valve by it.

    Parameters
    ----------
    recording : Recording or table
        The recording, with the operation before the test; see `plan`.
    done : iterable of (float, float or None), optional
        For each turn the time at which the OP was set, s on the recording's clock, and its new value, percent. None as the
        value marks a return to automatic. By default the mode shows the turns, or else the OP itself.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default the action of the controller shows it, or else the test.

    Returns
    -------
    Reading

    Raises
    ------
    ValueError
        If there is no test in the recording, or too little of it to be judged.

    Examples
    --------
    >>> import numpy as np
    >>> import stiction
    >>> half = 0.2 * 1.25 ** np.minimum(np.arange(32), np.arange(32)[::-1])
    >>> turns = np.repeat(50 + half * np.tile([1, -1], 16), 10)
    >>> op = np.concatenate([50 + np.sin(np.arange(200) / 9), turns])
    >>> pv = 2 * stiction.valve(op, S=3, J=1) + np.random.default_rng(1).normal(0, 0.1, op.size)
    >>> test = stiction.valve_test.read(stiction.recording(op, pv, sample_time=1), rises=True)
    >>> test.class_, round(test.S.value)
    ('sticks', 3)
    """
    known = None if rises is None else bool(instance("rises", rises, bool))
    return result_of(Reading, _core.test_read(_checked(recording), _sets("done", done), known))


def _sets(name: str, done: Iterable[tuple[float, float | None]] | None) -> list[tuple[float, float | None]] | None:
    if done is None:
        return None
    return [(number(name, at), None if op is None else number(name, op)) for at, op in done]


def compare(
    before: RecordingLike,
    after: RecordingLike,
    *,
    before_done: Iterable[tuple[float, float | None]] | None = None,
    after_done: Iterable[tuple[float, float | None]] | None = None,
    rises: bool | None = None,
) -> Comparison:
    """Compare the test of a valve after a repair with the test before it.

    Parameters
    ----------
    before : Recording or table
        The recording with the test before the repair; see `read`.
    after : Recording or table
        The recording with the test after it.
    before_done, after_done : iterable of (float, float or None), optional
        What was set by hand in each test, as `done` of `read`.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default the action of the controller shows it, or else the test.

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        If there is no test in a recording, or too little of it to be judged.

    Examples
    --------
    >>> import numpy as np
    >>> import stiction
    >>> half = 0.2 * 1.25 ** np.minimum(np.arange(32), np.arange(32)[::-1])
    >>> turns = np.repeat(50 + half * np.tile([1, -1], 16), 10)
    >>> op = np.concatenate([50 + np.sin(np.arange(200) / 9), turns])
    >>> noise = np.random.default_rng(1).normal(0, 0.1, op.size)
    >>> recorded = lambda position: stiction.recording(op, 2 * position + noise, sample_time=1)
    >>> repair = stiction.valve_test.compare(recorded(stiction.valve(op, S=3, J=1)), recorded(op), rises=True)
    >>> repair.effect, repair.difference.high < 0
    ('lowered', True)
    """
    known = None if rises is None else bool(instance("rises", rises, bool))
    sets = (_sets("before_done", before_done), _sets("after_done", after_done))
    return result_of(Comparison, _core.test_compared(_checked(before), _checked(after), *sets, known))
