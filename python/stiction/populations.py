"""Simulated loops with known truth, for training and measuring methods."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, overload

from stiction import _core
from stiction._arguments import callback, integer, text
from stiction._arrays import Array
from stiction._core import POPULATION_VERSION, Table
from stiction._plots import axes, pv_over_time, valve_over_time
from stiction._result import Result, about, result, result_of
from stiction._words import documented, drawn
from stiction.closed_loop import Signals

__all__ = ["POPULATION_VERSION", "Member", "Population", "Truth", "population", "population_kinds"]

MOST_LOOPS = 1_000_000  # Already some tens of GB.


@result
class Truth(Result):
    """The truth about a simulated loop."""

    kind: str = about("Distinguishing property, one of `population_kinds`.")
    sticks: bool = about("Whether the valve is at fault: sticking or stuck.")
    visible: bool = about("Whether the record can show the fault; False for healthy valves.")
    model: str | None = about("Model of a sticking or stuck valve; None for a healthy valve.")
    S: float = about(
        "Stick band plus dead band, percent of span; for a healthy valve the harmless dead band, for a stuck valve 200."
    )
    J: float = about("Slip jump, percent of span.")
    slips: int = about("Number of slips of a sticking valve within the record.")
    evidence_nats: float = about(
        "Information gain on the recorded PV from knowing the stem position besides the OP, nats; 0 unless the loop's own valve "
        "sticks."
    )
    swing: float = about("OP range, divided by the S that the valve has, or would have if the valve stuck.")
    op_noise: float = about("Standard deviation of the OP noise, divided by the S in `swing`.")
    facts: dict[str, float | int | bool | str] = about(
        "Other drawn and derived properties, by name; ``docs/population.md`` of the project explains them. Times are in seconds, "
        "and PVs are in percent of the transmitter's span."
    )


@result
class Member(Signals):
    """A simulated loop, recorded as in a plant, with the truth about the loop."""

    name: str = about("Its name.")
    loop_type: str = about("Type of the loop.")
    sample_time: float = about("Time between samples, s.")
    op: Array = about("Recorded controller output, percent.")
    pv: Array | None = about("Recorded process value.")
    sp: Array | None = about("Recorded set point, in PV units; None if not recorded.")
    vp: Array = about("True valve position, percent; not part of the recorded signals.")
    truth: Truth = about("The truth about it.")

    @drawn(2)
    def plot(self, ax: Any = None) -> Any:
        """Plot SP and PV, and OP and true VP, over time."""
        above, below = axes(ax, 2)
        pv_over_time(above, self.time_s, self.sp, self.pv)
        valve_over_time(below, self.time_s, self.op, self.vp)
        above.set_title(f"{self.name}: {self.truth.kind}", loc="left")
        return [above, below]


class Population(Sequence[Member]):
    """Simulated loops from `population`, as a sequence of `Member`.

    Parameters
    ----------
    loops : object
        The loops, made by `population`.
    """

    __slots__ = ("_loops",)

    def __init__(self, loops: _core.Loops) -> None:
        self._loops = loops

    def __len__(self) -> int:
        return len(self._loops)

    @overload
    def __getitem__(self, index: int) -> Member: ...
    @overload
    def __getitem__(self, index: slice) -> list[Member]: ...
    def __getitem__(self, index: int | slice) -> Member | list[Member]:
        # A range implements the meaning of indices and slices.
        where = range(len(self))[index]
        return self._member(where) if isinstance(where, int) else [self._member(k) for k in where]

    def _member(self, index: int) -> Member:
        return result_of(Member, self._loops.member(index))

    def truth(self) -> Table:
        """Return the truth about the loops as an Arrow table.

        Returns
        -------
        Table
            One row per loop: ``name``, the attributes of `Truth`, and the facts.
        """
        return self._loops.truth()

    def __repr__(self) -> str:
        return f"<Population of {len(self)} loops>"


@documented
def population(
    n: int,
    seed: int = 1,
    *,
    kind: str | None = None,
    first: int = 0,
    progress: Callable[[int], object] | None = None,
) -> Population:
    """Simulate loops with known truth, on all cores.

    A loop depends only on the seed and the number of the loop, so that a large population can be made in parts.
    ``docs/population.md`` of the project describes the drawn properties, and `POPULATION_VERSION` is the version of the
    population.

    Parameters
    ----------
    n : int
        Number of loops, 1 to 1,000,000. Make larger populations in parts, with `first`.
    seed : int, default 1
        Seed of the population.
    kind : str, optional
        Simulate only loops of this kind, see `population_kinds`. The loops have consecutive seeds, from `seed` + `first`
        on.
    first : int, default 0
        Number of the first loop.

    Raises
    ------
    ValueError
        If there is no such kind, or a number is out of its range.

    Examples
    --------
    >>> import stiction
    >>> loops = stiction.population(3, seed=7)
    >>> [loop.truth.sticks for loop in loops] == loops.truth()["sticks"]
    True
    >>> stiction.population(1, seed=7, first=2)[0].op.tolist() == loops[2].op.tolist()
    True
    """
    return Population(
        _core.population_loops(
            _count(n),
            _large("seed", seed),
            None if kind is None else text("kind", kind),
            _large("first", first),
            callback("progress", progress),
        )
    )


def population_kinds() -> dict[str, float]:
    """List the kinds of simulated loops.

    Returns
    -------
    dict
        Shares of the population by name. The shares add up to 1.

    Examples
    --------
    >>> import stiction
    >>> stiction.populations.population_kinds()["sticky valve"]
    0.47
    """
    return dict(_core.population_kinds())


def _count(n: Any) -> int:
    """Return a number of loops that fits in memory."""
    count = integer("n", n, 1)
    if count > MOST_LOOPS:
        raise ValueError(f"n is {count}, but must be at most {MOST_LOOPS}; make more in parts, with first")
    return count


def _large(name: str, value: Any, least: int = 0) -> int:
    """Return a whole number of 64 bits."""
    whole = integer(name, value, least)
    if whole >= 1 << 64:
        raise ValueError(f"{name} is {whole}, but must be below 2**64")
    return whole
