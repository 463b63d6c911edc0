"""Recordings of loops from files, tables and arrays, and the fitness of a recording for a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any, TypeAlias

import numpy as np

from stiction import _core
from stiction._arguments import number, optional, positive, text
from stiction._arrays import Array, Samples, samples, unmasked
from stiction._core import Recording
from stiction._document import Fitness, Measure
from stiction._objects import plain_frame, plain_objects
from stiction._result import Result, about, result, result_of
from stiction._words import documented

__all__ = [
    "Fitness",
    "Measure",
    "Recording",
    "Segment",
    "fitness",
    "loop_types",
    "read",
    "recording",
    "recording_from",
    "recordings_from",
    "segments",
]

RecordingLike: TypeAlias = Any
"""The type of recording arguments: a recording, or a table that `recording_from` recognises without further information."""


def loop_types() -> list[str]:
    """List the types of loops.

    Examples
    --------
    >>> import stiction
    >>> stiction.recordings.loop_types()[:3]
    ['flow', 'level', 'pressure']
    """
    return _core.loop_types()


def read(
    path: str | PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    mapping: str | PathLike[str] | None = None,
    zone: str | None = None,
    time_format: str | None = None,
    date: str | None = None,
    sample_time: float | None = None,
    op_range: tuple[float, float] | None = None,
    pv_range: tuple[float, float] | None = None,
    vp_range: tuple[float, float] | None = None,
    loop_type: str | None = None,
    bad_text: Sequence[str] = (),
    part: str | None = None,
    decimal_mark: str | None = None,
    modes: Mapping[str, str] | None = None,
    qualities: Mapping[str, str] | None = None,
    bad_value: Sequence[float] = (),
) -> list[Recording]:
    """Read the recordings in a CSV, Parquet or MATLAB file, or in a workbook of Excel or OpenDocument.

    Columns and tags are recognised by name. Arguments take precedence.

    Parameters
    ----------
    path : str or path
        The file.
    columns : mapping, optional
        Columns or tags by role, such as ``{"op": "OUT", "FIC101.pv": "10FT101"}``. Roles are op, pv, sp, vp,
        mode, time, date, tag, value, quality, op_quality and so on, or ignore.
    mapping : str or path, optional
        A TOML file with further information on the file.
    zone : str, optional
        Time zone of times that state no zone, such as ``"Europe/Berlin"``.
    time_format : str, optional
        Format of times: a pattern such as ``"%d/%m/%Y %H:%M:%S"``, or day-first, month-first, year-first, epoch-s, epoch-ms,
        epoch-us, epoch-ns, dotnet-ticks, filetime, labview, gps, excel, excel-1904, datenum, seconds, milliseconds, microseconds,
        nanoseconds, minutes, hours, days.
    date : str, optional
        Day of the first row, such as ``"2025-03-14"``, for times of day without a date.
    sample_time : float, optional
        Time between rows, s, instead of a column of times.
    op_range, pv_range, vp_range : tuple of float, optional
        The values of the signal at 0 % and 100 %.
    loop_type : str, optional
        Type of the loops, see `loop_types`.
    bad_text : sequence of str, optional
        Words that stand for a bad value.
    part : str, optional
        The sheet of a workbook, or the part of a MATLAB file, to read; by default all sheets or parts.
    decimal_mark : str, optional
        The decimal mark of numbers in text, ``"point"`` or ``"comma"``, if the file does not determine the mark.
    modes : mapping, optional
        Words and codes for a mode, such as ``{"16": "auto"}``. Modes are auto, manual, cascade and other.
    qualities : mapping, optional
        Words and codes for a quality, such as ``{"0": "good"}``. Qualities are good, uncertain and bad.
    bad_value : sequence of float, optional
        Numbers that are no measurements, such as ``-1``. The reader recognises ``-9999`` and similar numbers by itself.

    Returns
    -------
    list of Recording
        The loops in the order of the file.

    Raises
    ------
    FileNotFoundError
        If the file is missing.
    ValueError
        If the data cannot be interpreted; the message gives row and column.

    Examples
    --------
    >>> import stiction
    >>> [loop] = stiction.read("samples/FIC101-sticky.csv")  # doctest: +SKIP
    >>> loop  # doctest: +SKIP
    <Recording "FIC101-sticky" (flow) of 2400 samples: OP, PV, SP>
    """
    told = _reading_options(**locals())
    return _core.read_recordings(_path("path", path), told)


def recording(
    op: Samples,
    pv: Samples | None = None,
    sp: Samples | None = None,
    vp: Samples | None = None,
    *,
    sample_time: float | None = None,
    time: Samples | None = None,
    name: str = "loop",
    loop_type: str | None = None,
    start: float | None = None,
    op_range: tuple[float, float] | None = None,
    pv_range: tuple[float, float] | None = None,
    vp_range: tuple[float, float] | None = None,
) -> Recording:
    """Make a recording from arrays.

    Parameters
    ----------
    op : array_like
        Controller output, percent of span unless `op_range` is given. In all signals NaN marks a missing value.
    pv, sp : array_like, optional
        Process value and set point, in PV units.
    vp : array_like, optional
        Measured valve position, percent of span unless `vp_range` is given.
    sample_time : float, optional
        Time between samples, s. Give either `sample_time` or `time`.
    time : array_like, optional
        Times of the samples: numbers in s, or ``datetime64`` in UTC.
    name : str, default "loop"
        Tag of the loop. If the letters of the tag show the type of the loop by ISA-5.1, that type is used.
    loop_type : str, optional
        Type of the loop, see `loop_types`.
    start : float, optional
        Time zero as seconds since 1970-01-01 UTC.
    op_range, pv_range, vp_range : tuple of float, optional
        The values of the signal at 0 % and 100 %.

    Raises
    ------
    TypeError
        If a signal holds no real numbers.
    ValueError
        If signals differ in length or are empty, if neither or both of `sample_time` and `time` are given, or if
        a value is infinite or out of its range.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> stiction.recording(run.op, run.pv, run.sp, sample_time=run.sample_time, name="FIC101")
    <Recording "FIC101" (flow) of 2400 samples: OP, PV, SP>
    """
    if (sample_time is None) == (time is None):
        raise ValueError("either sample_time or time must be given")
    given: list[tuple[str, Any]] = []
    time_format = None
    if time is not None:
        moments = _times("time", time)
        time_format = None if isinstance(moments, tuple) else "seconds"
        given.append(("time", moments))
    for each, signal in (("op", op), ("pv", pv), ("sp", sp), ("vp", vp)):
        if signal is not None:
            given.append((each, _filled(each, samples(each, signal))))
    told = _reading_options(
        columns={each: each for each, _ in given},
        time_format=time_format,
        sample_time=sample_time,
        op_range=op_range,
        pv_range=pv_range,
        vp_range=vp_range,
        loop_type=loop_type,
    )
    [made] = _core.recordings_of_columns("arrays", given, told)
    start = None if start is None else number("start", start)
    return _core.recording_renamed(made, text("name", name), start, loop_type is None)


def recordings_from(
    table: Any,
    *,
    columns: Mapping[str, str] | None = None,
    mapping: str | PathLike[str] | None = None,
    zone: str | None = None,
    time_format: str | None = None,
    date: str | None = None,
    sample_time: float | None = None,
    op_range: tuple[float, float] | None = None,
    pv_range: tuple[float, float] | None = None,
    vp_range: tuple[float, float] | None = None,
    loop_type: str | None = None,
    bad_text: Sequence[str] = (),
    decimal_mark: str | None = None,
    modes: Mapping[str, str] | None = None,
    qualities: Mapping[str, str] | None = None,
    bad_value: Sequence[float] = (),
) -> list[Recording]:
    """Make recordings from a table with the columns of one loop or several loops, or with tags in rows.

    Columns are recognised as in files.

    Parameters
    ----------
    table : table
        A table of pandas, polars, pyarrow or any other library with the Arrow capsule interface, or a mapping of columns by name.
        Null and NaN are missing, and timestamps may have any unit. A pandas index of times is used as the column of times, and an
        index of time differences as elapsed time. A column of objects may mix numbers, decimals and words such as ``"Bad"``. A
        polars ``LazyFrame`` is collected.
    columns, mapping, zone, time_format, date, sample_time, op_range, pv_range, vp_range, loop_type, bad_text, bad_value, decimal_mark, modes, qualities : optional
        As in `read`.

    Returns
    -------
    list of Recording
        The loops in the order of the first column of each loop.

    Raises
    ------
    TypeError
        If `table` is not a table, or a column holds neither numbers nor text nor times.
    ValueError
        If the data cannot be interpreted; the message gives row and column.
    """
    return _of_table(table, _reading_options(**locals()))


def recording_from(
    table: Any,
    *,
    time: str | None = None,
    op: str | None = None,
    pv: str | None = None,
    sp: str | None = None,
    vp: str | None = None,
    mode: str | None = None,
    name: str | None = None,
    zone: str | None = None,
    time_format: str | None = None,
    sample_time: float | None = None,
    op_range: tuple[float, float] | None = None,
    pv_range: tuple[float, float] | None = None,
    vp_range: tuple[float, float] | None = None,
    loop_type: str | None = None,
    decimal_mark: str | None = None,
    modes: Mapping[str, str] | None = None,
    qualities: Mapping[str, str] | None = None,
) -> Recording:
    """Make a recording from a table with the columns of one loop.

    Parameters
    ----------
    table : table
        As in `recordings_from`.
    time, op, pv, sp, vp, mode : str, optional
        Names of columns. All other columns are recognised by name, as in files.
    name : str, optional
        Tag of the loop; by default from the columns.
    zone, time_format, sample_time, op_range, pv_range, vp_range, loop_type, decimal_mark, modes, qualities : optional
        As in `read`.

    Raises
    ------
    TypeError
        If `table` is not a table, or a column holds neither numbers nor text nor times.
    ValueError
        If the table cannot be interpreted, or holds several loops. Use `recordings_from` for several loops.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> table = {"OUT": run.op, "MEAS": run.pv}
    >>> stiction.recording_from(table, op="OUT", sample_time=1, name="FIC101")
    <Recording "FIC101" (flow) of 2400 samples: OP, PV>
    """
    told = dict(locals())
    roles = {role: told.pop(role) for role in ("time", "op", "pv", "sp", "vp", "mode")}
    columns = {role: text(role, column) for role, column in roles.items() if column is not None}
    made = _of_table(table, _reading_options(columns=columns, **told))
    if len(made) != 1:
        names = ", ".join(each.name for each in made)
        raise ValueError(f"table holds the loops {names}; name the columns of one, or use recordings_from")
    if name is None:
        return made[0]
    return _core.recording_renamed(made[0], text("name", name), None, loop_type is None)


@documented
def fitness(recording: RecordingLike, *, sample_time: float | None = None) -> Fitness:
    """Return the fitness of a recording for a diagnosis.

    Parameters
    ----------
    sample_time : float, optional
        Time between samples of the grid, s; by default the most frequent sample time of the recording.

    Returns
    -------
    Fitness
        The fitness of the longest segment in automatic.

    Raises
    ------
    ValueError
        If the recording does not fit on a grid.

    Examples
    --------
    >>> import stiction
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> stiction.recordings.fitness(stiction.recording(run.op, run.pv, sample_time=1)).class_
    'fit'
    """
    sample_time = optional("sample_time", sample_time)
    return result_of(Fitness, _core.recording_fitness(_checked(recording, sample_time=sample_time), sample_time))


@result
class Segment(Result):
    """A part of a recording in automatic without gaps, on a regular grid."""

    time_s: Array = about("Times of the samples, s on the recording's clock.")
    sample_time: float = about("Time between samples, s.")
    op: Array = about("Controller output, percent of span.")
    pv: Array | None
    sp: Array | None = about("Process value and set point, in PV units.")
    vp: Array | None = about("Measured valve position, percent of span.")
    bridged: int = about("Number of missing samples that were bridged.")


@documented
def segments(recording: RecordingLike, *, sample_time: float | None = None) -> list[Segment]:
    """Resample a recording to a regular grid.

    The recording is cut where the controller was not in automatic, and at more than three missing samples in a row.

    Parameters
    ----------
    sample_time : float, optional
        Time between samples of the grid, s; by default the most frequent sample time of the recording.

    Returns
    -------
    list of Segment
        The segments, in order of time.

    Raises
    ------
    ValueError
        If the times are implausible.
    """
    sample_time = optional("sample_time", sample_time)
    found = _core.recording_segments(_checked(recording, sample_time=sample_time), sample_time)
    return [Segment(**segment) for segment in found]


def _checked(recording: Any, name: str = "recording", sample_time: float | None = None) -> Recording:
    """Return a recording unchanged, or make a recording from a table. `sample_time` is for a table without times."""
    if isinstance(recording, Recording):
        return recording
    if _is_table(recording):
        try:
            return recording_from(recording)
        except ValueError as error:
            if sample_time is None or "no column of times" not in str(error):
                raise
        return recording_from(recording, sample_time=sample_time)
    makers = "stiction.read makes recordings from a file, stiction.recording one from arrays"
    raise TypeError(
        f"{name} must be a Recording or a table, but its type is {type(recording).__name__}; {makers}"
    )


def _is_table(value: Any) -> bool:
    """Distinguish a table from a column and from other objects."""
    known = ("columns", "column_names", "schema")
    return isinstance(value, Mapping) or any(hasattr(value, name) for name in known)


def _reading_options(**told: Any) -> dict[str, Any]:
    """Check the information on a file or table, among other arguments."""
    columns, mapping, sample_time = map(told.get, ("columns", "mapping", "sample_time"))
    if columns is not None and not isinstance(columns, Mapping):
        raise TypeError(f"columns must be a mapping of roles to names, but its type is {type(columns).__name__}")
    texts = {name: told.get(name) for name in ("zone", "time_format", "date", "loop_type", "part", "decimal_mark")}
    bad_text = told.get("bad_text", ())
    return {
        "mapping": None if mapping is None else _path("mapping", mapping),
        "columns": [f"{role}={text(f'columns[{role!r}]', name)}" for role, name in (columns or {}).items()],
        "sample_time": None if sample_time is None else positive("sample_time", sample_time),
        "bad_text": [text("bad_text", word) for word in ([bad_text] if isinstance(bad_text, str) else bad_text)],
        "bad_value": [number("bad_value", value) for value in np.atleast_1d(told.get("bad_value", ())).tolist()],
        **{name: None if value is None else text(name, value) for name, value in texts.items()},
        **{name: _range(name, told.get(name)) for name in ("op_range", "pv_range", "vp_range")},
        **{
            name: [f"{word}={text(name, meaning)}" for word, meaning in (told.get(name) or {}).items()]
            for name in ("modes", "qualities")
        },
    }


def _path(name: str, path: Any) -> str:
    """Return the path of a file."""
    if not isinstance(path, (str, PathLike)):
        raise TypeError(f"{name} must be a path, but its type is {type(path).__name__}")
    return str(fspath(path))


def _range(name: str, ends: Any) -> tuple[float, float] | None:
    """Return two numbers, the lower one first."""
    if ends is None:
        return None
    try:
        low, high = ends
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a pair of numbers such as (0, 100)") from None
    low, high = number(name, low), number(name, high)
    if not -np.inf < low < high < np.inf:
        raise ValueError(f"{name} is ({low:g}, {high:g}), but must be two finite numbers, the lower one first")
    return low, high


def _filled(name: str, signal: Array) -> Array:
    """Return `signal` if it has a sample."""
    if len(signal) == 0:
        raise ValueError(f"{name} is empty, but needs at least one sample")
    return signal


def _times(name: str, values: Any) -> Array | tuple[Array, bool]:
    """Return times in s, and whether dates are in UTC."""
    array = unmasked(values)
    if array.dtype.kind != "M":
        return samples(name, values)
    nanoseconds = array.astype("datetime64[ns]")
    seconds = nanoseconds.astype(np.int64).astype(np.float64) / 1e9
    return np.where(np.isnat(nanoseconds), np.nan, seconds), True


def _of_table(table: Any, told: dict[str, Any]) -> list[Recording]:
    """Make recordings from any table."""
    if type(table).__name__ == "LazyFrame":
        table = table.collect()
    if hasattr(table, "iloc") and hasattr(table, "dtypes"):
        table = plain_frame(table)
    if hasattr(table, "__arrow_c_stream__"):
        try:
            return _core.recordings_of_arrow("table", table, told)
        except Exception as error:  # Older pandas exports with pyarrow only; others export some types wrongly.
            is_of_arrow = type(error).__module__.startswith("pyarrow")
            if isinstance(error, (TypeError, ValueError, OSError)) and not is_of_arrow:
                raise
    names = table.keys() if isinstance(table, Mapping) else getattr(table, "columns", None)
    if names is None:
        raise TypeError(f"table must be a table or a mapping of columns, but its type is {type(table).__name__}")
    given = [(str(name), _column(str(name), table[name])) for name in names]
    if not given:
        raise ValueError("table has no columns")
    return _core.recordings_of_columns("table", given, told)


def _column(name: str, values: Any) -> Any:
    """Return a column as numbers, text or times."""
    if hasattr(values, "__arrow_c_stream__") or hasattr(values, "__arrow_c_array__"):
        try:
            return samples(name, values)
        except (TypeError, ImportError):
            pass
    array = unmasked(values)
    if array.dtype.kind == "M":
        return _times(name, array)
    if array.dtype.kind in "OUS":
        return plain_objects(array.tolist())
    return samples(name, array.astype(np.float64) if array.dtype.kind == "b" else array)
