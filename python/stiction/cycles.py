"""Limit cycles of a loop, predicted instead of simulated, and the dependence of the cycles on parameters.

The prediction holds in continuous time, at the final set point and load, without noise and far from the limits of the OP. Two
methods find cycles: ``"exact"`` follows the loop from slip to slip, and ``"describing-function"`` uses harmonic balance, as if OP
and VP were sines.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from stiction import _core, _plots
from stiction._arguments import choice, integer, number, optional, text
from stiction._arrays import Array, Samples, samples
from stiction._core import Bands, Table
from stiction._document import Tuning
from stiction._result import Result, about, result, result_of
from stiction._words import documented, drawn
from stiction.closed_loop import ScenarioLike
from stiction.closed_loop import scenario as _scenario

__all__ = [
    "Assessment",
    "Cycle",
    "FrequencyResponse",
    "LimitCycleMap",
    "LimitCycles",
    "Retuning",
    "Sensitivity",
    "Trajectory",
    "Tuning",
    "describing_function",
    "frequency_response",
    "lambda_tuning",
    "least_amplitude",
    "limit_cycle",
    "limit_cycle_map",
    "limit_cycle_member",
    "limit_cycle_trajectory",
    "limit_cycles",
    "load_step_iae",
    "loop_parameters",
    "retune",
    "sensitivities",
    "simc",
]

ComplexArray = npt.NDArray[np.complex128]

METHODS = ("exact", "describing-function")


@result
class Cycle(Result):
    """A limit cycle."""

    method: str = about('The method, ``"exact"`` or ``"describing-function"``.')
    period_s: float = about("Period, s.")
    half_pp_op: float
    half_pp_vp: float
    half_pp_pv: float = about(
        "Half of the peak-to-peak range: OP and VP in percent of span, PV in PV units. By the describing function, the "
        "value for the VP is the amplitude of the fundamental."
    )
    middle_op: float
    middle_vp: float
    middle_pv: float = about("Middle between the extremes: OP and VP in percent of span, PV in PV units.")
    stable: bool = about("Whether nearby motions approach the cycle, or the family of the cycle.")
    multipliers: ComplexArray = about(
        "Floquet multipliers, the largest first: the shares of small deviations that remain after a period. Empty for a method "
        "without multipliers."
    )
    slips: int = about("Number of slips per period.")


@result
class LimitCycles(Result):
    """The result of a search for limit cycles."""

    method: str = about('``"exact"`` or ``"describing-function"``.')
    state: str = about('``"cycle"``, ``"no cycle"`` or ``"not known"``.')
    cycles: list[Cycle] = about(
        "The cycles. The exact method lists cycles that attract first. Describing functions list the largest cycle first."
    )
    reasons: list[str] = about(
        "The reasons for no cycle, or for an unknown result. With cycles, how other motions end."
    )
    no_part: list[str] = about("Keys of the scenario that do not affect the prediction.")

    @property
    def cycle(self) -> Cycle | None:
        """The first cycle that attracts; None if no cycle attracts."""
        return next((cycle for cycle in self.cycles if cycle.stable), None)


@documented
def limit_cycle(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None, *, method: str = "exact"
) -> LimitCycles:
    """Predict the final limit cycle of a loop that starts near equilibrium.

    Parameters
    ----------
    method : {"exact", "describing-function"}, default "exact"
        The method: exact, from slip to slip, or by harmonic balance.

    Returns
    -------
    LimitCycles
        The result has one cycle, or the reason for no cycle.

    Raises
    ------
    ValueError
        If the scenario is not a closed loop, or the method does not support the loop; the message gives the reason.

    Notes
    -----
    The exact flow is solved by the method of steps (Hairer, Norsett, Wanner, 1993). Harmonic balance uses describing functions
    (Choudhury, Thornhill, Shah, Control Engineering Practice 13 (2005) 641-658). Loeb's criterion (1956) shows whether cycles by
    harmonic balance attract. Harmonic balance misses cycles that are far from a sine.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.limit_cycle("paper/closed-loop", {"valve.S": 5, "valve.J": 3})
    >>> round(found.cycle.period_s, 4)
    18.0437
    >>> stiction.limit_cycle("paper/closed-loop", {"valve.J": 0}).state
    'no cycle'
    """
    return result_of(LimitCycles, _core.limit_cycle(_scenario(scenario, settings), choice("method", method, METHODS), False))


@documented
def limit_cycles(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None, *, method: str = "exact"
) -> LimitCycles:
    """Find all limit cycles of a loop, including cycles that do not attract.

    Parameters
    ----------
    method : {"exact", "describing-function"}, default "exact"
        The method: exact, or harmonic balance. The exact method follows tens of motions that start between the equilibrium and
        far outside the friction bands.

    Raises
    ------
    ValueError
        If the scenario is not a closed loop, or the method does not support the loop.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.cycles.limit_cycles("paper/closed-loop", method="describing-function")
    >>> [cycle.stable for cycle in found.cycles]
    [True]
    """
    return result_of(LimitCycles, _core.limit_cycle(_scenario(scenario, settings), choice("method", method, METHODS), True))


@documented
def limit_cycle_member(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None, *, offset: float
) -> LimitCycles:
    """Find a member of the family of cycles of a stem that moves only in slips.

    Valve models of He, of He and Wang, and of Stenman have a family of cycles. The start determines the member in which a loop
    ends.

    Parameters
    ----------
    offset : float
        Difference between the stem positions of the member and of the symmetric member, percent of span; positive if the member
        is higher.

    Raises
    ------
    ValueError
        If the valve model has no family of cycles.

    Examples
    --------
    >>> import stiction
    >>> he = {"valve.model": "he", "valve.S": 5, "valve.J": 1}
    >>> round(stiction.cycles.limit_cycle_member("paper/closed-loop", he, offset=0.1).cycle.period_s, 4)
    49.6075
    """
    return result_of(LimitCycles, _core.limit_cycle_member(_scenario(scenario, settings), number("offset", offset)))


@result
class Trajectory(Result):
    """An exact limit cycle over one period."""

    cycle: Cycle = about("The cycle.")
    time_s: Array = about("Times since a slip upward, s; at a jump of the VP, a time occurs twice.")
    op: Array
    vp: Array = about("OP and VP relative to the operating point of the loop, percent of span.")
    pv: Array = about("PV relative to the operating point, in PV units.")
    set_point: float = about("Set point relative to the operating point, in PV units.")

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Draw OP and VP, and the PV, over time."""
        valve, process = _plots.axes(ax, 2)
        valve.plot(self.time_s, self.op, label="OP")
        valve.plot(self.time_s, self.vp, label="VP")
        valve.set_ylabel("OP, VP (%)")
        process.plot(self.time_s, self.pv, color="C2", label="PV")
        process.axhline(self.set_point, color="0.5", linestyle=":", label="set point")
        process.set_ylabel("PV")
        process.set_xlabel("time (s)")
        for each in (valve, process):
            _plots.legend_above(each)
        return [valve, process]

    @drawn(2)
    def plot_phase(self, ax: Any = None) -> Any:
        """Draw VP and PV over OP."""
        valve, process = _plots.axes(ax, 2)
        valve.plot(self.op, self.vp, color="C1", label="VP")
        valve.set_ylabel("VP (%)")
        process.plot(self.op, self.pv, color="C2", label="PV")
        process.set_ylabel("PV")
        process.set_xlabel("OP (%)")
        for each in (valve, process):
            _plots.legend_above(each)
        return [valve, process]


@documented
def limit_cycle_trajectory(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None, *, samples: int = 1000
) -> Trajectory:
    """Return the final exact limit cycle of a loop over one period.

    Parameters
    ----------
    samples : int, default 1000
        Number of equally spaced times in the period, in addition to slips and stops of the stem. Values are exact at each time,
        not interpolated.

    Raises
    ------
    ValueError
        If the loop has no final cycle (`limit_cycle` gives the reason), or the cycle cannot be computed exactly.

    Examples
    --------
    >>> import stiction
    >>> orbit = stiction.cycles.limit_cycle_trajectory("paper/closed-loop", samples=100)
    >>> len(orbit.time_s) >= 100
    True
    """
    found = _core.limit_cycle_trajectory(_scenario(scenario, settings), integer("samples", samples, 1))
    if found is None:
        raise ValueError("the loop has no final limit cycle; stiction.limit_cycle gives the reason")
    return result_of(Trajectory, found)


@documented
def describing_function(
    amplitude: Samples, S: float, J: float, *, model: str = "two-phase", slips: int | None = None
) -> ComplexArray:
    """Return the describing function N(X) of a sticking valve.

    N(X) is the complex gain from the OP, a sine of amplitude X, to the fundamental of the VP, in closed form. The motion is
    steady, and the VP and the OP have equal middles.

    Parameters
    ----------
    amplitude : array_like
        Amplitudes X of the OP, percent of span, above 0.
    slips : int, optional
        Number of slips of the stem in one direction; by default the smallest possible. The models of He, of He and Wang, and of
        Stenman permit several numbers of slips under one sine.

    Returns
    -------
    ndarray of complex
        N(X); 0 if the sine is too small to move the valve, see `least_amplitude`.

    Raises
    ------
    TypeError
        If `amplitude` holds no real numbers.
    ValueError
        If an amplitude is not positive, the valve cannot slip this often under the sine, or there is no such model.

    Notes
    -----
    Choudhury, Thornhill, Shah, Control Engineering Practice 13 (2005) 641-658; derived again for every model.

    Examples
    --------
    >>> import stiction
    >>> stiction.cycles.describing_function([10], S=5, J=2).round(4)
    array([0.9148-0.1751j])
    """
    sines = samples("amplitude", amplitude)
    stroke = None if slips is None else integer("slips", slips, 1)
    return _core.describing_function(sines, number("S", S), number("J", J), text("model", model), stroke)


@documented
def least_amplitude(S: float, J: float, *, model: str = "two-phase") -> float:
    """Return the amplitude of a sine of the OP above which the valve keeps moving.

    Returns
    -------
    float
        Percent of span.

    Raises
    ------
    ValueError
        If a value is out of its range, or there is no such model.

    Examples
    --------
    >>> import stiction
    >>> stiction.cycles.least_amplitude(S=5, J=2)
    2.5
    """
    return _core.least_amplitude(number("S", S), number("J", J), text("model", model))


@result
class FrequencyResponse(Result):
    """The frequency response of a loop that is cut open at the valve."""

    omega: Array = about("Frequencies, rad/s.")
    loop_gain: ComplexArray = about(
        "L(jw) of controller and process, with the sign for which ``L N = -1`` is the condition of a cycle."
    )
    process_gain: ComplexArray = about("G(jw), the response from VP to PV, PV units per percent.")
    stability: str = about(
        'Whether the loop would be ``"stable"``, ``"marginal"`` or ``"unstable"`` if the valve followed the OP.'
    )
    gain_crossover: float | None = about("Frequency with ``|L| = 1`` and the phase nearest to -180 degrees, rad/s.")
    phase_margin: float | None = about("Distance of the phase from -180 degrees at `gain_crossover`, rad.")
    ultimate_frequency: float | None = about(
        "Frequency of oscillation at the stability limit of the gain, rad/s."
    )
    gain_margin: float | None = about("Factor by which the gain may rise up to the stability limit.")
    peak_sensitivity: float = about("Ms, the largest of ``|1 / (1 + L)|``.")
    peak_frequency: float = about("Frequency of `peak_sensitivity`, rad/s.")
    crossing_omega: Array = about("Frequencies of the cycles by harmonic balance, rad/s.")
    crossings: ComplexArray = about("L at the frequencies `crossing_omega`, where L meets ``-1/N(X)``.")
    crossing_slips: list[int] = about(
        "Number of slips of the stem in one direction, for each cycle by harmonic balance."
    )
    model: str = about("The valve model.")
    bands: Bands = about("S and J of the valve.")

    @drawn(1)
    def plot(self, ax: Any = None) -> Any:
        """Draw the Nyquist plot of the loop with ``-1/N(X)`` of its valve."""
        (ax,) = _plots.axes(ax, height=5.0)
        S, J = self.bands.S, self.bands.J
        marks = np.concatenate([self.crossings, [-1, 0]])
        low, high = marks.real.min(), marks.real.max()
        left, right = marks.imag.min(), marks.imag.max()
        room = 0.3 * max(high - low, right - left)
        ax.axhline(0, color="0.8", linewidth=0.8)
        ax.axvline(0, color="0.8", linewidth=0.8)
        ax.plot(self.loop_gain.real, self.loop_gain.imag, color="k", label="L(jω)")
        # A valve that moves in steps has a curve for every number of slips.
        most = max([1, *self.crossing_slips])
        for slips in range(1, most + 1):
            branch = _core.describing_function_branch(S, J, self.model, slips)
            if branch is None:
                break
            low_x, high_x = max(branch[0], 1e-3), min(branch[1], 1e4 * max(branch[0], 1e-3))
            amplitude = low_x + (high_x - low_x) * np.geomspace(1e-9, 1, 2000)
            valve = -1 / _core.describing_function(amplitude, S, J, self.model, slips)
            label = f"−1/N(X), S = {S:g} %, J = {J:g} %" if slips == 1 else f"the same, {slips} slips per stroke"
            ax.plot(valve.real, valve.imag, color=f"C{slips}", label=label)
        ax.plot(-1, 0, "k+", markersize=10, label="−1")
        if len(self.crossings):
            ax.plot(self.crossings.real, self.crossings.imag, "o", color="C3", label="cycle by harmonic balance")
        for omega, at in zip(self.crossing_omega, self.crossings, strict=True):
            ax.annotate(
                f"T = {2 * np.pi / omega:.3g} s", (at.real, at.imag), (8, -3), textcoords="offset points"
            )
        ax.set_xlim(low - room, high + room)
        ax.set_ylim(left - room, right + room)
        ax.set_xlabel("real part")
        ax.set_ylabel("imaginary part")
        ax.legend(loc="lower right")
        return ax


@documented
def frequency_response(
    scenario: ScenarioLike,
    settings: Mapping[str, Any] | None = None,
    *,
    omega: Samples | None = None,
) -> FrequencyResponse:
    """Return the frequency response of a loop without the valve, with margins and stability.

    Parameters
    ----------
    omega : array_like, optional
        Frequencies, rad/s; by default a thousand over the range in which L is between 50 and 1/50.

    Raises
    ------
    TypeError
        If `omega` holds no real numbers.
    ValueError
        If the scenario is not a closed loop, or its gain is 0 or grows without limit with frequency.

    Notes
    -----
    Margins follow Åström and Hägglund, Advanced PID Control (2006). Stability with dead time follows Walton and Marshall, IEE
    Proc. D 134 (1987) 101-107.

    Examples
    --------
    >>> import stiction
    >>> response = stiction.cycles.frequency_response("paper/closed-loop")
    >>> round(response.peak_sensitivity, 3), response.stability
    (1.569, 'stable')
    """
    at = None if omega is None else samples("omega", omega)
    return FrequencyResponse(**_core.frequency_response(_scenario(scenario, settings), at))


@result
class LimitCycleMap(Result):
    """The limit cycles of a loop over two parameters."""

    x_name: str
    y_name: str = about("Names of the parameters, see `loop_parameters`.")
    x_unit: str
    y_unit: str = about("Units of the parameters.")
    x: Array
    y: Array = about("Values of the parameters.")
    method: str = about("The method that found the cycles.")
    state: npt.NDArray[np.str_] = about(
        'State of the result: ``"cycle"``, ``"no cycle"`` or ``"not known"``. The state and all arrays below have a row for each '
        "value of `y` and a column for each value of `x`."
    )
    period_s: Array = about("Periods, s; NaN without a cycle.")
    half_pp_op: Array
    half_pp_vp: Array
    half_pp_pv: Array = about("Half of the peak-to-peak range: OP and VP in percent of span, PV in PV units.")
    slips: Array = about("Number of slips per period.")
    reason: npt.NDArray[np.str_] = about("The reason for no cycle, or for an unknown result.")
    boundary: Array = about(
        "Boundary of the region with cycles, halfway between points with and without a cycle. The array of shape ``(n, "
        "2, 2)`` has line segments with the ends ``(x, y)``."
    )

    def to_table(self) -> Table:
        """Return one row for every point.

        Returns
        -------
        Table
            Columns are the two parameters, state, period_s, half_pp_op, half_pp_vp, half_pp_pv, slips and reason.
        """
        columns, rows = np.meshgrid(self.x, self.y)
        numbers = ("period_s", "half_pp_op", "half_pp_vp", "half_pp_pv")
        return _core.table_of(
            [
                (self.x_name, columns.ravel()),
                (self.y_name, rows.ravel()),
                ("state", self.state.ravel().tolist()),
                *((name, getattr(self, name).ravel()) for name in numbers),
                ("slips", [None if np.isnan(slips) else int(slips) for slips in self.slips.ravel()]),
                ("reason", [reason or None for reason in self.reason.ravel().tolist()]),
            ]
        )

    def plot(self, ax: Any = None, *, show: str = "pv") -> Any:
        """Draw a quantity of the cycles over the two parameters, with the boundary of the region with cycles.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Axes to draw on; by default new axes.
        show : {"pv", "op", "vp", "period"}, default "pv"
            Half of the peak-to-peak range of a signal, or the period.

        Returns
        -------
        matplotlib axes
        """
        what = {
            "pv": ("half peak-to-peak PV", self.half_pp_pv),
            "op": ("half peak-to-peak OP (%)", self.half_pp_op),
            "vp": ("half peak-to-peak VP (%)", self.half_pp_vp),
            "period": ("period (s)", self.period_s),
        }
        label, values = what[choice("show", show, what)]
        (ax,) = _plots.axes(ax, height=5.0)
        ax.set_facecolor("0.9")
        mesh = ax.pcolormesh(self.x, self.y, np.ma.masked_invalid(values), shading="nearest")
        ax.figure.colorbar(mesh, ax=ax, label=label)
        for k, ((x0, y0), (x1, y1)) in enumerate(self.boundary):
            ax.plot([x0, x1], [y0, y1], color="C3", linewidth=2, label="" if k else "boundary of cycling")
        if (self.state != "cycle").any():
            ax.fill_between([], [], [], color="0.9", label="no cycle, or not known")
        for name, unit, put in ((self.x_name, self.x_unit, ax.set_xlabel), (self.y_name, self.y_unit, ax.set_ylabel)):
            put(f"{name} ({unit})" if unit else name)
        if ax.get_legend_handles_labels()[0]:
            ax.legend(loc="upper right")
        return ax


def loop_parameters() -> dict[str, str]:
    """List the parameters of a loop that a map can vary.

    Returns
    -------
    dict
        Units by name: S, J, J/S, Kc, Ti, Kp (gain of the process), theta (dead time), tau (sum of the lags) and theta/tau.

    Examples
    --------
    >>> import stiction
    >>> stiction.cycles.loop_parameters()["Ti"]
    's'
    """
    return dict(_core.loop_parameters())


def _axis(name: str, axis: Any) -> tuple[str, Array]:
    try:
        parameter, values = axis
    except (TypeError, ValueError):
        raise TypeError(f'{name} must be a pair of a name and values, such as ("Kc", [0.5, 1.0, 1.5])') from None
    return text(f"the name in {name}", parameter), samples(f"the values in {name}", values)


@documented
def limit_cycle_map(
    scenario: ScenarioLike,
    settings: Mapping[str, Any] | None = None,
    *,
    x: tuple[str, Samples],
    y: tuple[str, Samples],
    method: str = "exact",
    progress: Callable[[int], object] | None = None,
) -> LimitCycleMap:
    """Map the final limit cycle of a loop over two parameters of the loop.

    Parameters
    ----------
    x, y : tuple of str and array_like
        A parameter (see `loop_parameters`) and its values, such as ``("Kc", numpy.linspace(0.5, 2, 40))``. J is unchanged when S
        is varied, and the integral time is unchanged when Kc is varied.
    method : {"exact", "describing-function"}, default "exact"
        The method that finds cycles.
    progress : callable, optional
        Called with the number of finished points. An exception in the callback ends the computation.

    Raises
    ------
    TypeError
        If `x` or `y` is not a pair of a name and values.
    ValueError
        If `x` and `y` vary the same quantity, the loop has no such parameter, or the scenario is not a closed loop.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.cycles.limit_cycle_map("paper/closed-loop", x=("J", [0, 2, 4]), y=("Kc", [0.8, 1.1]))
    >>> found.state.tolist()
    [['no cycle', 'cycle', 'cycle'], ['no cycle', 'cycle', 'cycle']]
    """
    across, up = _axis("x", x), _axis("y", y)
    found = _core.limit_cycle_map(
        _scenario(scenario, settings), across, up, choice("method", method, METHODS), progress
    )
    shape = (len(up[1]), len(across[1]))
    for name in ("state", "reason", "period_s", "half_pp_op", "half_pp_vp", "half_pp_pv", "slips"):
        found[name] = np.asarray(found[name]).reshape(shape)
    found["boundary"] = found["boundary"].reshape(-1, 2, 2)
    return LimitCycleMap(**found)


@result
class Sensitivity(Result):
    """The sensitivity of a limit cycle to a parameter, in percent per percent."""

    parameter: str = about("The parameter, see `loop_parameters`.")
    unit: str = about("Its unit.")
    value: float = about("Its value.")
    period: float = about("Sensitivity of the period.")
    half_pp_op: float
    half_pp_vp: float
    half_pp_pv: float = about("Sensitivities of half of the peak-to-peak ranges.")


@documented
def sensitivities(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None
) -> list[Sensitivity]:
    """Return the change of the exact limit cycle in percent per percent of each parameter.

    Returns
    -------
    list of Sensitivity
        One sensitivity for every parameter of the loop that is not 0; an empty list without a cycle.

    Raises
    ------
    ValueError
        If the scenario is not a closed loop, or the cycle cannot be computed exactly.

    Examples
    --------
    >>> import stiction
    >>> [each.parameter for each in stiction.cycles.sensitivities("paper/closed-loop")]
    ['S', 'J', 'Kc', 'Ti', 'Kp', 'theta', 'tau']
    """
    return [Sensitivity(**each) for each in _core.sensitivities(_scenario(scenario, settings))]


@documented
def simc(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None, *, tc: float | None = None
) -> Tuning:
    """Return Skogestad's PI tuning for the process of a loop.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        A control loop, see `stiction.scenario`. The function ignores controller and valve.
    tc : float, optional
        Time constant of the closed loop, s; by default the dead time, which is Skogestad's choice.

    Raises
    ------
    ValueError
        If the process is not of first order, of second order with real stable poles and no zero, or an
        integrator; or `tc` plus dead time is not positive.

    Notes
    -----
    Skogestad, J. Process Control 13 (2003) 291-309.

    Examples
    --------
    >>> import stiction
    >>> tuning = stiction.cycles.simc("paper/closed-loop")
    >>> round(tuning.kc, 4), round(tuning.ti, 4)
    (1.8474, 5.93)
    """
    return Tuning(**_core.simc(_scenario(scenario, settings), optional("tc", tc)))


@documented
def lambda_tuning(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None, *, time_constant_s: float
) -> Tuning:
    """Return the PI tuning that cancels the pole of the process of a loop.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        A control loop, see `stiction.scenario`. The function ignores controller and valve.
    time_constant_s : float
        Lambda, the time constant of the closed loop, s.

    Raises
    ------
    ValueError
        If the process has no dominant time constant, or `time_constant_s` plus dead time is not positive.

    Examples
    --------
    >>> import stiction
    >>> round(stiction.cycles.lambda_tuning("paper/closed-loop", time_constant_s=5.93).kc, 4)
    0.5648
    """
    return Tuning(
        **_core.lambda_tuning(_scenario(scenario, settings), number("time_constant_s", time_constant_s))
    )


@documented
def load_step_iae(scenario: ScenarioLike, settings: Mapping[str, Any] | None = None) -> float:
    """Return the integral of the absolute error (IAE) after a load step, for a valve that follows the OP.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        A control loop, see `stiction.scenario`. Its valve is ignored.

    Returns
    -------
    float
        The IAE after a step of 1 percent, PV units times s.

    Raises
    ------
    ValueError
        If the loop is not stable, has no integral action or does not settle.

    Examples
    --------
    >>> import stiction
    >>> round(stiction.cycles.load_step_iae("paper/closed-loop"), 2)
    2.96
    """
    return _core.load_step_iae(_scenario(scenario, settings))


@result
class Assessment(Result):
    """The performance of a tuning with a sticking valve."""

    tuning: Tuning = about("The tuning.")
    ms: float = about("Ms, the peak of the sensitivity function; infinite if the loop is not stable.")
    load_iae: float | None = about("IAE after a load step of 1 percent, see `load_step_iae`.")
    cycle: Cycle | None = about("The limit cycle with the sticking valve; None if the loop has no limit cycle.")


@result
class Retuning(Result):
    """The robust PI tuning with the smallest swing of the PV, and the present tuning."""

    present: Assessment
    best: Assessment = about("The present tuning, and the best tuning within the bound.")
    ms_bound: float = about("The bound on Ms.")
    pv_ratio: float | None = about(
        "PV swing with the best tuning, divided by the PV swing with the present tuning; None if the divisor is 0."
    )
    iae_ratio: float | None = about(
        "Cost of retuning: IAE of a load step with the best tuning, divided by the IAE with the present tuning."
    )
    robust_tunings: int = about("Number of tunings within the bound.")
    unjudged_tunings: int = about("Number of tunings within the bound whose cycle could not be determined.")
    at_edge: bool = about(
        "Whether the best tuning is at the edge of the search range, which means that a better tuning may exist "
        "outside the range."
    )


@documented
def retune(
    scenario: ScenarioLike,
    settings: Mapping[str, Any] | None = None,
    *,
    ms: float = 1.7,
    method: str = "exact",
    within: float = 5.0,
    points: int = 21,
    progress: Callable[[int], object] | None = None,
) -> Retuning:
    """Find the robust PI tuning with the smallest swing of the PV in the limit cycle, and the cost of that tuning.

    Parameters
    ----------
    ms : float, default 1.7
        Largest permitted peak of the sensitivity function, above 1.
    method : {"exact", "describing-function"}, default "exact"
        The method that finds cycles. Do not rely on a "no cycle" of the describing function.
    within : float, default 5
        Largest factor between new and present gain and integral time, above 1.
    points : int, default 21
        Number of gains, and of integral times, tried before the search is refined.
    progress : callable, optional
        Called with the number of judged tunings. An exception in the callback ends the search.

    Raises
    ------
    ValueError
        If the scenario is not a closed loop or has no integral action, no tuning is within the bound, or a number is
        out of its range.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.cycles.retune("paper/closed-loop", method="describing-function", points=5)
    >>> found.pv_ratio < 1
    True
    """
    found = _core.retune(
        _scenario(scenario, settings),
        number("ms", ms),
        choice("method", method, METHODS),
        number("within", within),
        integer("points", points, 2),
        progress,
    )
    return result_of(Retuning, found)
