"""The sample recordings of the package: simulated loops with known truth, in the form of a historian's export.

The recordings are under the licence of the package.
"""

from __future__ import annotations

import csv
from pathlib import Path

from stiction._arguments import choice
from stiction._core import Recording
from stiction._result import Result, about, result
from stiction._words import documented
from stiction.recordings import read

__all__ = ["SampleTruth", "load", "names", "path", "truth"]


@result
class SampleTruth(Result):
    """The truth about a sample recording."""

    name: str = about("Its name.")
    sticks: bool = about("Whether its valve sticks.")
    model: str = about("Valve model, see `stiction.valves.valve_models`.")
    S: float = about("Stick band plus dead band, percent of span.")
    J: float = about("Slip jump, percent of span.")
    cause: str = about("The cause of the swing.")
    scenario: str = about("Built-in scenario, see `stiction.closed_loop.scenarios`.")


def names() -> list[str]:
    """List the sample recordings.

    Examples
    --------
    >>> import stiction
    >>> stiction.datasets.names()[0]
    'FIC101-sticky'
    """
    return list(_truths())


@documented
def path(name: str) -> Path:
    """Return the path of a sample recording.

    Returns
    -------
    Path
        A CSV file with the columns t, sp, pv and op.

    Raises
    ------
    ValueError
        If there is no such sample.

    Examples
    --------
    >>> import stiction
    >>> stiction.datasets.path("FIC101-sticky").name
    'FIC101-sticky.csv'
    """
    return _folder() / f"{choice('name', name, names())}.csv"


@documented
def load(name: str) -> Recording:
    """Read a sample recording.

    Raises
    ------
    ValueError
        If there is no such sample.

    Examples
    --------
    >>> import stiction
    >>> stiction.datasets.load("FIC101-sticky")
    <Recording "FIC101-sticky" (flow) of 2400 samples: OP, PV, SP>
    """
    [recording] = read(path(name))
    return recording


@documented
def truth(name: str) -> SampleTruth:
    """Return the truth about a sample recording.

    Raises
    ------
    ValueError
        If there is no such sample.

    Examples
    --------
    >>> import stiction
    >>> stiction.datasets.truth("FIC101-sticky").S
    4.0
    """
    known = _truths()
    return known[choice("name", name, known)]


def _folder() -> Path:
    """Return the folder of the samples, in the wheel or in the clone from which the package is imported."""
    here = Path(__file__).parent
    packaged = here / "samples"
    return packaged if packaged.is_dir() else here.parents[1] / "samples"


def _truths() -> dict[str, SampleTruth]:
    with (_folder() / "truth.csv").open(encoding="utf-8", newline="") as file:
        known = [
            SampleTruth(
                name=row["file"].removesuffix(".csv"),
                sticks=row["label"] == "stiction",
                model=row["model"],
                S=float(row["S"]),
                J=float(row["J"]),
                cause=row["cause"],
                scenario=row["scenario"],
            )
            for row in csv.DictReader(file)
        ]
    return {each.name: each for each in known}
