"""Valve models, from controller output (OP) to valve position (VP), both in percent of span."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from stiction import _core
from stiction._arrays import Array, Samples, samples
from stiction._core import Bands, Table
from stiction._document import ValveModel
from stiction._result import result_of
from stiction._words import documented

__all__ = ["Bands", "Table", "Valve", "ValveModel", "valve", "valve_models", "valve_table"]


class Valve(_core.Valve):
    __doc__ = _core.Valve.__doc__

    def __getstate__(self) -> tuple[dict[str, Any], list[float]]:
        return self.__dict__, self._memory()

    def __setstate__(self, state: tuple[dict[str, Any], list[float]]) -> None:
        attributes, memory = state
        self.__dict__.update(attributes)
        self._recall(memory)

    def follow(self, op: Samples) -> Array:
        """Follow a series of OP values, from the present state on.

        Parameters
        ----------
        op : array_like
            OP, percent of span, one-dimensional and finite.

        Returns
        -------
        ndarray
            The valve position after each sample, percent of span.

        Raises
        ------
        TypeError
            If `op` holds no real numbers.
        ValueError
            If a sample is not finite. In this case the valve has not moved.

        Examples
        --------
        >>> import stiction
        >>> stiction.valves.Valve(S=5, J=2, position=50).follow([52, 54, 55])
        array([50. , 52.5, 53.5])
        """
        signal = samples("op", op)
        vp = np.empty(len(signal))
        self._follow(signal, vp)
        return vp


@documented
def valve(
    op: Samples,
    S: float,
    J: float,
    *,
    model: str = "two-phase",
    position: float | None = None,
    direction: Literal[1, -1] = 1,
    moving: bool = False,
    K: float | None = None,
    rest_tolerance: float | None = None,
    limits: tuple[float, float] | None = None,
    lag_s: float = 0.0,
    sample_time: float | None = None,
) -> Array:
    """Return the valve position for a series of OP values.

    Parameters
    ----------
    op : array_like
        OP, percent of span, one-dimensional and finite.
    position : float, optional
        Initial valve position, percent of span; by default the first OP.
    direction : {1, -1}, default 1
        Direction of the last motion before the first sample.
    moving : bool, default False
        Whether the stem initially moves in that direction.
    K : float, optional
        Overshoot of a slip, 1 (none) to 2 (no damping), for models with overshoot; by default 1.99.
    rest_tolerance : float, optional
        Speed of the OP that counts as a pause, percent of span per second, for models with such a speed; by default 0.
    limits : tuple of float, optional
        Lowest and highest OP and VP, percent of span; by default none.
    lag_s : float, default 0
        Time constant of a first-order lag of the stem, s.
    sample_time : float, optional
        Time between samples, s; needed only with `lag_s` or `rest_tolerance`.

    Returns
    -------
    ndarray
        The valve position, percent of span, one for each sample of `op`.

    Raises
    ------
    TypeError
        If `op` holds no real numbers.
    ValueError
        If a value is out of its range, there is no such model, or the model does not use a given parameter.

    Examples
    --------
    >>> import stiction
    >>> stiction.valve([50, 52, 54, 55, 53], S=5, J=2)
    array([50. , 50. , 52.5, 53.5, 53.5])
    """
    signal = samples("op", op)
    if position is None:
        # A value that is not finite is refused when all samples are checked.
        position = float(signal[0]) if len(signal) and np.isfinite(signal[0]) else 0.0
    follower = Valve(
        S,
        J,
        model=model,
        position=position,
        direction=direction,
        moving=moving,
        K=K,
        rest_tolerance=rest_tolerance,
        limits=limits,
        lag_s=lag_s,
        sample_time=sample_time,
    )
    return follower.follow(signal)


def valve_models() -> list[ValveModel]:
    """List the valve models.

    Examples
    --------
    >>> import stiction
    >>> [model.name for model in stiction.valves.valve_models()][:3]
    ['two-phase', 'choudhury', 'kano']
    """
    return [result_of(ValveModel, model) for model in _core.valve_models()]


def valve_table() -> Table:
    """Return the valve models as an Arrow table.

    Examples
    --------
    >>> import stiction
    >>> stiction.valves.valve_table()["name"][:3]
    ['two-phase', 'choudhury', 'kano']
    """
    return _core.valve_table()
