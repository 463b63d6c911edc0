"""Models of process and valve fitted to recorded signals."""

from __future__ import annotations

from typing import Any

from stiction import _core, _plots
from stiction._arguments import at_least_zero, choice, integer, number, optional, positive
from stiction._arrays import Array, Samples, samples
from stiction._core import Bands
from stiction._document import Estimate
from stiction._result import Result, about, result, result_of
from stiction._words import documented, drawn

__all__ = [
    "Arx",
    "ExtendedArx",
    "FirstOrderFit",
    "FittedNumber",
    "HammersteinFit",
    "PositionFit",
    "PositionFits",
    "StemFit",
    "ValveEvidence",
    "ValveFit",
    "bands_of_cycle",
    "fit_arx",
    "fit_extended_arx",
    "fit_first_order",
    "fit_hammerstein",
    "fit_position",
    "fit_stem",
    "weigh_valve",
]


@result
class FirstOrderFit(Result):
    """A first-order process with dead time, fitted to OP and PV."""

    gain: float
    gain_error: float = about(
        "Gain and standard error of the gain, PV units per percent of the OP; for an integrating process, PV units per "
        "percent and s."
    )
    time_constant_s: float | None
    time_constant_error_s: float | None = about(
        "Time constant and standard error of the time constant, s; None for an integrating process."
    )
    dead_time_s: float
    dead_time_error_s: float = about("Dead time and standard error of the dead time, s.")
    delay: int = about("Delay from OP to PV, samples.")
    explained: float = about("Explained share of the variance of the PV.")
    pv: Array = about("The PV of the model, in PV units.")


@documented
def fit_first_order(
    op: Samples,
    pv: Samples,
    *,
    sample_time: float,
    integrating: bool = False,
    longest_delay: int = 40,
) -> FirstOrderFit:
    """Fit a first-order process with dead time by the output error (Ljung, 1999).

    Parameters
    ----------
    op : array_like
        The recorded valve position, or else the OP, percent of span.
    pv : array_like
        Process value.
    integrating : bool, default False
        Whether the process integrates.
    longest_delay : int, default 40
        The longest dead time to try, samples.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If there are too few samples, a signal does not move, or the process cannot be identified.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("paper/closed-loop")
    >>> fit = stiction.identification.fit_first_order(run.vp[::10], run.pv[::10], sample_time=10 * run.sample_time)
    >>> fit.explained > 0.99
    True
    """
    found = _core.fit_fopdt(
        samples("op", op),
        samples("pv", pv),
        positive("sample_time", sample_time),
        bool(integrating),
        integer("longest_delay", longest_delay, 1),
    )
    return FirstOrderFit(**found)


@result
class Arx(Result):
    """A linear model of the PV from the past of the PV and the OP."""

    gain: float = about(
        "Static gain, PV units per percent; meaningless for an integrating process."
    )
    delay: int = about("Delay from OP to PV, samples, at least 1.")
    constant: float = about("Constant term, in PV units.")
    past: list[float] = about("Coefficients of the PV one to five samples before.")
    taps: list[float] = about(
        "Coefficients of the OP at the delay and up to three samples before, PV units per percent."
    )
    residual_std: float = about("Standard deviation of the residuals, in PV units.")
    explained: float = about("Explained share of the variance of the PV from sample to sample.")
    predicted: Array = about("One-step prediction of the PV, in PV units. The first samples are recorded values.")


def fit_arx(op: Samples, pv: Samples, *, longest_delay: int = 40) -> Arx:
    """Fit an ARX model of the PV from the last five values of the PV and four neighbouring values of the OP.

    Parameters
    ----------
    op : array_like
        Controller output or valve position, percent of span.
    pv : array_like
        Process value, in PV units.
    longest_delay : int, default 40
        The longest dead time to try, samples. The best delay is used.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, are too short or not finite, or a signal does not move.

    References
    ----------
    L. Ljung, System Identification: Theory for the User, 2nd ed., Prentice Hall (1999), section 4.2 (recalled, not
    read).

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> stiction.identification.fit_arx(run.vp, run.pv).explained > 0.9
    True
    """
    return Arx(**_core.fit_arx(samples("op", op), samples("pv", pv), integer("longest_delay", longest_delay, 1)))


@result
class ExtendedArx(Result):
    """A linear model with a drifting disturbance."""

    past: list[float] = about("Coefficients of the last two outputs.")
    taps: list[float] = about("Coefficients of the two inputs.")
    error: float = about("Coefficient of the last innovation.")
    variance: float = about("Variance of the innovations.")
    log_likelihood: float = about("Logarithm of the likelihood, without a constant.")
    samples: int = about("Number of innovations in the likelihood.")
    process: Array
    disturbance: Array = about("Contributions of the input and of the disturbance to the output.")
    predicted: Array = about("The output minus the innovations.")


def fit_extended_arx(input: Samples, output: Samples, *, delay: int, walk: float) -> ExtendedArx:
    """Fit an extended ARX model (Karra and Karim, 2009).

    Parameters
    ----------
    input, output : array_like
        Signals of equal length and of magnitude 1, such as standardised signals.
    delay : int
        Delay from input to output, samples, at least 1.
    walk : float
        Variance of the disturbance's steps, divided by the variance of the innovations; 0 means a constant disturbance.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, are too short, or nothing can be fitted.
    """
    given = at_least_zero("walk", walk)
    x, y = samples("input", input), samples("output", output)
    if len(x) != len(y):
        raise ValueError(f"input has {len(x)} samples, but output has {len(y)}")
    found = _core.fit_earx(x, y, integer("delay", delay, 1), given)
    if found is None:
        raise ValueError("nothing can be fitted: there are too few samples, or they are not finite")
    return ExtendedArx(**found)


@result
class HammersteinFit(Result):
    """A valve model before a linear process, fitted to OP and PV."""

    method: str = about("The method.")
    model: str = about("The valve model.")
    S: float
    J: float = about("S and J of the valve, percent of span.")
    sticks: bool = about("Whether the method decides that the valve sticks.")
    gain: float = about(
        "Logarithm of a ratio: mean square error with a valve that follows the OP, divided by the error with this valve."
    )
    threshold: float = about("Gain above which the method decides for stiction.")
    delay: int = about("Delay from valve to PV, samples of the fit.")
    profile_S: Array
    profile_gain: Array = about(
        "Tried values of S, ascending, percent of span, and the gain of each S with the best J."
    )
    factor: int = about("Recorded samples per sample of the fit.")
    first: int = about("First recorded sample of the fit.")
    op: Array
    vp: Array = about("OP and position of the valve, percent of span.")
    pv: Array
    fitted: Array = about("PV with mean 0 and variance 1, and the fit of this PV.")
    cause: str | None = about("Cause of the oscillation, only for Karra and Karim's method.")
    disturbance_share: float | None = about(
        "Share of the disturbance in the variance of the PV, only for Karra and Karim's method."
    )
    disturbance: Array | None = about("Contribution of the disturbance to the PV, only for Karra and Karim's method.")

    @drawn(1)
    def plot(self, ax: Any = None) -> Any:
        """Draw the gain over the tried values of S."""
        [made] = _plots.axes(ax)
        made.plot(self.profile_S, self.profile_gain, "o", label=f"{self.method}, {self.model} valve")
        made.axhline(self.threshold, color="grey", linestyle=":", label="threshold")
        made.axvline(self.S, color="C1", linestyle="--", label=f"S = {self.S:.2f} %")
        made.set(xlabel="S (% of span)", ylabel="gain (-)")
        made.legend()
        return made


@documented
def fit_hammerstein(
    op: Samples,
    pv: Samples,
    *,
    sample_time: float,
    method: str = "jelali",
    period_s: float | None = None,
    threshold: float | None = None,
) -> HammersteinFit:
    """Fit a valve model before a linear process to OP and PV of a loop that oscillates.

    Parameters
    ----------
    method : {"srinivasan", "lee", "jelali", "karra-karim"}, default "jelali"
        The method of Srinivasan et al. (2005), Lee et al. (2008), Jelali (2008) or Karra and Karim (2009).
    threshold : float, optional
        Gain above which the method decides for stiction; by default the threshold of the method.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, a sample is not finite, a signal does not move, there is no period, or there are too few
        samples.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> fit = stiction.identification.fit_hammerstein(run.op, run.pv, sample_time=1)
    >>> fit.sticks, abs(fit.S - 4) < 0.5
    (True, True)
    """
    known = ("srinivasan", "lee", "jelali", "karra-karim")
    return HammersteinFit(
        **_core.fit_hammerstein(
            choice("method", method, known),
            samples("op", op),
            samples("pv", pv),
            positive("sample_time", sample_time),
            None if period_s is None else positive("period_s", period_s),
            optional("threshold", threshold),
        )
    )


@result
class ValveFit(Result):
    """The process with a sticking valve of one model."""

    model: str = about("The valve's model.")
    s_over_span: float = about("S as a share of the span of the fast part of the OP.")
    j_over_s: float = about("J as a share of S.")
    delay: int = about("Delay, samples.")
    mse: float = about("Mean square residual of one-step prediction, as a share of the variance of the PV.")
    gain: float = about(
        "Logarithm of a ratio: squared residuals with a valve that follows the OP, divided by the residuals with this valve."
    )
    information: float = about("The gain by Schwarz's criterion.")
    jump_gain: float = about("Gain from the slip jump; near 0, J is not identified.")
    width: float = about("Logarithm of the ratio of the largest to the smallest S that explain the PV almost as well.")
    profile_s: Array
    profile_mse: Array = about(
        "Tried values of S, as shares of the span, and the smallest mean square residual over J and delay."
    )


@result
class ValveEvidence(Result):
    """How much better a sticking valve explains the PV than a valve that follows the OP, with controls.

    All gains are logarithms of ratios of squared residuals. 0 means no evidence.
    """

    samples: int = about("Number of predicted samples.")
    op_span: float = about("Span of the fast part of the OP, in standard deviations of the OP.")
    linear_mse: float = about("Mean square residual with a valve that follows the OP, as a share of the variance of the PV.")
    two_phase: ValveFit
    he: ValveFit = about("The fit with a two-phase valve, and with a valve of He et al. (2007).")
    best: str = about("The name of the model that predicts the PV better.")
    kurtosis: float = about("Excess kurtosis of the residuals of the better model.")
    forward_gain: float
    reversed_gain: float = about("Gain of the first two-phase candidates, in forward and in reversed time.")
    walk_gain: float = about("Gain if the disturbance is a random walk.")
    over_load: float = about("Evidence against a load that jumps at the slips of the model.")
    over_placebo: float = about("Evidence against sticking valves that receive a different OP.")
    output_error_gain: float = about("Gain without the past of the PV as an input.")
    over_sensor: float = about("Evidence against play in the sensor.")
    slip_rate: float = about("Slips per period.")
    slip_concentration: float = about("Concentration of the error of the linear process at the slips.")
    slip_removed: float = about("Share of the energy of the linear process's error that the sticking valve explains.")


@documented
def weigh_valve(op: Samples, pv: Samples, *, sample_time: float, period_s: float | None = None) -> ValveEvidence:
    """Compare a sticking valve before a linear process with a valve that follows the OP.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, a sample is not finite, a signal does not move, there is no period, or there are too few
        samples.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> evidence = stiction.identification.weigh_valve(run.op, run.pv, sample_time=1)
    >>> evidence.two_phase.gain > 0.1
    True
    """
    period = None if period_s is None else positive("period_s", period_s)
    found = _core.weigh_hammerstein(samples("op", op), samples("pv", pv), positive("sample_time", sample_time), period)
    return result_of(ValveEvidence, found)


@result
class PositionFit(Result):
    """A valve model fitted to a recorded position."""

    model: str = about("The model.")
    bands: Bands = about("S and J, percent of span of the OP.")
    gain: float = about("Gain, percent of VP per percent of the model's position.")
    offset: float = about("VP where the model's position is 0, percent of span.")
    delay: int = about("Delay of VP behind the model, samples.")
    rmse: float = about("Root mean square error, percent of VP.")
    explained: float = about("Explained share of the variance of VP.")
    information: float = about("Schwarz's information; only differences are meaningful.")
    slips: int = about("Number of slips of the model.")
    vp: Array = about("VP of the model, percent of span.")


@result
class PositionFits(Result):
    """All valve models fitted to a recorded position."""

    S: Estimate
    J: Estimate = about("S and J of the best fit, percent of span, with the 90 % interval of a block bootstrap.")
    ranked: list[PositionFit] = about("The fits, the best first.")


@documented
def fit_position(op: Samples, vp: Samples) -> PositionFits:
    """Fit all valve models to a recorded valve position.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, are too short, not finite or do not move.

    Examples
    --------
    >>> import numpy as np, stiction
    >>> k = np.arange(1000)
    >>> op = 50 + 8 * np.sin(0.045 * k) + 4 * np.sin(0.0173 * k)
    >>> fits = stiction.identification.fit_position(op, stiction.valve(op, S=5, J=2))
    >>> fits.ranked[0].model, abs(fits.S.value - 5) < 0.3
    ('two-phase', True)
    """
    return result_of(PositionFits, _core.fit_valve_position(samples("op", op), samples("vp", vp)))


@result
class FittedNumber(Result):
    """A fitted number."""

    value: float = about("The number.")
    deviation: float | None = about("Standard deviation; None if the number does not affect the recording.")


@result
class StemFit(Result):
    """A stem with friction fitted to a recorded position."""

    static_band: FittedNumber = about("Static friction over spring constant, percent of span of the OP.")
    coulomb_band: FittedNumber = about("Coulomb friction over spring constant, percent of span of the OP.")
    lag_s: FittedNumber = about("Viscous friction over spring constant, s.")
    bands: Bands = about("The resulting S and J, percent of span.")
    gain: float = about("Gain, percent of VP per percent of the stem's position.")
    offset: float = about("VP where the stem's position is 0, percent of span.")
    rmse: float = about("Root mean square error, percent of VP.")
    explained: float = about("Explained share of the variance of VP.")
    information: float = about("Schwarz's information; only differences are meaningful.")
    slips: int = about("Number of slips of the stem against the last direction of motion.")
    vp: Array = about("VP of the stem model, percent of span.")
    data_driven: PositionFit = about("The data-driven model that fits these samples best.")
    explains_better: bool = about("Whether Schwarz's information prefers the stem to the data-driven model.")
    unidentified: list[str] = about("Parameters that the recording does not identify, with the reason.")


@documented
def fit_stem(op: Samples, vp: Samples, *, sample_time: float) -> StemFit:
    """Fit a stem with classical friction to a recorded valve position.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If the signals differ in length, are too short, not finite or do not move, or the stem hardly slips.
    """
    step = positive("sample_time", sample_time)
    return result_of(StemFit, _core.fit_valve_stem(samples("op", op), samples("vp", vp), step))


def bands_of_cycle(
    period_s: float,
    op_amplitude: float,
    *,
    process_gain: float,
    controller_gain: float,
    time_constant_s: float,
    dead_time_s: float,
) -> Bands:
    """Return S and J of a cycle in closed form, for a known loop and controller.

    The process is first-order with dead time, and the integral time of the PI controller equals the time constant of the process.

    Parameters
    ----------
    period_s : float
        Period of the cycle, s.
    op_amplitude : float
        Half of the peak-to-peak value of the OP, percent of span.
    process_gain : float
        PV units per percent.
    controller_gain : float
        Percent per PV unit.
    time_constant_s : float
        Time constant of the process and integral time, s.
    dead_time_s : float
        Dead time, s.

    Raises
    ------
    ValueError
        If no valve causes this cycle.

    Examples
    --------
    >>> import stiction
    >>> known = dict(process_gain=3, controller_gain=0.2, time_constant_s=10, dead_time_s=10)
    >>> bands = stiction.identification.bands_of_cycle(218 / 3, 25 / 7, **known)
    >>> round(bands.S, 6), round(bands.J, 6)
    (5.0, 5.0)
    """
    return _core.cycle_bands(
        number("period_s", period_s),
        number("op_amplitude", op_amplitude),
        number("process_gain", process_gain),
        number("controller_gain", controller_gain),
        number("time_constant_s", time_constant_s),
        number("dead_time_s", dead_time_s),
    )
