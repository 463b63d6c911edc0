"""The physical valve, a mass on a spring that air pressure moves against friction."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from stiction import _core
from stiction._arguments import number, optional
from stiction._arrays import Array, Samples, samples
from stiction._core import Bands, Table
from stiction._document import FrictionLaw
from stiction._plots import axes, legend, valve_over_time
from stiction._result import Result, about, result, result_of
from stiction._words import drawn

__all__ = [
    "FrictionLaw",
    "Stem",
    "StemEquivalent",
    "StemEvent",
    "StemResponse",
    "StemSet",
    "StemValve",
    "friction_laws",
    "stem_sets",
]


@result
class StemEvent(Result):
    """An event of a stem."""

    time_s: float = about("Time, s, located exactly and not rounded to a sample.")
    kind: Literal['slip', 'stop', 'reversal', 'end stop'] = about(
        "The event: the stem broke away, stopped, reversed without stopping, or met an end stop."
    )
    direction: Literal[1, -1] = about("Direction of the motion that begins (slip, reversal) or ends (stop, end stop).")
    vp: float = about("Position, percent of stroke.")
    position_m: float = about("Position, m.")


@result
class StemResponse(Result):
    """The motion of a stem."""

    time_s: Array = about("Times of the samples, s.")
    op: Array | None = about("Controller output at the samples, percent; None if a pressure was given.")
    pressure_pa: Array = about("Acting air pressure, Pa.")
    vp: Array = about("Position, percent of stroke.")
    position_m: Array = about("Position, m.")
    velocity_m_per_s: Array = about("Velocity, m/s.")
    friction_n: Array = about("Friction force, N; positive against upward motion.")
    slips: int
    stops: int = about("Number of slips, and of stops.")
    events: list[StemEvent] = about("All events, in order of time.")

    def to_table(self) -> Table:
        """Return the samples as an Arrow table.

        Returns
        -------
        Table
            Columns ``time_s``, ``op`` if given, ``pressure_pa``, ``vp``, ``position_m``, ``velocity_m_per_s`` and
            ``friction_n``.
        """
        columns = {name: value for name, value in self.to_dict().items() if isinstance(value, np.ndarray)}
        return _core.table_of(list(columns.items()))

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Plot OP and VP, and the friction force, over time; slips are marked."""
        above, below = axes(ax, 2)
        valve_over_time(above, self.time_s, self.op, self.vp, "OP (%), VP (% of stroke)")
        above.set_xlabel("")
        slips = [event for event in self.events if event.kind == "slip"]
        if slips:
            times, places = [event.time_s for event in slips], [event.vp for event in slips]
            above.plot(times, places, "k.", markersize=5, label="slip")
            legend(above)
        below.plot(self.time_s, self.friction_n, color="C1", label="friction")
        below.set_ylabel("friction force (N)")
        below.set_xlabel("time (s)")
        legend(below)
        return [above, below]


@result
class StemEquivalent(Result):
    """A stem in terms of the data-driven models: ``S = (Fs + Fc) / k``, ``J = (Fs - Fc) / k``.

    The equivalence holds for motion so slow that inertia and viscous friction are negligible.
    """

    bands: Bands = about("S and J in percent of stroke.")
    signal_bands: Bands = about("S and J in percent of the pressure signal.")
    fs_m: float
    fd_m: float = about("Static and dynamic friction band ``Fs / k`` and ``Fc / k``, m.")
    S_m: float
    J_m: float = about("Stick band plus dead band, and slip jump, m.")
    damping_ratio: float = about("Damping ratio ``Fv / (2 sqrt(k M))``.")
    overshoot: float = about("Length of the first slip relative to J; 1 without overshoot.")
    viscous_lag_s: float = about("``Fv / k``, s.")
    sliding: Literal['smooth', 'rippling', 'staircase'] = about(
        'Motion under a slow ramp: ``"smooth"``, ``"rippling"`` (the velocity oscillates) or ``"staircase"`` (the stem stops '
        'again and again).'
    )


class Stem(_core.Stem):
    __doc__ = _core.Stem.__doc__

    def equivalent(self) -> StemEquivalent:
        """Return the stem in terms of the data-driven models.

        Examples
        --------
        >>> import stiction
        >>> round(stiction.Stem("cts").equivalent().bands.J, 3)
        5.343
        """
        return StemEquivalent(**self._equivalent())

    def follow(
        self,
        op: Samples,
        *,
        sample_time: float | None = None,
        time_s: Samples | None = None,
        held: bool = False,
        position: float | None = None,
        acting_pa: float | None = None,
        relaxed: bool = False,
    ) -> StemResponse:
        """Follow a controller output from rest.

        Parameters
        ----------
        op : array_like
            OP, percent, finite, interpolated linearly between samples.
        sample_time : float, optional
            Time between samples, s.
        time_s : array_like, optional
            Times of the samples, s, ascending, instead of `sample_time`. Two samples at the same time make a jump.
        held : bool, default False
            Whether each sample is held for the sample time instead of interpolated.
        position : float, optional
            Initial position, percent of stroke; by default the balance of spring and pressure.
        acting_pa : float, optional
            Initial air pressure, Pa, if the stem has an air lag; by default the first demanded pressure.
        relaxed : bool, default False
            Whether the bristles of Dahl, LuGre and GMS friction are initially relaxed, or carry the net force.

        Raises
        ------
        ValueError
            If a value is out of its range, or the solver cannot continue.

        Examples
        --------
        >>> import stiction
        >>> response = stiction.Stem("cts").follow([0, 100, 0], sample_time=100)
        >>> response.slips, round(response.events[0].time_s, 3)
        (2, 38.407)
        """
        signal = samples("op", op)
        if (sample_time is None) == (time_s is None):
            raise ValueError("give either sample_time or time_s")
        if sample_time is None:
            if held:
                raise ValueError("held needs sample_time, the time for which each sample is held")
            times = _times(time_s, signal, "op")
        else:
            sample_time = number("sample_time", sample_time)
            if not sample_time > 0:
                raise ValueError(f"sample_time is {sample_time} s, but must be above 0")
            times = np.arange(len(signal), dtype=np.float64) * np.float64(sample_time)
        found = self._follow(
            signal,
            times,
            False,
            sample_time if held else None,
            times,
            optional("position", position),
            optional("acting_pa", acting_pa),
            bool(relaxed),
        )
        return result_of(StemResponse, {"op": signal, **found})

    def follow_pressure(
        self,
        pressure_pa: Samples,
        time_s: Samples,
        *,
        at_s: Samples | None = None,
        position: float | None = None,
        acting_pa: float | None = None,
        relaxed: bool = False,
    ) -> StemResponse:
        """Follow an air pressure from rest.

        Parameters
        ----------
        pressure_pa : array_like
            Demanded pressure, Pa, finite, interpolated linearly between samples.
        time_s : array_like
            Times of the samples, s, ascending. Two samples at the same time make a jump.
        at_s : array_like, optional
            Times of the response samples, s, ascending and within `time_s`; by default `time_s`.
        position, acting_pa, relaxed
            As for `follow`.

        Raises
        ------
        ValueError
            If a value is out of its range, or the solver cannot continue.

        Examples
        --------
        >>> import stiction
        >>> response = stiction.Stem("cts").follow_pressure([0, 68_948], [0, 100], at_s=[50, 100])
        >>> response.vp.round(2)
        array([15.  , 56.69])
        """
        signal = samples("pressure_pa", pressure_pa)
        times = _times(time_s, signal, "pressure_pa")
        found = self._follow(
            signal,
            times,
            True,
            None,
            times if at_s is None else samples("at_s", at_s),
            optional("position", position),
            optional("acting_pa", acting_pa),
            bool(relaxed),
        )
        return result_of(StemResponse, {"op": None, **found})


class StemValve(_core.StemValve):
    __doc__ = _core.StemValve.__doc__

    def follow(self, op: Samples) -> Array:
        """Follow a series of OP values, from the present state on.

        Parameters
        ----------
        op : array_like
            OP, percent.

        Returns
        -------
        ndarray
            The position at the end of each sample, percent of stroke.

        Raises
        ------
        ValueError
            If a sample is not finite, or the solver cannot continue.

        Examples
        --------
        >>> import stiction
        >>> valve = stiction.stem.StemValve(stiction.Stem("usp"), sample_time=0.1, position=50)
        >>> len(valve.follow([50, 60, 70]))
        3
        """
        return np.array([self.step(each) for each in samples("op", op)], dtype=np.float64)


@result
class StemSet(Result):
    """A named parameter set of a valve."""

    name: str = about("Its name.")
    summary: str = about("A short description.")
    source: str = about("Source of the numbers, and whether the numbers were verified.")
    friction: str = about("Friction law.")
    parameters: dict[str, float | bool] = about("Parameters of stem and friction by name, units in the names.")


def stem_sets() -> list[StemSet]:
    """List the sets of parameters.

    Examples
    --------
    >>> import stiction
    >>> [each.name for each in stiction.stem.stem_sets()][:3]
    ['cts', 'cts-stribeck', 'usp']
    """
    return [StemSet(**each) for each in _core.stem_sets()]


def friction_laws() -> list[FrictionLaw]:
    """List the friction laws.

    Examples
    --------
    >>> import stiction
    >>> [law.name for law in stiction.stem.friction_laws()]
    ['classical', 'karnopp', 'dahl', 'lugre', 'gms', 'armstrong']
    """
    return [result_of(FrictionLaw, each) for each in _core.friction_laws()]


def _times(time_s: Samples, signal: Array, name: str) -> Array:
    times = samples("time_s", time_s)
    if len(times) != len(signal):
        raise ValueError(f"time_s has {len(times)} samples, but {name} has {len(signal)}")
    return times
