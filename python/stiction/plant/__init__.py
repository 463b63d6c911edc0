"""Plants of many loops, judged day by day: folders with a ``plant.toml``, and tables that other engines bring.

`stiction.plant.spark` does the same on Apache Spark; the package does not import it by itself.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

from stiction import _core
from stiction._arguments import callback, integer, optional, text
from stiction._core import Table
from stiction._result import Result, about, result, result_of
from stiction._words import documented

__all__ = [
    "Checked",
    "Graded",
    "Group",
    "LoopThere",
    "Member",
    "Problem",
    "Scanned",
    "Status",
    "check",
    "ddl",
    "demo",
    "diagnose_table",
    "diagnose_window",
    "groups",
    "model_version",
    "scan",
    "schema",
    "status",
    "take",
    "windows",
]

Folder: TypeAlias = "str | os.PathLike[str]"
Settings: TypeAlias = "str | os.PathLike[str] | None"
"""The text of a ``plant.toml``, or, as a path, the folder that holds one."""


@result
class Problem(Result):
    """Something that could not be read."""

    file: str | None = about("The file; None if it is about all of them.")
    loop: str | None = about("The loop; None if it is about the whole file.")
    message: str = about("What is wrong, and what would help.")


@result
class Scanned(Result):
    """What a scan did."""

    plant: str = about("Name of the plant.")
    run: str | None = about("Name of the run; None if nothing was new.")
    engine_version: str = about("Version of the program.")
    model_version: str = about("What the verdict was trained on.")
    files: int = about("Files that were looked at.")
    loops: int = about("Loops in them.")
    windows: int = about("Windows that were judged in this run.")
    errors: int = about("Of these, windows that could not be judged.")
    parts: int = about("Parts in which they are kept.")
    problems: list[Problem] = about("What could not be read.")
    no_recordings: list[str] = about("Files that are no recordings, as they have no OP, a sentence each.")
    damaged: list[str] = about("Files of earlier runs that were found damaged, a sentence each.")


@result
class LoopThere(Result):
    """A loop that the data of a plant hold."""

    loop: str = about("Its tag.")
    days: int = about("Days with samples.")
    first_day: str | None
    last_day: str | None = about("The first and the last of them.")
    in_plant_file: bool = about("Whether the plant's file knows it.")
    tags: list[str] = about(
        "What its last file says of it, or the beginning of that: the tags of its signals, such as ``op = "
        '"FIC101.OP"``.'
    )
    op_range: list[float] | None = about("The values of OP that are 0 % and 100 %.", kind="list of two floats or None")
    modes: list[str] = about("The modes it is in; none of a loop whose mode is not recorded.")
    notes: list[str] = about("What to confirm, and what was assumed.")


@result
class Checked(Result):
    """What the data of a plant hold."""

    plant: str = about("Name of the plant.")
    files: int = about("Files that the plant's file names.")
    loops: list[LoopThere] = about("Loops in them.")
    problems: list[Problem] = about("What is wrong.")
    no_recordings: list[str] = about("Files that are no recordings, as they have no OP, a sentence each.")


@result
class Graded(Result):
    """How many windows have a grade."""

    grade: str = about("The grade.")
    windows: int = about("Windows.")


@result
class Status(Result):
    """What was judged of a plant so far."""

    plant: str = about("Name of the plant.")
    loops: int = about("Loops with a window.")
    days: int = about("Days of the plant with a window.")
    first_day: str | None
    last_day: str | None = about("The first and the last of them.")
    windows: int = about("Windows that count.")
    errors: int = about("Of these, windows that could not be judged.")
    grades: list[Graded] = about("Windows by grade, the worst first.")
    runs: int = about("Runs.")
    cut_short: int = about("Runs that did not come to their end since the last scan of all loops and days that did.")
    damaged: list[str] = about("Files of what was judged that were found damaged, a sentence each.")


@result
class Member(Result):
    """A loop of a group."""

    loop: str = about("Its tag.")
    coherence: float = about(
        "How much of its swing at the period is that of the group: squared coherence with the common swing, 0 to 1."
    )
    candidate_rank: int | None = about(
        "Its place among the candidates for the source, from one; None if it is no candidate."
    )
    reasons: list[str] = about("What speaks for and against it as the source, sentences.")


@result
class Group(Result):
    """Loops that swing together, and who of them may be the source."""

    id: int = about("Its number, from one.")
    period_s: float = about("Period of the swing, s.")
    members: list[Member] = about("The loops: candidates for the source in their order, then the others by coherence.")
    source: str = about('Whether one of them may be the source: ``"candidates"`` or ``"not-recorded"``.')
    reasons: list[str] = about("What the group rests on, sentences.")


@documented
def scan(
    folder: Folder,
    *,
    since: str | None = None,
    loops: str | None = None,
    threads: int | None = None,
    memory: float | None = None,
    again: bool = False,
    progress: Callable[[int], object] | None = None,
) -> Scanned:
    """Judge what is new of a plant, and keep it in its store.

    Parameters
    ----------
    threads : int, optional
        Threads; as many as the machine has without it. The rows are the same for any number.
    memory : float, optional
        Memory to use, bytes; 500 MB without it.
    again : bool, default False
        Whether what is done is judged again.
    progress : callable, optional
        Called with the number of days of loops that are on the disk.

    Returns
    -------
    Scanned
        What was done; `windows` gives the rows.

    Raises
    ------
    ValueError
        If ``plant.toml`` says what cannot be, or an argument cannot.
    OSError
        If the store cannot be written, or somebody else is scanning.

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
        callback("progress", progress),
    )
    return result_of(Scanned, document)


@documented
def check(folder: Folder) -> Checked:
    """Read all data of a plant, and judge nothing.

    Returns
    -------
    Checked
        The loops, their days, and what is wrong.
    """
    return result_of(Checked, _core.plant_check(os.fspath(folder)))


@documented
def status(folder: Folder) -> Status:
    """Tell what was judged of a plant so far.

    Returns
    -------
    Status
        Loops, days, windows and their grades.
    """
    return result_of(Status, _core.plant_status(os.fspath(folder)))


@documented
def windows(folder: Folder, *, since: str | None = None, until: str | None = None) -> Table:
    """Give the rows that count of a plant's windows, by loop and time.

    Parameters
    ----------
    since, until : str, optional
        Windows that begin on this day or later, and before that day.

    Returns
    -------
    Table
        A row a window, in the columns of `schema`; for any library that speaks Arrow.
    """
    return _core.plant_windows(os.fspath(folder), since, until)


@documented
def groups(folder: Folder, *, week: str | None = None) -> list[Group]:
    """Find loops that swing together in a week, as its report does.

    Returns
    -------
    list of Group
        The largest first.

    Raises
    ------
    ValueError
        If nothing was judged in or before the week.
    """
    found = _core.plant_groups(os.fspath(folder), None if week is None else text("week", week))
    return [result_of(Group, each) for each in found]


@documented
def take(folder: Folder, table: Any, traces: Any = None) -> Scanned:
    """Put rows that were judged elsewhere into the store of a plant, as a run.

    Parameters
    ----------
    table : table
        Rows in the columns of `schema`, others are left alone; anything that speaks the Arrow capsule interface.
    traces : table, optional
        Traces of the windows, as `diagnose_window` gives them: by these a report finds loops that swing together.

    Returns
    -------
    Scanned
        The run.

    Raises
    ------
    ValueError
        If a column is not there, or is of another type.
    """
    return result_of(Scanned, _core.plant_take(os.fspath(folder), table, traces))


def demo(folder: Folder, *, loops: int = 20, days: int = 7, seed: int = 1) -> None:
    """Write a plant with known truth: ``plant.toml``, ``data``, ``truth.csv``.

    Parameters
    ----------
    folder : path
        Where to; files of these names are written over.
    loops, days : int
        How many.
    seed : int, default 1
        Seed of the plant.
    """
    _core.plant_demo(
        os.fspath(folder), integer("loops", loops, least=1), integer("days", days, least=1), integer("seed", seed)
    )


def model_version() -> str:
    """Tell what the verdict was trained on.

    Returns
    -------
    str
        As rows of windows name it.
    """
    return _core.model_version()


def schema() -> Any:
    """Give the columns of rows of windows, as Arrow declares them.

    Returns
    -------
    pyarrow.Schema
        Its fields tell unit and meaning in their metadata.

    Raises
    ------
    ImportError
        If pyarrow is not installed.
    """
    import pyarrow

    return pyarrow.schema(_core.plant_schema())


def ddl() -> str:
    """Give the columns of rows of windows, as Spark declares them.

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
    """Give what a plant's file says; it is parsed once in a process."""
    if settings is None:
        return _of_text('name = "table"', "settings")
    if isinstance(settings, str):
        return _of_text(settings, "settings")
    path = Path(settings) / "plant.toml"
    return _of_text(path.read_text(encoding="utf-8"), str(path))


def diagnose_table(table: Any, settings: Settings = None, *, threads: int | None = None) -> Table:
    """Judge all windows in a table of samples: what other engines call.

    Parameters
    ----------
    table : table
        Long (times, tags, values, and perhaps qualities) or wide, of one loop or of several; anything that speaks the
        Arrow capsule interface. Times are of a type of times. Tags may be a dictionary. Rows may come in any order.
    settings : str or path, optional
        The text of a ``plant.toml``, or as a path its folder; without it the zone is UTC and all is recognised.
    threads : int, optional
        Threads; as many as the machine has without it. 1 where an engine gives each task one core.

    Returns
    -------
    Table
        A row a window, in the columns of `schema`. What cannot be judged is a row with ``error``; what cannot be read at
        all, a row of no window. ``input_fingerprint`` is empty: the caller knows what it read.

    Raises
    ------
    TypeError, ValueError
        For misuse: what is no table, a column that holds neither numbers nor text nor times, settings that cannot be.

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
    """Judge one window of one loop: what engines call that spread windows over machines. It takes one thread.

    Parameters
    ----------
    table : table
        As for `diagnose_table`: the samples of the window, and of the day before at least the last of each tag.
    settings : str or path or None
        As for `diagnose_table`.
    loop : str
        The loop.
    day : int
        The day of the plant on which the window begins, days since 1970-01-01.
    days : int, default 1
        How many days it has.

    Returns
    -------
    table : Table
        Its row; none without a sample of the OP.
    trace : Table
        What is kept of its signal, to be compared with that of other loops; none of a signal that does not move.
    days : int
        How many days the window should have that begins there. If it is more than one, judge it again with as many.
    """
    return _plant(settings).window(
        table, text("loop", loop), integer("day", day, least=-100_000_000), integer("days", days, least=1)
    )
