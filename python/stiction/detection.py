"""The published detectors of stiction."""

from __future__ import annotations

import json
from typing import Any

from stiction import _core
from stiction._arguments import text
from stiction._arrays import Samples, samples
from stiction._result import Result, result
from stiction.oscillations import _period, _step

__all__ = ["Detector", "Finding", "detect", "detect_all", "detectors"]


@result
class Detector(Result):
    """A published method.

    Attributes
    ----------
    name : str
        Its name, such as ``"horch"``.
    title : str
        Its title.
    source : str
        Authors, year, journal; and what of it was recalled, not read.
    statistic : str
        What its statistic is. The larger it is, the more it speaks for a positive decision.
    rule : str
        The decision rule with its thresholds.
    family : str
        What it looks at: methods of one family have one vote together.
    applies : str
        The loops it was made for.
    decides : {"stiction", "nonlinearity"}
        What a positive decision means.
    needs : str
        The signals it cannot do without.
    explains_oscillation : bool
        Whether it was made to tell the cause of an oscillation that was found before.
    parameters : dict
        Its parameters by name, each with its value and its unit.
    """

    name: str
    title: str
    source: str
    statistic: str
    rule: str
    family: str
    applies: str
    decides: str
    needs: str
    explains_oscillation: bool
    parameters: dict[str, tuple[float, str]]


@result
class Finding(Result):
    """What a method says of signals.

    Attributes
    ----------
    name, title : str
        Name and title of the method.
    decision : str
        ``"sticks"``, ``"does not stick"``, ``"nonlinear"``, ``"linear"``, ``"undecided"`` or ``"abstains"``.
    statistic : float or None
        The number the decision rests on; None if it abstains.
    statistic_name : str
        What that number is.
    threshold : float or None
        Its value from which the decision is positive.
    reason : str
        What the numbers say, or why it abstains.
    numbers : dict
        All numbers of the method by name; None where one is not finite.
    units : dict
        Their units by name; empty for a ratio or a count.
    caveats : list of str
        What to keep in mind.
    parameters : dict
        The parameters of the method by name, each with its value and its unit.
    family : str
        What it looks at.
    votes : bool
        Whether its decision is counted in the vote of its family.
    reference : str
        Authors, year, journal.
    """

    name: str
    title: str
    decision: str
    statistic: float | None
    statistic_name: str
    threshold: float | None
    reason: str
    numbers: dict[str, float | None]
    units: dict[str, str]
    caveats: list[str]
    parameters: dict[str, tuple[float, str]]
    family: str
    votes: bool
    reference: str


def detectors() -> list[Detector]:
    """List the published detectors.

    Returns
    -------
    list of Detector
        In the order of reports.

    Examples
    --------
    >>> import stiction
    >>> {method.name: method.needs for method in stiction.detectors()}["horch"]
    'OP and PV'
    """
    return [
        Detector(parameters={name: (value, unit) for name, value, unit in method.pop("parameters")}, **method)
        for method in _core.detector_methods()
    ]


def detect(
    method: str,
    op: Samples,
    pv: Samples | None = None,
    sp: Samples | None = None,
    vp: Samples | None = None,
    *,
    sample_time: float,
    period_s: float | None = None,
    loop_type: str = "unknown",
) -> Finding:
    """Ask one published method whether a valve sticks.

    Parameters
    ----------
    method : str
        Its name, see `detectors`.
    op : array_like
        Controller output, percent of span. All signals are of one length and finite.
    pv, sp : array_like, optional
        Process value and set point, in units of the PV.
    vp : array_like, optional
        Measured valve position, percent of span.
    sample_time : float
        Time between samples, s.
    period_s : float, optional
        Period of the oscillation, s; by default that of the dominant one, as in a diagnosis. Without an
        oscillation, methods that tell its cause abstain.
    loop_type : str, default "unknown"
        What the loop controls, see `loop_types`.

    Returns
    -------
    Finding
        Also where the method abstains.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If there is no such method, or a signal is of another length or not finite.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> stiction.detect("curve-fit", run.op, run.pv, run.sp, sample_time=1, loop_type="flow").decision
    'sticks'
    """
    [finding] = _detect([text("method", method)], op, pv, sp, vp, sample_time, period_s, loop_type)
    return finding


def detect_all(
    op: Samples,
    pv: Samples | None = None,
    sp: Samples | None = None,
    vp: Samples | None = None,
    *,
    sample_time: float,
    period_s: float | None = None,
    loop_type: str = "unknown",
) -> dict[str, Finding]:
    """Ask all published methods whether a valve sticks.

    Parameters
    ----------
    op, pv, sp, vp : array_like
        As in `detect`.
    sample_time : float
        Time between samples, s.
    period_s : float, optional
        Period of the oscillation, s; by default that of the dominant one.
    loop_type : str, default "unknown"
        What the loop controls, see `loop_types`.

    Returns
    -------
    dict of Finding
        By name of the method, in the order of `detectors`.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If a signal is of another length or not finite.
    """
    return {each.name: each for each in _detect(None, op, pv, sp, vp, sample_time, period_s, loop_type)}


def _detect(
    methods: list[str] | None,
    op: Samples,
    pv: Samples | None,
    sp: Samples | None,
    vp: Samples | None,
    sample_time: float,
    period_s: float | None,
    loop_type: str,
) -> list[Finding]:
    found = _core.detect_stiction(
        methods,
        samples("op", op),
        None if pv is None else samples("pv", pv),
        None if sp is None else samples("sp", sp),
        None if vp is None else samples("vp", vp),
        _step(sample_time),
        _period(period_s),
        text("loop_type", loop_type),
    )
    return [_finding(json.loads(each)) for each in found]


def _finding(found: dict[str, Any]) -> Finding:
    numbers = found.pop("numbers")
    return Finding(
        numbers={each["name"]: each["value"] for each in numbers},
        units={each["name"]: each["unit"] for each in numbers},
        parameters={each["name"]: (each["value"], each["unit"]) for each in found.pop("parameters")},
        **found,
    )
