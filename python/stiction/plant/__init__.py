"""Plants of many loops, judged day by day, from folders with a ``plant.toml`` or from tables of other engines.

`stiction.plant.spark` judges plants on Apache Spark. Import that module by name.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from stiction import _core
from stiction._arguments import callback, integer, optional, text
from stiction._core import Table
from stiction._document import Changes, Checked, Graded, Group, LoopThere, Member, Problem, Scanned, Status, Unknown
from stiction._result import result_of
from stiction._words import documented

__all__ = [
    "Changes",
    "Checked",
    "Graded",
    "Group",
    "LoopThere",
    "Member",
    "Problem",
    "Scanned",
    "Status",
    "Unknown",
    "check",
    "ddl",
    "demo",
    "diagnose_table",
    "diagnose_window",
    "groups",
    "model_version",
    "propose",
    "ranking",
    "scan",
    "schema",
    "status",
    "take",
    "windows",
]

Folder: TypeAlias = "str | os.PathLike[str]"
Settings: TypeAlias = "str | os.PathLike[str] | None"
"""The text of a ``plant.toml``, or the path of the folder with that file."""


@documented
def scan(
    folder: Folder,
    *,
    since: str | None = None,
    loops: str | None = None,
    threads: int | None = None,
    memory: float | None = None,
    again: bool = False,
    time_limit_s: int | None = None,
    progress: Callable[[int], object] | None = None,
) -> Scanned:
    """Judge the new data of a plant, and keep the results in the plant's store.

    Parameters
    ----------
    threads : int, optional
        Number of threads; by default as many as the machine has. The number does not affect the rows.
    memory : float, optional
        Memory to use, bytes; by default 500 MB.
    again : bool, default False
        Whether windows with results are judged again.
    time_limit_s : int, optional
        Longest time for a window of a loop, s. If a window takes longer, the row of the window has an error. By default
        `time_limit_s` in ``plant.toml``, or 300.
    progress : callable, optional
        Called with the number of finished days, summed over the loops.

    Returns
    -------
    Scanned
        The result of the scan; `windows` returns the rows.

    Raises
    ------
    ValueError
        If ``plant.toml`` or an argument is invalid.
    OSError
        If the store cannot be written, or another scan is running.

    Examples
    --------
    >>> import stiction.plant
    >>> stiction.plant.demo("north", loops=2, days=1)
    >>> done = stiction.plant.scan("north")
    >>> done.windows, done.errors
    (2, 0)
    >>> stiction.plant.scan("north").windows
    0
    """
    document = _core.plant_scan(
        os.fspath(folder),
        None if since is None else text("since", since),
        None if loops is None else text("loops", loops),
        None if threads is None else integer("threads", threads, least=1),
        None if memory is None else int(optional("memory", memory) or 0),
        bool(again),
        None if time_limit_s is None else integer("time_limit_s", time_limit_s, least=1),
        callback("progress", progress),
    )
    return result_of(Scanned, document)


@documented
def check(folder: Folder) -> Checked:
    """Read all data of a plant without judging the loops.

    Returns
    -------
    Checked
        The loops with their days, and the problems.
    """
    return result_of(Checked, _core.plant_check(os.fspath(folder)))


@documented
def status(folder: Folder) -> Status:
    """Return the results of a plant so far.

    Returns
    -------
    Status
        The numbers of loops, days and windows, and of windows by grade.
    """
    return result_of(Status, _core.plant_status(os.fspath(folder)))


@documented
def windows(folder: Folder, *, since: str | None = None, until: str | None = None) -> Table:
    """Return the valid rows of a plant's windows, by loop and time.

    Parameters
    ----------
    since, until : str, optional
        Return windows that begin on the day `since` or later, and before the day `until`.

    Returns
    -------
    Table
        One row per window, in the columns of `schema`, for any library with Arrow support.
    """
    return _core.plant_windows(os.fspath(folder), since, until)


@documented
def groups(folder: Folder, *, week: str | None = None) -> list[Group]:
    """Find loops that swing together in a week, as in the report of the week.

    Returns
    -------
    list of Group
        The groups, the largest group first.

    Raises
    ------
    ValueError
        If there are no results in or before the week.
    """
    found = _core.plant_groups(os.fspath(folder), None if week is None else text("week", week))
    return [result_of(Group, each) for each in found]


@documented
def ranking(folder: Folder, *, week: str | None = None) -> Table:
    """Return the ranking of a week, without groups of loops that swing together.

    Returns
    -------
    Table
        One row per loop, the most urgent first, in the columns of ``ranking.parquet``, for any library with Arrow support.

    Raises
    ------
    ValueError
        If there are no results in or before the week.
    """
    return _core.plant_ranking(os.fspath(folder), None if week is None else text("week", week))


def propose(folder: Folder, data: Sequence[str], *, name: str | None = None) -> tuple[str, list[str]]:
    """Propose a ``plant.toml`` for files or folders of data.

    Parameters
    ----------
    folder : path
        The folder of the plant.
    data : sequence of str
        Files, or folders of files, relative to the folder of the plant.
    name : str, optional
        Name of the plant; by default the name of the folder.

    Returns
    -------
    text : str
        The text of ``plant.toml``, with doubts as comments.
    doubts : list of str
        The doubts.

    Raises
    ------
    ValueError
        If no file has a loop.
    """
    path = Path(folder)
    chosen = path.resolve().name if name is None else text("name", name)
    proposal, _, doubts = _core.plant_propose(os.fspath(folder), chosen or "plant", list(data))
    return proposal, doubts


@documented
def take(folder: Folder, table: Any, traces: Any = None) -> Scanned:
    """Write rows that were judged elsewhere to the store of a plant, as a run.

    Parameters
    ----------
    table : table
        Rows in the columns of `schema`, in any object with the Arrow capsule interface. Other columns are ignored.
    traces : table, optional
        Traces of the windows from `diagnose_window`, with which a report finds loops that swing together.

    Returns
    -------
    Scanned
        The run.

    Raises
    ------
    ValueError
        If a column is missing or has a different type.
    """
    return result_of(Scanned, _core.plant_take(os.fspath(folder), table, traces))


def demo(folder: Folder, *, loops: int = 20, days: int = 7, seed: int = 1) -> None:
    """Write a simulated plant with known truth: ``plant.toml``, ``data`` and ``truth.csv``.

    Parameters
    ----------
    folder : path
        Output folder. Existing files with equal names are overwritten.
    loops, days : int
        Number of loops and of days.
    seed : int, default 1
        Seed of the plant.
    """
    _core.plant_demo(
        os.fspath(folder), integer("loops", loops, least=1), integer("days", days, least=1), integer("seed", seed)
    )


def model_version() -> str:
    """Return the version of the verdict's training.

    Returns
    -------
    str
        The version, as in the rows of windows.
    """
    return _core.model_version()


def schema() -> Any:
    """Return the columns of rows of windows, as an Arrow schema.

    Returns
    -------
    pyarrow.Schema
        The metadata of each field has the unit and the meaning of the column.

    Raises
    ------
    ImportError
        If pyarrow is not installed.
    """
    import pyarrow

    return pyarrow.schema(_core.plant_schema())


def ddl() -> str:
    """Return the columns of rows of windows, as declared in Spark.

    Returns
    -------
    str
        Names and types, such as ```loop` STRING, `area` STRING``.
    """
    return _core.plant_ddl()


@functools.lru_cache(maxsize=4)
def _of_text(words: str, origin: str) -> _core.Plant:
    return _core.Plant(words, origin)


def _plant(settings: Settings) -> _core.Plant:
    """Return the content of ``plant.toml``, which is parsed once per process."""
    if settings is None:
        return _of_text('name = "table"', "settings")
    if isinstance(settings, str):
        return _of_text(settings, "settings")
    path = Path(settings) / "plant.toml"
    return _of_text(path.read_text(encoding="utf-8"), str(path))


def diagnose_table(table: Any, settings: Settings = None, *, threads: int | None = None) -> Table:
    """Judge all windows in a table of samples, for use by other engines.

    Parameters
    ----------
    table : table
        A long table (times, tags, values, and optionally qualities) or a wide table, of one or more loops, with the Arrow capsule
        interface. Times have a time type. Tags may be dictionary-encoded. Rows may have any order.
    settings : str or path, optional
        The text of a ``plant.toml``, or the path of the folder with that file. By default the zone is UTC, and loops and columns
        are recognised by name.
    threads : int, optional
        Number of threads; by default as many as the machine has. Use 1 if an engine gives each task one core.

    Returns
    -------
    Table
        One row per window, in the columns of `schema`. A window that cannot be judged has a row with ``error``. Unreadable data
        give a row without a window. ``input_fingerprint`` is empty, because only the caller knows the source.

    Raises
    ------
    TypeError, ValueError
        If `table` is not a table, a column holds neither numbers, text nor times, or the settings are invalid.

    Examples
    --------
    >>> import stiction.plant
    >>> import pyarrow.parquet
    >>> stiction.plant.demo("south", loops=1, days=2)
    >>> rows = stiction.plant.diagnose_table(pyarrow.parquet.read_table("south/data"), threads=1)
    >>> len(rows), rows["loop"], rows["error"]
    (2, ['FIC1001', 'FIC1001'], [None, None])
    """
    return _plant(settings).rows(table, None if threads is None else integer("threads", threads, least=1))


def diagnose_window(
    table: Any, settings: Settings, loop: str, day: int, days: int = 1
) -> tuple[Table, Table, int]:
    """Judge one window of one loop, for engines that distribute windows over machines. It uses one thread.

    Parameters
    ----------
    table : table
        The samples of the window, as for `diagnose_table`, with at least the last sample of each tag on the day before.
    settings : str or path or None
        As for `diagnose_table`.
    loop : str
        The loop.
    day : int
        The day on which the window begins, by the plant's clock, days since 1970-01-01.
    days : int, default 1
        Number of days.

    Returns
    -------
    table : Table
        The row of the window; none without a sample of the OP.
    trace : Table
        The trace of the window's signal, for comparison with other loops; none for a signal that does not move.
    days : int
        Number of days that a window from `day` on should have. If this number differs from the given number, judge the window again
        with this number.
    """
    return _plant(settings).window(
        table, text("loop", loop), integer("day", day, least=-100_000_000), integer("days", days, least=1)
    )
