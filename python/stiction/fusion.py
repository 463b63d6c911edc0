"""What signals say about the valve, as numbers free of units, and the frozen model that weighs them."""

from __future__ import annotations

from stiction import _core
from stiction._arrays import Samples, samples
from stiction._result import Result, about, result
from stiction._words import documented
from stiction.diagnosis import Estimate, _interval
from stiction.oscillations import _step

__all__ = [
    "Evidence",
    "Feature",
    "VerdictModel",
    "Weighed",
    "evidence",
    "evidence_features",
    "verdict_model",
    "weigh",
]


@result
class Feature(Result):
    """A number that evidence consists of."""

    name: str = about("Its name.")
    meaning: str = about("What it is.")
    line: str = about("The line of evidence it belongs to.")
    monotone: int = about(
        "1 if more of it can only speak for stiction, -1 if only against, 0 if either.",
        kind="{1, 0, -1}",
    )
    op_only: bool = about("Whether it needs the OP only.")


def evidence_features() -> list[Feature]:
    """List the numbers that evidence consists of.

    Examples
    --------
    >>> import stiction
    >>> len({feature.name for feature in stiction.evidence_features()}) > 100
    True
    """
    return [Feature(**feature) for feature in _core.evidence_features()]


@result
class Evidence(Result):
    """What a window of signals says."""

    values: dict[str, float] = about("The numbers by name, see `evidence_features`; NaN where one cannot be measured.")
    op_span: float = about("Span of the OP without its slow part, percent of span: the scale of S.")
    period_s: float = about("Dominant period, s.")
    op_only: bool = about("Whether it is of the OP alone.")
    z: float = about(
        "Standard errors by which a valve that sticks predicts the PV better than one that follows; 0 where nothing "
        "can be predicted.",
        default=0.0,
    )


@documented
def evidence(op: Samples, pv: Samples | None = None, sp: Samples | None = None, *, sample_time: float) -> Evidence:
    """Measure the evidence in a window of signals.

    Parameters
    ----------
    op : array_like
        Controller output, percent of span. All signals are of one length and finite.
    pv, sp : array_like, optional
        Process value and set point, in units of the PV.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If a signal is of another length or not finite, or there is nothing to measure.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> seen = stiction.evidence(run.op, run.pv, run.sp, sample_time=1)
    >>> stiction.weigh(seen).probability > 0.9
    True
    """
    found = _core.evidence_of(
        samples("op", op),
        None if pv is None else samples("pv", pv),
        None if sp is None else samples("sp", sp),
        _step(sample_time),
    )
    return Evidence(values=dict(found.pop("values")), **found)


@result
class Weighed(Result):
    """What the frozen model makes of evidence."""

    probability: float = about("The probability that the valve is at fault: that it sticks or does not respond.")
    lines: dict[str, float] = about("The probability that each line of evidence gives by itself.")
    causes: dict[str, float] = about("The probability of every cause; they add up to one.")
    S: Estimate = about("S if the valve sticks, percent of span, with its 90 % interval.")
    J_over_S: Estimate = about("J over S if the valve sticks, with its 90 % interval.")
    limit: float | None = about(
        "Had the valve stuck by more, percent of span, it would have shown (95 %); None where nothing could have been "
        "seen, or the OP is alone."
    )
    z: float = about("As that of the evidence; from 3 on a diagnosis does not clear a valve.")
    distance: float = about(
        "How far the evidence is from that of the loops of training; above 1 it is unlike all of them, and what else "
        "is said means little."
    )


def weigh(evidence: Evidence) -> Weighed:
    """Weigh evidence by the frozen model that verdicts rest on.

    Parameters
    ----------
    evidence : Evidence
        As `stiction.evidence` measures it.

    Raises
    ------
    ValueError
        If a number is missing, or the span of the OP is not above 0.
    """
    if not isinstance(evidence, Evidence):
        raise TypeError(f"evidence must be an Evidence, but its type is {type(evidence).__name__}")
    names = [feature["name"] for feature in _core.evidence_features()]
    missing = [name for name in names if name not in evidence.values]
    if missing:
        raise ValueError(f"evidence has no value of {', '.join(missing[:3])}")
    values = [float(evidence.values[name]) for name in names]
    found = _core.weigh_evidence(values, evidence.op_span, evidence.op_only)
    return Weighed(
        probability=found["probability"],
        lines=dict(found["lines"]),
        causes=dict(found["causes"]),
        S=_interval(found["s"]),
        J_over_S=_interval(found["j_over_s"]),
        limit=found["limit"],
        z=evidence.z,
        distance=found["distance"],
    )


@result
class VerdictModel(Result):
    """Where the frozen model comes from: enough to train it again."""

    command: str = about("The command that trained it.")
    population: int = about("Version of the population it was trained on.")
    seed: int = about("Seed of that population.")
    trained: int = about("Members it was trained on.")
    calibrated: int = about("Members after those, on which calibration and intervals rest.")
    features: list[str] = about("The numbers it was trained on, in their order.")
    coverage: float = about("Nominal coverage of its intervals.")


def verdict_model() -> VerdictModel:
    """Tell where the frozen model comes from."""
    return VerdictModel(**_core.verdict_provenance())
