"""Sticking valves and loops for python-control, and linear systems of python-control as processes of scenarios.

This module needs the package ``control``: ``pip install stiction[control]``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stiction import _core
from stiction._arguments import at_least_zero, choice, number, text
from stiction._arrays import Array, unmasked
from stiction._words import documented
from stiction.cycles import describing_function as _describing_function
from stiction.valves import Valve, valve_models

try:
    import control
except ImportError:
    raise ImportError("stiction.control needs python-control: pip install stiction[control]") from None

__all__ = ["ValveDescribingFunction", "describing_function", "process_of", "valve_system"]


def process_of(system: Any, dead_time: float = 0.0) -> dict[str, Any]:
    """Return the table ``process`` of a scenario for a linear system.

    Parameters
    ----------
    system : control.TransferFunction or control.StateSpace
        A continuous-time system with one input (valve position, percent) and one output (PV, in PV units). The system has at most
        as many zeros as poles, and an order of at most 8.
    dead_time : float, default 0
        Dead time in series with the system, s.

    Returns
    -------
    dict
        ``type``, ``num``, ``den`` and ``delay``, for the key ``process`` of the mapping passed to `stiction.scenario`.

    Raises
    ------
    TypeError
        If `system` is neither a TransferFunction nor a StateSpace.
    ValueError
        If `system` has several inputs or outputs, is discrete in time or improper, or `dead_time` is negative.

    Examples
    --------
    >>> import control
    >>> from stiction.control import process_of
    >>> process_of(control.tf([1.5], [5.93, 1]), dead_time=1.07)
    {'type': 'transfer-function', 'num': [1.5], 'den': [5.93, 1.0], 'delay': 1.07}
    """
    if not isinstance(system, (control.TransferFunction, control.StateSpace)):
        raise TypeError(
            f"system must be a TransferFunction or a StateSpace, but its type is {type(system).__name__}"
        )
    if not system.issiso():
        raise ValueError(
            f"system has {system.ninputs} inputs and {system.noutputs} outputs, but must have one of each"
        )
    if system.isdtime(strict=True):
        raise ValueError(f"system is sampled every {system.dt} s, but must be continuous in time")
    delay = at_least_zero("dead_time", dead_time)
    transfer = control.tf(system)
    num, den = (np.trim_zeros(np.real(part[0][0]), "f") for part in (transfer.num, transfer.den))
    if isinstance(system, control.StateSpace):
        # A conversion leaves rounding errors instead of coefficients of 0.
        while len(num) > 1 and abs(num[0]) <= 1e-12 * abs(num).max():
            num = num[1:]
    if len(num) > len(den):
        raise ValueError("system is improper: it has more zeros than poles")
    return {"type": "transfer-function", "num": num.tolist(), "den": den.tolist(), "delay": delay}


# Models whose memory is a state from which a new valve can begin.
_MODELS = [m.name for m in valve_models() if _core.Valve(5.0, 2.0, model=m.name)._state() is not None]


@documented
def valve_system(
    S: float,
    J: float,
    *,
    model: str = "two-phase",
    dt: float | bool = True,
    name: str | None = None,
) -> Any:
    """Return a sticking valve as a discrete-time system.

    The response of this system to a series of OP values equals the response of `stiction.valve` to the last bit. The state is the
    position, the OP of the sample before, and the motion (1 upward, -1 downward, 0 stuck). The state ``[0, 0, 0]`` is a valve at
    rest at 0; pass ``[x, x, 0]`` as initial state of a valve at rest at x.

    Parameters
    ----------
    model : str, default "two-phase"
        Name of a valve model. Kano's and Choudhury's models are refused, because these models have more memory than this state. For J up
        to S, "two-phase" responds like the models of Kano and Choudhury.
    dt : float or True, default True
        Time between samples, s; True leaves the time unspecified.
    name : str, optional
        Name of the system.

    Returns
    -------
    control.NonlinearIOSystem
        The system, with the input ``op``, the output ``vp`` and the states ``position``, ``op_before`` and ``motion``.

    Raises
    ------
    TypeError
        If an argument is of the wrong type.
    ValueError
        If a value is out of its range, or `model` is not supported.

    Examples
    --------
    >>> import control, numpy
    >>> from stiction.control import valve_system
    >>> valve = valve_system(S=5, J=2, dt=1.0)
    >>> response = control.input_output_response(
    ...     valve, numpy.arange(5.0), [50, 52, 54, 55, 53], [50, 50, 0])
    >>> response.outputs.tolist()
    [50.0, 50.0, 52.5, 53.5, 53.5]
    """
    s, j, kind = number("S", S), number("J", J), choice("model", model, _MODELS)
    if dt is not True:
        dt = number("dt", dt)
        if not 0 < dt < float("inf"):
            raise ValueError(f"dt is {dt:g}, but must be a finite number above 0, or True")
    Valve(s, j, model=kind)

    def stepped(state: Array, op: Array) -> Valve:
        position, before, motion = state
        valve = Valve(
            s,
            j,
            model=kind,
            position=position,
            op=before,
            direction=-1 if motion < 0 else 1,
            moving=motion != 0,
        )
        valve.step(op[0])
        return valve

    def update(t: float, state: Array, op: Array, parameters: dict[str, Any]) -> Array:
        after = stepped(state, op)._state()
        assert after is not None
        position, _, direction, moving = after
        return np.array([position, op[0], direction if moving else 0.0])

    def output(t: float, state: Array, op: Array, parameters: dict[str, Any]) -> Array:
        return np.array([stepped(state, op).position])

    return control.NonlinearIOSystem(
        update,
        output,
        inputs=["op"],
        outputs=["vp"],
        states=["position", "op_before", "motion"],
        dt=dt,
        name=name,
    )


class ValveDescribingFunction(control.DescribingFunctionNonlinearity):  # type: ignore[misc, unused-ignore]
    """The describing function of a sticking valve, for ``control.describing_function_response``.

    Parameters
    ----------
    S : float
        Stick band plus dead band, percent of span.
    J : float
        Slip jump, percent of span.
    model : str, default "two-phase"
        Name of a valve model, see `stiction.valves.valve_models`.

    Raises
    ------
    ValueError
        If a value is out of its range, or there is no such model.
    """

    def __init__(self, S: float, J: float, model: str = "two-phase") -> None:
        super().__init__()
        self._valve = Valve(S, J, model=text("model", model))

    def __call__(self, op: Any) -> float:
        """Return the valve position (VP) for one new sample of the OP."""
        return self._valve.step(float(np.squeeze(op)))

    def describing_function(self, amplitude: npt.ArrayLike) -> Any:
        """Return N(X), see `stiction.cycles.describing_function`.

        Parameters
        ----------
        amplitude : array_like
            Amplitudes of the OP, percent of span.

        Returns
        -------
        complex or ndarray of complex
            N(X), in the shape of `amplitude`.
        """
        shape = np.shape(amplitude)
        bands = self._valve.bands
        sines = np.ravel(np.asarray(unmasked(amplitude), dtype=np.float64))
        gains = _describing_function(sines, bands.S, bands.J, model=self._valve.model)
        return gains.reshape(shape) if shape else complex(gains[0])

    def _isstatic(self) -> bool:
        return False


@documented
def describing_function(S: float, J: float, model: str = "two-phase") -> ValveDescribingFunction:
    """Return the describing function of a sticking valve for python-control.

    Pass the result to ``control.describing_function_response`` with the product of controller and process, and with amplitudes
    above `stiction.cycles.least_amplitude`. Below that amplitude, the valve stays stuck and ``-1/N`` is infinite.

    Parameters
    ----------
    model : str, default "two-phase"
        Name of a valve model, see `stiction.valves.valve_models`.

    Raises
    ------
    ValueError
        If a value is out of its range, or there is no such model.

    Examples
    --------
    >>> from stiction.control import describing_function
    >>> round(abs(describing_function(S=5, J=2).describing_function(10)), 4)
    0.9314
    """
    return ValveDescribingFunction(S, J, model)
