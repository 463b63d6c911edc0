"""Compensators between a controller and a sticking valve, for the time until the valve is repaired.

Compensation treats a symptom. A compensator usually reduces the swing of the PV, at the cost of more stem travel and wear.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stiction import _core, _plots
from stiction._arguments import callback, number, optional, text
from stiction._arrays import Array
from stiction._core import Table
from stiction._document import Compensator, Parameter
from stiction._result import Result, about, result, result_of
from stiction._words import documented, drawn
from stiction.closed_loop import Run, ScenarioLike
from stiction.closed_loop import scenario as _scenario

__all__ = [
    "CompensatedRun",
    "Compensator",
    "CompensatorComparison",
    "CompensatorRow",
    "Measures",
    "Outcome",
    "Parameter",
    "Protocol",
    "compare_compensators",
    "compensate",
    "compensators",
]


def compensators() -> list[Compensator]:
    """List the compensators.

    Examples
    --------
    >>> import stiction
    >>> [each.name for each in stiction.compensation.compensators()][:2]
    ['knocker', 'constant-reinforcement']
    """
    return [result_of(Compensator, each) for each in _core.compensators()]


@result
class Measures(Result):
    """Measures of a loop in a window, for comparison."""

    iae_per_s: float = about("Mean absolute control error (IAE per second), in PV units.")
    pv_std: float = about("Standard deviation of the PV, in PV units.")
    op_travel_per_s: float = about("Travel of the signal that the valve receives, percent per second.")
    vp_travel_per_s: float = about("Stem travel, percent per second, which wears packing and seat.")
    reversals_per_h: float = about("Reversals of the stem per hour.")
    half_pp_op: float
    half_pp_vp: float
    half_pp_pv: float = about(
        "Half of the peak-to-peak range: the signal that the valve receives and the VP in percent of span, the PV in PV units."
    )


@result
class CompensatedRun(Result):
    """A loop with and without a compensator."""

    method: str = about("The compensator.")
    parameters: list[Parameter] = about("Its parameters.")
    at_s: float = about("Time at which the compensator is switched on, s.")
    settle_s: float
    window_s: float = about("Settling time before the measurement, and duration of the measurement, s.")
    run: Run = about("The loop with the compensator. The OP is the output of the controller.")
    signal: Array = about("The signal that the valve receives from the compensator, percent of span.")
    without: Run = about("The loop without the compensator.")
    measures: Measures
    measures_without: Measures = about("Measures in the window, with and without the compensator.")

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Draw PV, signal and valve position before and after the compensator is switched on."""
        process, valve = _plots.axes(ax, 2)
        time = self.run.time_s
        shown = (time >= self.at_s - 0.4 * self.settle_s) & (time <= self.at_s + 0.5 * self.settle_s)
        time = time[shown]
        process.plot(time, self.without.pv[shown], color="0.7", label="PV without compensator")
        process.plot(time, self.run.pv[shown], color="C2", label="PV")
        process.plot(time, self.run.sp[shown], color="0.4", linestyle=":", label="SP")
        process.set_ylabel("PV")
        valve.plot(time, self.signal[shown], label="signal to the valve", linewidth=0.9)
        valve.plot(time, self.run.vp[shown], label="VP")
        valve.set_ylabel("signal, VP (%)")
        valve.set_xlabel("time (s)")
        for each in (process, valve):
            each.axvline(self.at_s, color="C3", linestyle="--", label="switched on")
            _plots.legend_above(each)
        return [process, valve]


@documented
def compensate(
    scenario: ScenarioLike,
    settings: Mapping[str, Any] | None = None,
    *,
    method: str,
    parameters: Mapping[str, float] | None = None,
    S: float | None = None,
    J: float | None = None,
    at_s: float | None = None,
    settle_s: float | None = None,
    window_s: float | None = None,
) -> CompensatedRun:
    """Simulate a loop with and without a compensator between controller and valve.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        A control loop, see `stiction.scenario`. The simulation ends with the measurement, not after the duration of the scenario.
    method : str
        Name of a compensator, see `compensators`.
    parameters : mapping, optional
        Parameters by name as in the result, such as ``{"amplitude": 2}``. Other parameters are chosen from the properties of
        valve and loop.
    S, J : float, optional
        S and J assumed for choosing parameters, percent of span; by default S and J of the valve.
    at_s : float, optional
        Time at which the compensator is switched on, s; by default after ten cycles, or ten settling times of the
        process if that is longer.
    settle_s : float, optional
        Settling time before the measurement, s; by default equal to the default of `at_s`.
    window_s : float, optional
        Duration of the measurement, s; by default equal to the default of `at_s`.

    Raises
    ------
    TypeError
        If `parameters` is not a mapping to numbers.
    ValueError
        If there is no such compensator or parameter, a number is out of its range, or the scenario is not a closed loop.

    Notes
    -----
    The knocker is from Hägglund, J. Process Control 12 (2002) 507. `compensators` lists the sources of the other compensators.

    Examples
    --------
    >>> import stiction
    >>> done = stiction.compensation.compensate("paper/closed-loop", method="knocker", parameters={"width": 1})
    >>> done.measures.pv_std < done.measures_without.pv_std
    True
    """
    if parameters is not None and not isinstance(parameters, Mapping):
        raise TypeError(f"parameters must be a mapping, but its type is {type(parameters).__name__}")
    given = [(text("a name in parameters", k), number(k, v)) for k, v in (parameters or {}).items()]
    found = _core.compensate_loop(
        _scenario(scenario, settings),
        text("method", method),
        given,
        optional("S", S),
        optional("J", J),
        optional("at_s", at_s),
        optional("settle_s", settle_s),
        optional("window_s", window_s),
    )
    return result_of(CompensatedRun, found)


@result
class Outcome(Result):
    """The result of an action in one case."""

    s_factor: float
    j_factor: float = about("Factors on the assumed S and J.")
    noise: bool = about("Whether noise was added to the PV.")
    measures: Measures = about("Measures in the window without changes.")
    set_point_iae_per_s: float
    load_iae_per_s: float = about(
        "Mean absolute control error in the time after the set-point step and after the load step, in PV units."
    )
    set_point_settling_s: float | None
    load_settling_s: float | None = about(
        "Time to settle after the set-point step and after the load step, s; None if the loop did not settle."
    )


@result
class Protocol(Result):
    """The protocol of every action, with a window without changes, a set-point step and a load step."""

    at_s: float = about("Time at which compensators are switched on, s.")
    settle_s: float = about("Settling time before the measurement, s.")
    window_s: float = about("Duration of the window without changes, s.")
    step_s: float = about("Duration of each step, s.")
    set_point_step: float = about("Height of the set-point step, in PV units.")
    load_step: float = about("Height of the load step, percent.")
    settling_band: float = about("Control error within which the loop has settled, in PV units.")
    error: float = about("Relative error of the assumed S and J, in both directions.")
    noise_sd: float = about("Standard deviation of the noise in the case with noise, in PV units.")
    seed: int = about("Seed of the noise.")


@result
class CompensatorRow(Result):
    """A compensator, or the loop without a compensator, in a comparison."""

    action: str = about('Name of the compensator, or ``"as it is"``.')
    parameters: list[Parameter] = about("Nominal parameters.")
    error: float = about("Mean absolute control error in the window of the nominal case, in PV units.")
    worst_error: float = about(
        "Mean absolute control error in the worst of the cases without noise, in PV units. This error determines the "
        "rank."
    )
    reduction: float = about("Factor by which the standard deviation of the PV falls; infinite for a fall to 0.")
    outcomes: list[Outcome] = about(
        "The nominal case first, then S and J wrong (both too small, only S too small, only J too small, both too large), then "
        "with noise."
    )


@result
class CompensatorComparison(Result):
    """Compensators side by side."""

    rows: list[CompensatorRow] = about(
        "The loop without a compensator, and the loop with each compensator, by ascending worst error."
    )
    protocol: Protocol = about("The protocol of the comparison.")

    def _summary(self) -> list[str]:
        best = self.rows[0]
        return [
            f"CompensatorComparison of {len(self.rows)} rows",
            f"smallest control error: {best.action}, {best.worst_error:.3g} PV units in the worst case",
        ]

    def to_table(self) -> Table:
        """Return a row for every compensator and case.

        Returns
        -------
        Table
            Columns are rank, action, s_factor, j_factor, noise, the first five measures, and settling time and error of each
            step.
        """
        return _table(self.rows)

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Draw control error and stem travel for every compensator, with correct and wrong S and J."""
        return _bars(self.rows, ax)


def _table(rows: Sequence[Any]) -> Table:
    """Return a table of rows with an action and the outcomes of the action."""
    cases = [(rank, row.action, outcome) for rank, row in enumerate(rows, 1) for outcome in row.outcomes]

    def column(name: str) -> tuple[str, Array]:
        held = (getattr(of, name) if hasattr(of, name) else getattr(of.measures, name) for _, _, of in cases)
        return name, np.array(list(held), dtype=np.float64)

    measures = ("iae_per_s", "pv_std", "op_travel_per_s", "vp_travel_per_s", "reversals_per_h")
    steps = ("set_point_settling_s", "load_settling_s", "set_point_iae_per_s", "load_iae_per_s")
    return _core.table_of(
        [
            ("rank", [rank for rank, _, _ in cases]),
            ("action", [action for _, action, _ in cases]),
            column("s_factor"),
            column("j_factor"),
            ("noise", [of.noise for _, _, of in cases]),
            *map(column, (*measures, *steps)),
        ]
    )


def _bars(rows: Sequence[Any], ax: Any) -> Any:
    """Draw error and travel of every row. A line spans the cases without noise."""
    error, travel = _plots.axes(ax, 2, sharex=False, height=max(2.0, 0.33 * len(rows)))
    names = [row.action for row in rows]
    places = np.arange(len(rows))
    quantities = (
        (error, "mean absolute control error (PV units)", "iae_per_s"),
        (travel, "stem travel (%/s)", "vp_travel_per_s"),
    )
    for each, label, measure in quantities:
        nominal = [getattr(row.outcomes[0].measures, measure) for row in rows]
        quiet = [[getattr(o.measures, measure) for o in row.outcomes if not o.noise] for row in rows]
        colours = ["0.6" if name == "as it is" else "C0" for name in names]
        each.barh(places, nominal, color=colours, label="S and J known")
        low, high = [min(values) for values in quiet], [max(values) for values in quiet]
        each.hlines(places, low, high, color="k", linewidth=2, label="S and J wrong")
        each.set_yticks(places, names)
        each.invert_yaxis()
        each.set_xlabel(label)
    _plots.legend_above(error)
    return [error, travel]


def _names(name: str, values: Sequence[str] | None) -> list[str] | None:
    if values is None:
        return None
    if isinstance(values, str):
        raise TypeError(f"{name} must be a sequence of names, but its type is str")
    return [text(f"a name in {name}", each) for each in values]


@documented
def compare_compensators(
    scenario: ScenarioLike,
    settings: Mapping[str, Any] | None = None,
    *,
    methods: Sequence[str] | None = None,
    S: float | None = None,
    J: float | None = None,
    at_s: float | None = None,
    progress: Callable[[int], object] | None = None,
) -> CompensatorComparison:
    """Compare compensators with correct S and J, with S and J wrong by half, and with noise.

    Each simulation has a window without changes, a set-point step and a load step.

    Parameters
    ----------
    methods : sequence of str, optional
        Names of compensators, see `compensators`; by default all.
    S, J : float, optional
        S and J assumed for the valve, percent of span; by default S and J of the valve.
    at_s : float, optional
        Time at which compensators are switched on, s; by default after ten cycles, or ten settling times of the
        process if that is longer.
    progress : callable, optional
        Called with the number of finished simulations after each increase: six for each compensator, and two for the loop without
        a compensator.

    Raises
    ------
    TypeError
        If `methods` is not a sequence of names, or `progress` cannot be called.
    ValueError
        If there is no such compensator, the scenario is not a closed loop, or the signals grow without bound.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.compensation.compare_compensators("paper/closed-loop", methods=["knocker"])
    >>> [row.action for row in found.rows]
    ['knocker', 'as it is']
    """
    found = _core.compare_compensators(
        _scenario(scenario, settings),
        _names("methods", methods),
        optional("S", S),
        optional("J", J),
        optional("at_s", at_s),
        callback("progress", progress),
    )
    return result_of(CompensatorComparison, found)
