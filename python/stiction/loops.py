"""Simulated loops, described by scenarios."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any, TypeAlias

import numpy as np

from stiction import _core
from stiction._arrays import Array
from stiction._core import Scenario
from stiction._result import Result, result

__all__ = ["Run", "Scenario", "scenario", "scenarios", "simulate"]

ScenarioLike: TypeAlias = Scenario | str | PathLike[str] | Mapping[str, Any]
"""A scenario, the name of a built-in one, the path of a TOML file, or its tables as a mapping."""


def scenario(source: ScenarioLike, settings: Mapping[str, Any] | None = None) -> Scenario:
    """Describe what to simulate.

    Parameters
    ----------
    source : str, path, mapping or Scenario
        The name of a built-in scenario (see `scenarios`), the path of a TOML file, or the tables of such a
        file as nested mappings. ``docs/scenarios.md`` of the project lists every key with its unit.
    settings : mapping, optional
        Changes to it by dotted key, such as ``{"valve.S": 4}``.

    Returns
    -------
    Scenario

    Raises
    ------
    ValueError
        If it is not well formed; the message names line and key.

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
    if isinstance(source, Scenario):
        return _core.scenario_parse(source.text, settings)
    if isinstance(source, Mapping):
        return _core.scenario_parse(source, settings)
    return _core.scenario_open(fspath(source), settings)


@result
class Run(Result):
    """What a simulated loop did.

    Attributes
    ----------
    sample_time : float
        Time between samples, s; sample ``k`` is at time ``k * sample_time``.
    sp, pv : ndarray
        Set point and measured process value, in PV units.
    op, vp : ndarray
        Controller output and valve position, percent of span.
    period_s : float or None
        Period of the limit cycle in the second half, s; None if there is none.
    half_pp_op, half_pp_vp, half_pp_pv : float
        Half of the peak-to-peak range in the second half: of OP and VP in percent of span, of the PV in its units.
    growth : float or None
        Amplitude of the last cycles over that of those before; None if it does not cycle.
    """

    sample_time: float
    sp: Array
    pv: Array
    op: Array
    vp: Array
    period_s: float | None
    half_pp_op: float
    half_pp_vp: float
    half_pp_pv: float
    growth: float | None

    @property
    def time_s(self) -> Array:
        """Times of the samples, s."""
        return np.arange(len(self.op), dtype=np.float64) * np.float64(self.sample_time)


def simulate(
    scenario: ScenarioLike, settings: Mapping[str, Any] | None = None
) -> Run:
    """Simulate a control loop.

    Parameters
    ----------
    scenario : Scenario, str, path or mapping
        What to simulate, see `stiction.scenario`.
    settings : mapping, optional
        Changes to it by dotted key.

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        If the scenario is not well formed, or no closed loop.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("paper/closed-loop", {"valve.S": 5})
    >>> run.half_pp_vp > 1
    True
    """
    return Run(**_core.simulate_loop(_scenario(scenario, settings)))


def scenarios() -> dict[str, str]:
    """List the built-in scenarios.

    Returns
    -------
    dict
        Titles by name.
    """
    return dict(_core.scenario_names())


# Under another name where a parameter is called `scenario`.
_scenario = scenario
