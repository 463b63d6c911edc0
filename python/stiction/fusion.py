"""Evidence on a valve as numbers without units, and the frozen model that weighs the evidence."""

from __future__ import annotations

from stiction import _core
from stiction._arguments import positive
from stiction._arrays import Samples, samples
from stiction._document import Estimate
from stiction._result import Result, about, result, result_of
from stiction._words import documented

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
    """A feature of the evidence."""

    name: str = about("Its name.")
    meaning: str = about("Its meaning.")
    line: str = about("Line of evidence.")
    monotone: int = about(
        "1 if larger values are evidence for stiction, -1 if larger values are evidence against stiction, 0 if both are possible.",
        kind="{1, 0, -1}",
    )
    op_only: bool = about("Whether the feature needs only the OP.")


def evidence_features() -> list[Feature]:
    """List the features of the evidence.

    Examples
    --------
    >>> import stiction
    >>> len({feature.name for feature in stiction.fusion.evidence_features()}) > 100
    True
    """
    return [Feature(**feature) for feature in _core.evidence_features()]


@result
class Evidence(Result):
    """The evidence in a window of signals."""

    values: dict[str, float] = about("The numbers by name, see `evidence_features`; NaN for a number that cannot be measured.")
    op_span: float = about("Span of the fast part of the OP, percent of span, which is the scale of S.")
    period_s: float = about("Dominant period, s.")
    op_only: bool = about("Whether the evidence is from the OP alone.")
    z: float = about(
        "How much better a sticking valve predicts the PV than a valve that follows the OP, in standard errors; 0 if "
        "nothing can be predicted.", default=0.0
    )


@documented
def evidence(op: Samples, pv: Samples | None = None, sp: Samples | None = None, *, sample_time: float) -> Evidence:
    """Measure the evidence in a window of signals.

    Parameters
    ----------
    op : array_like
        Controller output, percent of span. All signals have the same length and are finite.
    pv, sp : array_like, optional
        Process value and set point, in PV units.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, a sample is not finite, or there is nothing to measure.

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
        positive("sample_time", sample_time),
    )
    return Evidence(**found)


@result
class Weighed(Result):
    """The result of the frozen model for the evidence."""

    probability: float = about("The probability that the valve sticks or does not respond.")
    lines: dict[str, float] = about("The probability from each line of evidence alone.")
    causes: dict[str, float] = about("The probability of every cause. The probabilities add up to one.")
    S: Estimate = about("S if the valve sticks, percent of span, with a 90 % interval.")
    J_over_S: Estimate = about("J over S if the valve sticks, with a 90 % interval.")
    limit: float | None = about(
        "Detection limit of S, percent of span (95 %); None for a limit above three spans of the OP, or with only the OP."
    )
    z: float = about("The `z` of the evidence. From 3 on, a diagnosis does not clear a valve.")
    distance: float = about(
        "Distance of the evidence from the evidence of the training loops; above 1 the recording is unlike all training "
        "loops, and the other results are unreliable."
    )


def weigh(evidence: Evidence) -> Weighed:
    """Weigh evidence with the frozen model behind the verdicts.

    Parameters
    ----------
    evidence : Evidence
        The result of `stiction.evidence`.

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
    return result_of(Weighed, {**found, "z": evidence.z})


@result
class VerdictModel(Result):
    """The provenance of the frozen model, with which the training can be repeated."""

    command: str = about("The command that trained the model.")
    population: int = about("Version of the population that trained the model.")
    seed: int = about("Seed of the population.")
    trained: int = about("Number of simulated loops in the training.")
    calibrated: int = about("Number of further simulated loops for calibration and intervals.")
    features: list[str] = about("The features of the training, in order.")
    coverage: float = about("Nominal coverage of the intervals.")


def verdict_model() -> VerdictModel:
    """Return the provenance of the frozen model."""
    return VerdictModel(**_core.verdict_provenance())
