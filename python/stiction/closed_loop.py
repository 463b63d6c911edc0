"""Simulated loops, described by scenarios."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from os import PathLike, fspath
from typing import Any, TypeAlias

import numpy as np

from stiction import _core
from stiction._arguments import callback, instance, number
from stiction._arrays import Array
from stiction._core import Scenario, Table
from stiction._frames import frame
from stiction._plots import axes, pv_over_time, valve_over_time
from stiction._result import Result, about, result, result_of
from stiction._words import documented, drawn
from stiction.own import OwnController, OwnProcess, OwnValve
from stiction.stem import Stem
from stiction.valves import Valve

__all__ = [
    "CascadeRun",
    "OpenLoopRun",
    "Run",
    "Scenario",
    "Sweep",
    "scenario",
    "scenarios",
    "signal",
    "simulate",
    "simulate_cascade",
    "simulate_open_loop",
    "sweep",
]

ScenarioLike: TypeAlias = Scenario | str | PathLike[str] | Mapping[str, Any]
"""A scenario, the name of a built-in scenario, the path of a TOML file, or the tables of such a file as a mapping."""


def scenario(source: ScenarioLike, settings: Mapping[str, Any] | None = None) -> Scenario:
    """Return a scenario to simulate.

    Parameters
    ----------
    source : str, path, mapping or Scenario
        The name of a built-in scenario (see `scenarios`), the path of a TOML file, or the tables of such a
        file as nested mappings. ``docs/scenarios.md`` of the project lists every key with its unit.
    settings : mapping, optional
        Changes to the scenario, by dotted key, such as ``{"valve.S": 4}``.

    Raises
    ------
    ValueError
        If the scenario is not well formed; the message gives line and key.

    Examples
    --------
    >>> import stiction
    >>> sticky = stiction.scenario({
    ...     "controller": {"kc": 1.1, "ti": 2.5},
    ...     "valve": {"model": "two-phase", "S": 5, "J": 3},
    ...     "process": {"gain": 1.5, "tau": 5.93, "delay": 1.07},
    ...     "set_point": {"value": 5},
    ...     "sample_time": 0.01,
    ...     "duration": 600,
    ... })
    >>> round(stiction.simulate(sticky).period_s, 3)
    18.024
    """
    if settings is not None and not isinstance(settings, Mapping):
        raise TypeError(f"settings must be a mapping, but its type is {type(settings).__name__}")
    if isinstance(source, Scenario):
        return _core.scenario_parse(source.text, settings)
    if isinstance(source, Mapping):
        return _core.scenario_parse(source, settings)
    if not isinstance(source, (str, PathLike)):
        kind = type(source).__name__
        raise TypeError(f"source must be a scenario, its name, path or tables, but its type is {kind}")
    return _core.scenario_open(fspath(source), settings)


class Signals(Result):
    """Signals over time."""

    @property
    def time_s(self) -> Array:
        """Times of the samples, s."""
        made: Any = self
        return np.arange(len(made.op), dtype=np.float64) * np.float64(made.sample_time)

    def _signals(self) -> list[tuple[str, Array]]:
        signals = [(name, getattr(self, name, None)) for name in ("time_s", "sp", "pv", "op", "vp")]
        return [(name, signal) for name, signal in signals if signal is not None]

    def to_table(self) -> Table:
        """Return the signals as an Arrow table.

        Returns
        -------
        Table
            The existing columns among ``time_s``, ``sp``, ``pv``, ``op`` and ``vp``. A cascade has the columns of the slave,
            ``master_sp`` and ``master_pv``.
        """
        return _core.table_of(self._signals())

    def to_pandas(self) -> Any:
        """Return the signals as a pandas data frame.

        Returns
        -------
        pandas.DataFrame
            The columns of `to_table`, with ``time_s`` as the index.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return frame(dict(self._signals()), "time_s")


@result
class Run(Signals):
    """The signals of a simulated loop."""

    sample_time: float = about("Time between samples, s; sample ``k`` is at time ``k * sample_time``.")
    sp: Array
    pv: Array = about("Set point and measured process value, in PV units.")
    op: Array
    vp: Array = about("Controller output and valve position, percent of span.")
    period_s: float | None = about("Mean period of the PV in the second half of the run, s, whatever its cause; None if the PV does not oscillate.")
    half_pp_op: float
    half_pp_vp: float
    half_pp_pv: float = about(
        "Half of the peak-to-peak range in the second half of the run: OP and VP in percent of span, PV in PV units."
    )
    growth: float | None = about(
        "Range of the PV in the last quarter of the run, divided by the range of the PV in the third quarter; None if "
        "the divisor is 0."
    )

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Plot SP and PV, and OP and VP, over time."""
        above, below = axes(ax, 2)
        pv_over_time(above, self.time_s, self.sp, self.pv)
        valve_over_time(below, self.time_s, self.op, self.vp)
        return [above, below]


@result
class CascadeRun(Signals):
    """The signals of a simulated cascade, a slave loop under a master."""

    slave: Run = about("The slave loop, with the sticking valve; the master gives the set point of the slave.")
    sp: Array
    pv: Array = about(
        "Set point and measured process value of the master, in PV units of the master, at the samples of the slave."
    )

    @property
    def time_s(self) -> Array:
        """Times of the samples, s."""
        return self.slave.time_s

    def _signals(self) -> list[tuple[str, Array]]:
        return [*self.slave._signals(), ("master_sp", self.sp), ("master_pv", self.pv)]

    @drawn(3)
    def plot(self, ax: Any = None) -> Any:
        """Plot set points and PVs of master and slave, and OP and VP, over time."""
        master, slave, valve = axes(ax, 3)
        pv_over_time(master, self.time_s, self.sp, self.pv, "master: PV, SP (PV units)")
        pv_over_time(slave, self.time_s, self.slave.sp, self.slave.pv, "slave: PV, SP (PV units)")
        valve_over_time(valve, self.time_s, self.slave.op, self.slave.vp)
        return [master, slave, valve]


@result
class OpenLoopRun(Signals):
    """The signals of a valve on a test signal, without a loop."""

    sample_time: float = about("Time between samples, s; sample ``k`` is at time ``k * sample_time``.")
    op: Array
    vp: Array = about("Controller output and valve position, percent of span.")
    period_s: float | None = about("Period of the VP in the second half of the run, s; None without a period.")
    half_pp_op: float
    half_pp_vp: float = about("Half of the peak-to-peak range in the second half of the run, percent of span.")

    def plot(self, ax: Any = None) -> Any:
        """Plot OP and VP over time, and the VP over the OP.

        Parameters
        ----------
        ax : sequence of matplotlib Axes, optional
            Two axes to draw on, with separate x axes; by default new axes.

        Returns
        -------
        list of matplotlib Axes
        """
        over_time, characteristic = axes(ax, 2, sharex=False, height=3.0)
        valve_over_time(over_time, self.time_s, self.op, self.vp)
        characteristic.plot(self.op, self.vp, color="C3")
        characteristic.set_xlabel("OP (% of span)")
        characteristic.set_ylabel("VP (% of span)")
        return [over_time, characteristic]


def _simulated(scenario: ScenarioLike, settings: Mapping[str, Any] | None, kind: str) -> dict[str, Any]:
    """Simulate a scenario of one kind. For a different kind, the error names the right function."""
    parsed = _scenario(scenario, settings)
    if parsed.kind != kind:
        known = {"closed loop": "simulate", "cascade": "simulate_cascade", "open loop": "simulate_open_loop"}
        raise ValueError(
            f'the scenario "{parsed.title}" is of the kind "{parsed.kind}", but must be "{kind}";'
            f" `{known[parsed.kind]}` simulates it"
        )
    return _core.simulate(parsed)


@documented
def simulate(
    scenario: ScenarioLike,
    settings: Mapping[str, Any] | None = None,
    *,
    controller: OwnController | None = None,
    valve: OwnValve | Valve | Stem | None = None,
    process: OwnProcess | None = None,
) -> Run:
    """Simulate a control loop.

    Your own parts replace the parts of the scenario. All other properties, such as set point, noise and sample time, come from the
    scenario. Your parts are stepped in the order and with the arithmetic of library parts. A copy of a library part gives equal
    numbers, only more slowly.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        The scenario, see `stiction.scenario`.
    controller : OwnController, optional
        A controller that replaces the controller of the scenario.
    valve : OwnValve, Valve or Stem, optional
        A valve that replaces the valve of the scenario. The valve begins at rest at the operating point.
    process : OwnProcess, optional
        A process that replaces process and dead time of the scenario.

    Returns
    -------
    Run
        Signals of an unstable loop may end with infinite values or NaN.

    Raises
    ------
    ValueError
        If the scenario is not well formed or has a different kind, or the solver of a stem cannot continue.
    TypeError
        If one of your own parts has the wrong type or returns no number. Other exceptions of a part also end the simulation.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("paper/closed-loop", {"valve.S": 5})
    >>> run.half_pp_vp > 1
    True

    A physical valve in a loop:

    >>> halfway = {"operating_point.op": 50, "operating_point.pv": 50, "set_point.value": 55, "duration": 60}
    >>> run = stiction.simulate("paper/closed-loop", halfway, valve=stiction.Stem("cts"))
    >>> run.half_pp_vp > 1
    True
    """
    own = (
        instance("controller", controller, OwnController),
        instance("valve", valve, OwnValve, Valve, Stem),
        instance("process", process, OwnProcess),
    )
    if own == (None, None, None):
        return Run(**_simulated(scenario, settings, "closed loop"))
    return Run(**_core.simulate_own(_scenario(scenario, settings), *own))


@documented
def simulate_cascade(scenario: ScenarioLike, settings: Mapping[str, Any] | None = None) -> CascadeRun:
    """Simulate a slave loop under a master.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        The scenario, see `stiction.scenario`.

    Returns
    -------
    CascadeRun
        The signals of the master, and the run of the slave.

    Raises
    ------
    ValueError
        If the scenario is not well formed, or has a different kind.

    Examples
    --------
    >>> import stiction
    >>> cascade = stiction.closed_loop.simulate_cascade("paper/flow-cascade")
    >>> len(cascade.pv) == len(cascade.slave.vp)
    True
    """
    return result_of(CascadeRun, _simulated(scenario, settings, "cascade"))


@documented
def simulate_open_loop(scenario: ScenarioLike, settings: Mapping[str, Any] | None = None) -> OpenLoopRun:
    """Simulate a valve on a test signal.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        The scenario, see `stiction.scenario`.

    Returns
    -------
    OpenLoopRun
        OP and VP over time.

    Raises
    ------
    ValueError
        If the scenario is not well formed, or has a different kind.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.closed_loop.simulate_open_loop("paper/open-loop-high")
    >>> len(run.op) == len(run.vp)
    True
    """
    return OpenLoopRun(**_simulated(scenario, settings, "open loop"))


@result
class Sweep(Result):
    """Statistics of many loops over the last half of their samples, one entry per loop, in order."""

    S: Array
    J: Array = about("S and J of the valves, percent of span.")
    period_s: Array = about(
        "Mean time between upward crossings of the set point by the PV, s; NaN for fewer than three crossings."
    )
    half_pp_op: Array
    half_pp_vp: Array = about("Half of the peak-to-peak range of OP and VP, percent of span.")
    half_pp_pv: Array = about("Half of the peak-to-peak range of the PV, in PV units.")
    error_mean: Array
    error_rms: Array
    error_abs: Array = about("Mean, root mean square and mean absolute control error SP - PV, in PV units.")
    travel_per_s: Array = about("Valve travel, percent of span per second.")

    def to_table(self) -> Table:
        """Return the statistics as an Arrow table.

        Returns
        -------
        Table
            One row per loop, with the attributes as columns.
        """
        return _core.table_of(list(self.to_dict().items()))


@documented
def sweep(
    scenarios: Iterable[ScenarioLike], *, progress: Callable[[int], object] | None = None
) -> Sweep:
    """Simulate many control loops in parallel on all cores, and keep statistics of the loops.

    The result does not depend on the number of cores. The sweep is fastest if successive loops have equal duration and sample
    time.

    Parameters
    ----------
    scenarios : iterable of Scenario, str, path or mapping
        Closed loops, see `stiction.scenario`.

    Raises
    ------
    ValueError
        If a scenario is not well formed, or not a closed loop.

    Examples
    --------
    >>> import stiction
    >>> loops = [stiction.scenario("paper/closed-loop", {"valve.J": J}) for J in (1, 2, 4)]
    >>> done = stiction.sweep(loops)
    >>> done.period_s.round(2)
    array([32.62, 22.52, 15.3 ])
    """
    if isinstance(scenarios, (str, Mapping)) or not isinstance(scenarios, Iterable):
        kind = type(scenarios).__name__
        raise TypeError(f"scenarios must be a sequence of scenarios, but its type is {kind}")
    parsed = [each if isinstance(each, Scenario) else scenario(each) for each in scenarios]
    return Sweep(**_core.sweep(parsed, callback("progress", progress)))


@documented
def signal(table: Mapping[str, Any], *, sample_time: float, duration: float) -> Array:
    """Return the samples of a test signal.

    Parameters
    ----------
    table : mapping
        The signal in the notation of scenarios, such as ``{"signal": "ramp", "mean": 50, "amplitude": 15, "period": 60}``.
        Signals are constant, sine, ramp, square, steps, line, staircase, noise and random-walk. ``docs/scenarios.md`` of the
        project lists the keys of each signal.
    duration : float
        Duration, s.

    Returns
    -------
    ndarray
        The samples, from time 0 on.

    Raises
    ------
    ValueError
        If there is no such signal, or a value is out of its range.

    Examples
    --------
    >>> import stiction
    >>> stiction.signal({"signal": "ramp", "amplitude": 2, "period": 8}, sample_time=1, duration=8)
    array([ 0.,  1.,  2.,  1.,  0., -1., -2., -1.])
    """
    if not isinstance(table, Mapping):
        raise TypeError(f"table must be a mapping, but its type is {type(table).__name__}")
    return _core.signal(table, number("sample_time", sample_time), number("duration", duration))


def scenarios() -> dict[str, str]:
    """List the built-in scenarios.

    Returns
    -------
    dict
        Titles by name.
    """
    return dict(_core.scenario_names())


# Imported under another name, because a parameter is called `scenario`.
_scenario = scenario
