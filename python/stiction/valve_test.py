"""A test that shows whether a valve sticks. The test is planned from a recording of the operation, and evaluated afterwards.

With the controller in manual, the operator moves the controller output (OP) up and down. A sticking valve does not respond to
moves smaller than S. `docs/test.md` describes the test.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

from stiction import _core
from stiction._arguments import instance, number
from stiction._document import (
    Between,
    Difference,
    Place,
    PlanComparison,
    PositionReading,
    Ramp,
    SignaturePlan,
    SignatureReading,
    SizeComparison,
    Step,
    TestPlan,
    TestReading,
    Turn,
)
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
class Reading(TestReading):
    """The result of a test."""

    def _summary(self) -> list[str]:
        lines = [f"{self.class_}, p = {self.probability:.2g}, {len(self.steps)} turns, from the {self.known_by}"]
        if self.S is not None:
            lines.append(f"S {self.S.value:.2g} % ({self.S.low:.2g} to {self.S.high:.2g})")
        elif self.S_below is not None:
            lines.append(f"S below {self.S_below:.2g} %")
        return lines


@result
class Comparison(Result):
    """The comparison of two tests before and after a repair."""

    effect: str = about("The change of S, one of `lowered`, `raised`, `unchanged` and `cannot tell`.")
    difference: Difference | None = about(
        "S after the repair minus S before the repair; None if a test neither finds nor limits S."
    )
    sentences: list[str] = about("The result in sentences.")
    before: Reading = about("The test before the repair.")
    after: Reading = about("The test after the repair.")

    def _summary(self) -> list[str]:
        return [self.effect, *self.sentences]


@result
class Signature(SignatureReading):
    """The result of a signature."""

    def _summary(self) -> list[str]:
        lines = [f"{self.class_}, {self.ramps} ramps"]
        if self.S is not None:
            lines.append(f"S {self.S.value:.2g} % ({self.S.low:.2g} to {self.S.high:.2g})")
        return lines


@result
class SignatureComparison(Result):
    """The comparison of two signatures before and after a repair."""

    effect: str = about("The change of S, one of `lowered`, `raised`, `unchanged` and `cannot tell`.")
    difference: Difference | None = about("S after the repair minus S before the repair; None if a signature does not find S.")
    sentences: list[str] = about("The result in sentences.")
    before: Signature = about("The signature before the repair.")
    after: Signature = about("The signature after the repair.")


def plan_signature(name: str = "", *, op: tuple[float, float] = (0.0, 100.0)) -> SignaturePlan:
    """Plan the signature of a valve: a slow ramp of the OP over the stroke and back, with the position recorded.

    Parameters
    ----------
    name : str, optional
        Tag of the loop.
    op : (float, float), optional
        The OP range of the ramps, percent. The process has to tolerate this range.

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
    """Find slow ramps of the OP in a recording, and judge the valve along the stroke.

    Parameters
    ----------
    recording : Recording or table
        A recording with OP and valve position, or with OP, PV and mode.

    Returns
    -------
    Signature

    Raises
    ------
    ValueError
        If the recording has neither a valve position nor a PV, or no slow ramp up and down. Without a valve position, only ramps
        in manual count.

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
    """Compare the signatures of a valve before and after a repair.

    Parameters
    ----------
    before : Recording or table
        The recording with the signature before the repair; see `signature`.
    after : Recording or table
        The recording with the signature after the repair.

    Returns
    -------
    SignatureComparison

    Raises
    ------
    ValueError
        If a recording has neither a valve position nor a PV, or no slow ramp up and down. Without a valve position, only ramps in
        manual count.

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
    """Size a test for a loop from a recording of the loop's operation.

    If the recording contains an inconclusive test, the plan is for the next test. This plan begins at 0.6 times the size to
    which the PV responded, and has more turns of each size.

    Parameters
    ----------
    recording : Recording or table
        The recording, see `stiction.read` and `stiction.recording`, or a table with the columns of one loop.
    done : iterable of (float, float or None), optional
        The manual moves of a test in the recording, as for `read`.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default from the action of the controller.
    pv_allowed : (float, float), optional
        The lowest and the highest PV that the process tolerates; by default the recorded range, widened by a quarter of this range
        on either side.
    time_s : float, optional
        The longest time in manual, s; by default 20 min, or 40 times the first hold if that is longer, but 8 h at most.

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
        For each turn the time at which the OP was set, s on the recording's clock, and the new value of the OP, percent. None as
        the value marks a return to automatic. By default the turns are found from the mode, or else from the OP.
    plan : TestPlan, optional
        The plan of the test. The result then has a comparison with the plan.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default from the action of the controller, or else from the test.

    Returns
    -------
    Reading

    Raises
    ------
    ValueError
        If the recording has no test, or too few turns of a test.

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
    """Compare the tests of a valve before and after a repair.

    Parameters
    ----------
    before : Recording or table
        The recording with the test before the repair; see `read`.
    after : Recording or table
        The recording with the test after the repair.
    before_done, after_done : iterable of (float, float or None), optional
        The manual moves of each test, like `done` of `read`.
    before_plan, after_plan : TestPlan, optional
        The plan of each test, like `plan` of `read`. Each result then includes the deviations from the plan.
    rises : bool, optional
        Whether the PV rises when the OP rises; by default from the action of the controller, or else from the test.

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        If a recording has no test, or too few turns of a test.

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
