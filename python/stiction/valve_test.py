"""A test that shows whether a valve sticks, planned from a recording in operation, and evaluated afterwards.

With the controller in manual, the operator moves the controller output (OP) up and down. A sticking valve does not respond to
moves smaller than S. `docs/test.md` describes the test.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

from stiction import _core
from stiction._arguments import instance, number
from stiction._document import Estimate, TestPlan, Turn
from stiction._result import Result, about, result, result_of
from stiction.recordings import RecordingLike, _checked

__all__ = [
    "Between",
    "PlanComparison",
    "SizeComparison",
    "Comparison",
    "Difference",
    "Place",
    "PositionReading",
    "Ramp",
    "Reading",
    "Signature",
    "SignatureComparison",
    "SignaturePlan",
    "Step",
    "TestPlan",
    "Turn",
    "compare",
    "compare_signatures",
    "plan",
    "plan_signature",
    "read",
    "signature",
]


@result
class Step(Result):
    """A turn of the OP and its answer."""

    at_s: float = about("Time of the turn, s on the recording's clock.")
    op: float = about("New OP, percent.")
    travel: float | None = about(
        "Change of the OP, percent; None for the first of a time in manual, because the previous position of the stem "
        "is unknown."
    )
    answer: float | None = about("Change of the PV until the next turn, in PV units.")
    error: float | None = about("Standard deviation of the answer.")
    answered: bool = about("Whether the PV moved with the turn by more than 2.5 standard deviations.")


@result
class Between(Result):
    """The OP change that moves the stem, percent, as an interval between two turns."""

    above: float = about("The largest change that did not move the stem; 0 if each did.")
    up_to: float | None = about("The smallest change that moved the stem; None if none did.")


@result
class PositionReading(Result):
    """Results from the stem position, by the definitions of ANSI/ISA-75.25.01 (recalled)."""

    dead_band: Between | None = about("OP travel after a reversal before the stem moves, percent.")
    resolution: Between | None = about("OP travel in the same direction before the stem moves again, percent.")
    dead_time_s: float | None = about("Median time until the stem begins to move, s.")
    t63_s: float | None = about("Median time to 63.2 % of the stem's response, s.")
    t86_s: float | None = about("Median time to 86.5 % of the stem's response, s.")
    timed: int = about("Number of turns in these medians.")


@result
class SizeComparison(Result):
    """A size of the plan and its turns in the test."""

    part: int = about("The part of the test, 1 with growing or 2 with shrinking sizes.")
    planned: float | None = about("The planned size, percent from one turn to the next; None if it is not in the plan.")
    made: float | None = about("The actual size, percent; None if it was left out.")
    turns: int = about("Number of turns of this size.")
    answered: int = about("Number of these with a response of the PV.")
    hold_planned_s: float | None = about("Planned longest hold of each, s; None in part 2.")
    hold_s: float | None = about("Longest actual hold, s; None if the size was left out.")


@result
class PlanComparison(Result):
    """A test compared with its plan."""

    sizes: list[SizeComparison] = about("The sizes, in the order of the test or the plan.")
    turns_planned: int = about("Planned turns of these sizes, two of each.")
    turns: int = about("Turns in the test.")
    cut_short: int = about("Turns of part 1 that ended before the planned hold, although the PV had not responded.")
    held_longer: int = about("Turns of part 1 held longer than planned.")
    pv_beyond_s: float = about("Time with the PV outside the limits of the plan during the test, s.")
    pv_low: float = about("The lowest PV of the test, in PV units.")
    pv_high: float = about("The highest PV of the test.")
    remarks: list[str] = about("Deviations from the plan, in sentences.")


@result
class Reading(Result):
    """The result of a test."""

    class_: str = about(
        "`sticks`, `does not stick`, `does not respond` or `cannot tell`, from the test and the operation before it."
    )
    probability: float = about("Probability of sticking, from both.")
    by_test: float = about("Probability of sticking, from the test alone.")
    by_operation: float | None = about(
        "Probability of sticking, from the recording before the test; None if that is inconclusive."
    )
    dead_band_elsewhere: float = about(
        "Probability of a dead band outside the valve, in the process, a linkage or the transmitter."
    )
    S: Estimate | None = about("Stick band plus dead band, percent of span, with its 90 % interval, if the valve sticks.")
    J: Estimate | None = about("Slip jump, percent of span, with its 90 % interval, if the valve sticks.")
    S_below: float | None = about("Upper limit of S with 95 % confidence, percent; None if the test sets no limit.")
    response_s: float | None = about("Dead time and lags between OP and PV, s; None if no turn had a response.")
    known_by: str = about("Source of the manual moves, one of `sheet`, `mode` and `output`.")
    from_s: float = about("Beginning of the test, s on the recording's clock.")
    to_s: float = about("End of the test.")
    stops: int = about("Number of times that the controller took over during the test.")
    by_position: bool = about("Whether the responses are those of the recorded stem position, and not of the PV.")
    position: PositionReading | None = about("Results from the position, if it is recorded.")
    steps: list[Step] = about("The turns, in order.")
    reasons: list[str] = about("The reasons, in sentences.")
    advice: str | None = about("How to repeat the test, if it is inconclusive.")
    plan: PlanComparison | None = about("Comparison with the plan, if one was given.")

    def _summary(self) -> list[str]:
        lines = [f"{self.class_}, p = {self.probability:.2g}, {len(self.steps)} turns, from the {self.known_by}"]
        if self.S is not None:
            lines.append(f"S {self.S.value:.2g} % ({self.S.low:.2g} to {self.S.high:.2g})")
        elif self.S_below is not None:
            lines.append(f"S below {self.S_below:.2g} %")
        return lines


@result
class Difference(Result):
    """S after a repair minus S before it."""

    value: float | None = about("The best value, percent of span; None if a test only limits S.")
    low: float = about("Lower end of its 90 % interval, percent of span.")
    high: float = about("Upper end.")


@result
class Comparison(Result):
    """The comparison of two tests before and after a repair."""

    effect: str = about("The change of S, one of `lowered`, `raised`, `unchanged` and `cannot tell`.")
    difference: Difference | None = about("S after minus S before; None if a test neither finds nor limits S.")
    sentences: list[str] = about("The result in sentences.")
    before: Reading = about("The test before the repair.")
    after: Reading = about("The test after it.")

    def _summary(self) -> list[str]:
        return [self.effect, *self.sentences]


@result
class Ramp(Result):
    """A ramp of the OP in the plan of a signature."""

    to_op: float = about("The OP at its end, percent.")
    duration_s: float = about("Its duration, s.")
    hold_s: float = about("The hold at its end, s.")


@result
class SignaturePlan(Result):
    """The planned signature of a valve."""

    name: str = about("Tag of the loop.")
    from_op: float = about("The OP at the start, percent.")
    ramps: list[Ramp] = about("The ramps, in order.")
    record_every_s: float = about("The longest sample interval of OP and VP, s, without compression.")
    total_s: float = about("Duration of all ramps and holds, s.")
    summary: str = about("A summary of the test.")
    instructions: list[str] = about("The instructions, in order.")


@result
class Place(Result):
    """A part of the stroke."""

    from_: float = about("The stem position at its lower end, percent.")
    to: float = about("The stem position at its upper end, percent.")
    S: Estimate = about("Stick band plus dead band there, percent of span, with its 90 % interval.")


@result
class Signature(Result):
    """The result of a signature."""

    class_: str = about("`sticks`, `does not stick`, `does not respond` or `cannot tell`.")
    S: Estimate | None = about(
        "Stick band plus dead band, percent of span, with its 90 % interval, outside the part of the stroke that binds."
    )
    J: Estimate | None = about("Slip jump, percent of span, with its 90 % interval.")
    op: list[float] = about("The OP range of the ramps, percent.")
    vp: list[float] = about("The range of the stem, percent; of the PV as a position if no position was recorded.")
    offset: float = about("Mean of OP minus VP over rising and falling ramps, percent: the calibration error.")
    places: list[Place] = about("The parts of the stroke, from the lowest.")
    binds: list[float] | None = about(
        "The part of the stroke where the stem binds: its S there is clearly larger than elsewhere."
    )
    ramps: int = about("Number of ramps.")
    from_s: float = about("Start of the ramps, s on the recording's clock.")
    to_s: float = about("End of the ramps, s on the recording's clock.")
    reasons: list[str] = about("The reasons, in sentences.")

    def _summary(self) -> list[str]:
        lines = [f"{self.class_}, {self.ramps} ramps"]
        if self.S is not None:
            lines.append(f"S {self.S.value:.2g} % ({self.S.low:.2g} to {self.S.high:.2g})")
        return lines


@result
class SignatureComparison(Result):
    """The comparison of two signatures before and after a repair."""

    effect: str = about("The change of S, one of `lowered`, `raised`, `unchanged` and `cannot tell`.")
    difference: Difference | None = about("S after minus S before; None if a signature does not find S.")
    sentences: list[str] = about("The result in sentences.")
    before: Signature = about("The signature before the repair.")
    after: Signature = about("The signature after it.")


def plan_signature(name: str = "", *, op: tuple[float, float] = (0.0, 100.0)) -> SignaturePlan:
    """Plan the signature of a valve: a slow ramp of the OP over the stroke and back, with the position recorded.

    Parameters
    ----------
    name : str, optional
        Tag of the loop.
    op : (float, float), optional
        The OP range of the ramps, percent. The process has to tolerate it.

    Returns
    -------
    SignaturePlan

    Raises
    ------
    ValueError
        If the range is not within 0 to 100 %, or is too narrow.

    Examples
    --------
    >>> import stiction
    >>> test = stiction.valve_test.plan_signature("LV104", op=(20, 80))
    >>> len(test.ramps), test.ramps[0].to_op
    (40, 26.0)
    """
    return result_of(SignaturePlan, _core.signature_planned(name, (number("op", op[0]), number("op", op[1]))))


def signature(recording: RecordingLike) -> Signature:
    """Find slow ramps of the OP in a recording with a valve position, and judge the valve along its stroke.

    Parameters
    ----------
    recording : Recording or table
        A recording with OP and valve position.

    Returns
    -------
    Signature

    Raises
    ------
    ValueError
        If the recording has no valve position, or no slow ramp up and down.

    Examples
    --------
    >>> import numpy as np
    >>> import stiction
    >>> op = np.concatenate([np.linspace(10, 50, 400), np.full(60, 50), np.linspace(50, 90, 400)])
    >>> op = np.concatenate([op, op[::-1]])
    >>> stroked = stiction.recording(op, vp=stiction.valve(op, S=4, J=2), sample_time=1)
    >>> found = stiction.valve_test.signature(stroked)
    >>> found.class_, round(found.S.value)
    ('sticks', 4)
    """
    return result_of(Signature, _core.signature_read(_checked(recording)))


def compare_signatures(before: RecordingLike, after: RecordingLike) -> SignatureComparison:
    """Compare the signature of a valve after a repair with the one before it.

    Parameters
    ----------
    before : Recording or table
        The recording with the signature before the repair; see `signature`.
    after : Recording or table
        The recording with the signature after it.

    Returns
    -------
    SignatureComparison

    Raises
    ------
    ValueError
        If a recording has no valve position, or no slow ramp up and down.

    Examples
    --------
    >>> import numpy as np
    >>> import stiction
    >>> op = np.concatenate([np.linspace(10, 50, 400), np.full(60, 50), np.linspace(50, 90, 400)])
    >>> op = np.concatenate([op, op[::-1]])
    >>> ramped = lambda position: stiction.recording(op, vp=position, sample_time=1)
    >>> old, new = ramped(stiction.valve(op, S=4, J=2)), ramped(op)
    >>> stiction.valve_test.compare_signatures(old, new).effect
    'lowered'
    """
    return result_of(SignatureComparison, _core.signatures_compared(_checked(before), _checked(after)))


def plan(
    recording: RecordingLike,
    *,
    done: Iterable[tuple[float, float | None]] | None = None,
    rises: bool | None = None,
    pv_allowed: tuple[float, float] | None = None,
    time_s: float | None = None,
) -> TestPlan:
    """Size a test for a loop from a recording of its operation.

    If the recording contains an inconclusive test, the plan is for the next one. It begins at the size to which the PV
    responded, and has more turns of each size.

    Parameters
    ----------
    recording : Recording or table
        The recording, see `stiction.read` and `stiction.recording`, or a table with the columns of one loop.
    done : iterable of (float, float or None), optional
        The manual moves of a test in the recording, as for `read`.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default from the action of the controller.
    pv_allowed : (float, float), optional
        The lowest and the highest PV that the process tolerates; by default the recorded range, widened by a quarter of it on
        either side.
    time_s : float, optional
        The longest time in manual, s; by default 20 min, or 40 first holds if that is longer, but 8 h at most.

    Returns
    -------
    TestPlan

    Raises
    ------
    ValueError
        If the recording has no segment in automatic, no PV, or no movement, or the time is not above 0.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> test = stiction.valve_test.plan(stiction.recording(run.op, run.pv, run.sp, sample_time=1), rises=True)
    >>> [turn.op for turn in test.grow[:4]]
    [0.56, -0.56, 0.9, -0.9]
    """
    allowed = None if pv_allowed is None else (number("pv_allowed", pv_allowed[0]), number("pv_allowed", pv_allowed[1]))
    known = None if rises is None else bool(instance("rises", rises, bool))
    longest = None if time_s is None else number("time_s", time_s)
    return result_of(TestPlan, _core.test_planned(_checked(recording), _sets("done", done), known, allowed, longest))


def read(
    recording: RecordingLike,
    *,
    done: Iterable[tuple[float, float | None]] | None = None,
    plan: TestPlan | None = None,
    rises: bool | None = None,
) -> Reading:
    """Find the test in a recording and judge the valve.

    Parameters
    ----------
    recording : Recording or table
        The recording, with the operation before the test; see `plan`.
    done : iterable of (float, float or None), optional
        For each turn the time at which the OP was set, s on the recording's clock, and its new value, percent. None as the value
        marks a return to automatic. By default the turns are found from the mode, or else from the OP.
    plan : TestPlan, optional
        The plan of the test. The result then has a comparison with it.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default from the action of the controller, or else from the test.

    Returns
    -------
    Reading

    Raises
    ------
    ValueError
        If the recording has no test, or too little of one.

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
    return result_of(Reading, _core.test_read(_checked(recording), _sets("done", done), _planned("plan", plan), known))


def _planned(name: str, plan: TestPlan | None) -> str | None:
    return None if plan is None else json.dumps(instance(name, plan, TestPlan).to_dict())


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
    before_plan: TestPlan | None = None,
    after_plan: TestPlan | None = None,
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
        The manual moves of each test, like `done` of `read`.
    before_plan, after_plan : TestPlan, optional
        The plan of each test, like `plan` of `read`. Each reading then has its deviations from the plan.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default from the action of the controller, or else from the test.

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        If a recording has no test, or too little of one.

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
    done = [_sets("before_done", before_done), _sets("after_done", after_done)]
    plans = [_planned("before_plan", before_plan), _planned("after_plan", after_plan)]
    return result_of(Comparison, _core.test_compared([_checked(before), _checked(after)], done, plans, known))
