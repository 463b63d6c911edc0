"""The methods that detect stiction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stiction import _core, _plots
from stiction._arguments import positive, text
from stiction._arrays import Array, Samples, samples
from stiction._result import Result, about, result, result_of
from stiction._words import documented

__all__ = [
    "Detector",
    "EvidencePanel",
    "EvidenceSeries",
    "Finding",
    "MethodEvidence",
    "detect",
    "detect_all",
    "detectors",
    "method_evidence",
]

_DRAWN = {"line": "-", "steps": "-", "dashed": "--", "dotted": ":", "points": "o"}
"""Styles of series in Matplotlib's notation."""


@result
class Detector(Result):
    """A method that detects stiction."""

    name: str = about('Name of the method, such as ``"horch"``.')
    title: str = about("Its title.")
    source: str = about("Authors, year and journal, with a note on parts that were recalled, not read.")
    statistic: str = about("Its statistic. Larger values support a positive decision.")
    rule: str = about("The decision rule with thresholds.")
    family: str = about("Kind of evidence. Methods of one family share one vote.")
    applies: str = about("The loops for which the method was made.")
    decides: str = about("The meaning of a positive decision.", kind='{"stiction", "nonlinearity"}')
    needs: str = about("The signals that the method needs.")
    explains_oscillation: bool = about("Whether the method explains the cause of an oscillation that was found before.")
    parameters: dict[str, tuple[float, str]] = about("Parameters by name, each with value and unit.")


@result
class Finding(Result):
    """The result of one method."""

    name: str
    title: str = about("Name and title of the method.")
    decision: str = about(
        'The decision: ``"sticks"``, ``"does not stick"``, ``"nonlinear"``, ``"linear"``, ``"undecided"`` or '
        '``"abstains"``.'
    )
    statistic: float | None = about("The number that decides; None for an abstention.")
    statistic_name: str = about("The name of the statistic.")
    threshold: float | None = about("Value of the statistic from which the decision is positive.")
    reason: str = about("Explanation of the numbers, or the reason for abstaining.")
    numbers: dict[str, float | None] = about("All numbers of the method by name; None for a number that is not finite.")
    units: dict[str, str] = about("Units of the numbers by name; empty for a ratio or a count.")
    caveats: list[str] = about("Caveats on the decision.")
    parameters: dict[str, tuple[float, str]] = about("The parameters of the method by name, each with value and unit.")
    family: str = about("Kind of evidence.")
    votes: bool = about("Whether the decision counts in the vote of the family.")
    reference: str = about("Authors, year, journal.")

    @classmethod
    def _prepared(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        numbers, parameters = document["numbers"], document["parameters"]
        return {
            **document,
            "numbers": {each["name"]: each["value"] for each in numbers},
            "units": {each["name"]: each["unit"] for each in numbers},
            "parameters": {each["name"]: (each["value"], each["unit"]) for each in parameters},
        }


@result
class EvidenceSeries(Result):
    """A curve, a cloud of points or a mark."""

    x: Array
    y: Array = about("Coordinates of its points.")
    style: str = about("How the points are drawn.", kind='{"line", "dashed", "dotted", "steps", "points", "bars"}')


@result
class EvidencePanel(Result):
    """Series for one pair of axes."""

    x_label: str
    y_label: str = about("Labels of the axes, with units.")
    series: dict[str, EvidenceSeries] = about(
        "The series by name. A mark is a series of one point, and a vertical line is a series of two points."
    )


@result
class MethodEvidence(Result):
    """The evidence of a method, as drawn in the report."""

    method: str = about("Name of the method.")
    caption: str = about("The caption of the panels.")
    panels: list[EvidencePanel] = about(
        "The panels, one for each pair of axes. A panel shows only the last periods of a long recording, and only a selection "
        "of many points. The caption states what a panel leaves out."
    )

    def plot(self, ax: Any = None) -> Any:
        """Draw the panels.

        Parameters
        ----------
        ax : axes or sequence of axes, optional
            Axes to draw on, one per panel; by default new axes.

        Returns
        -------
        list of matplotlib.axes.Axes
        """
        made = _plots.axes(ax, len(self.panels), sharex=False, height=3.0)
        for axes, panel in zip(made, self.panels):
            for name, (x, y, style) in panel.series.items():
                if style == "bars":
                    axes.bar(x, y, width=x[1] - x[0] if len(x) > 1 else 1.0, label=name)
                else:
                    axes.plot(x, y, _DRAWN[style], drawstyle="steps-post" if style == "steps" else None, label=name)
            axes.set(xlabel=panel.x_label, ylabel=panel.y_label)
            _plots.legend_above(axes)
        return made


def detectors() -> list[Detector]:
    """List the methods.

    Returns
    -------
    list of Detector
        The methods in the order of reports.

    Examples
    --------
    >>> import stiction
    >>> {method.name: method.needs for method in stiction.detection.detectors()}["horch"]
    'OP and PV'
    """
    return [Detector(**method) for method in _core.detector_methods()]


@documented
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
    """Apply one method to a valve's signals.

    Parameters
    ----------
    op : array_like
        Controller output, percent of span. All signals have the same length and are finite.
    pv, sp : array_like, optional
        Process value and set point, in PV units.
    vp : array_like, optional
        Measured valve position, percent of span.
    period_s : float, optional
        Period of the oscillation, s; by default the period of the dominant oscillation, as in a diagnosis. Without an oscillation,
        methods that explain the cause of an oscillation abstain.

    Returns
    -------
    Finding
        A finding is also returned if the method abstains.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If there is no such method, the signals differ in length, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> stiction.detect("curve-fit", run.op, run.pv, run.sp, sample_time=1, loop_type="flow").decision
    'sticks'
    """
    signals = _signals(op, pv, sp, vp, sample_time, period_s, loop_type)
    [finding] = _core.detect_stiction([text("method", method)], signals)
    return result_of(Finding, finding)


@documented
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
    """Apply all methods to a valve's signals.

    Parameters
    ----------
    op, pv, sp, vp : array_like
        As in `detect`.

    Returns
    -------
    dict of Finding
        The results by name of the method, in the order of `detectors`.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, or a sample is not finite.
    """
    found = _core.detect_stiction(None, _signals(op, pv, sp, vp, sample_time, period_s, loop_type))
    return {each["name"]: result_of(Finding, each) for each in found}


@documented
def method_evidence(
    method: str,
    op: Samples,
    pv: Samples | None = None,
    sp: Samples | None = None,
    vp: Samples | None = None,
    *,
    sample_time: float,
    period_s: float | None = None,
    loop_type: str = "unknown",
) -> MethodEvidence | None:
    """Return the arrays from which a method decides, such as the correlation, the fitted wave, or the analysed path.

    Parameters
    ----------
    op, pv, sp, vp : array_like
        As in `detect`.

    Returns
    -------
    MethodEvidence or None
        None if the method cannot be applied.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If there is no such method, the signals differ in length, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> seen = stiction.detection.method_evidence("horch", run.op, run.pv, sample_time=1, loop_type="flow")
    >>> lag, correlation, _ = seen.panels[0].series["correlation"]
    """
    signals = _signals(op, pv, sp, vp, sample_time, period_s, loop_type)
    return _evidence(_core.method_evidence(text("method", method), signals))


def _evidence(found: dict[str, Any] | None) -> MethodEvidence | None:
    return None if found is None else MethodEvidence(**{**found, "panels": [_panel(**each) for each in found["panels"]]})


def _panel(x_label: str, y_label: str, series: list[tuple[str, Array, Array, str]]) -> EvidencePanel:
    named: dict[str, EvidenceSeries] = {}
    for name, x, y, style in series:
        # A series without a name in the legend is named after its axis, or by its number if there are several.
        name = name or y_label
        alike = sum(each == name or each.startswith(f"{name} #") for each in named)
        named[f"{name} #{alike + 1}" if alike else name] = EvidenceSeries(x=x, y=y, style=style)
    return EvidencePanel(x_label=x_label, y_label=y_label, series=named)


def _signals(
    op: Samples,
    pv: Samples | None,
    sp: Samples | None,
    vp: Samples | None,
    sample_time: float,
    period_s: float | None,
    loop_type: str,
) -> tuple[Any, ...]:
    return (
        samples("op", op),
        None if pv is None else samples("pv", pv),
        None if sp is None else samples("sp", sp),
        None if vp is None else samples("vp", vp),
        positive("sample_time", sample_time),
        None if period_s is None else positive("period_s", period_s),
        text("loop_type", loop_type),
    )
