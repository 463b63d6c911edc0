"""The scan of a plant on Apache Spark. The scan on Spark and the local scan have equal windows, rows and compiled code.

``python -m stiction.plant.spark --plant DIR --output DIR --input DATA`` runs a scan; `scan` takes a data frame.

One task on one core judges a window, from the samples of the window's days and the last sample of each tag on the day before. A
task therefore needs memory for one window only, in a plant of any size. A window is a day. If ten periods of the loop's swing
take longer, a second round judges a window as long as ten periods, in whole days. The local scan chooses windows in this way,
too.
"""

from __future__ import annotations

import argparse
import fnmatch
import functools
import hashlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from datetime import date
from pathlib import Path
from typing import Any, TypeAlias

from stiction import _core
from stiction._result import Result, about, result
from stiction._words import documented
from stiction.plant import Settings, _plant, ddl, model_version, schema, take

try:
    from pyspark.sql import functions as F
except ImportError:
    raise ImportError("stiction.plant.spark needs PySpark: pip install pyspark") from None

__all__ = ["MOST_ERRORS", "Pairs", "Plan", "Scan", "explain", "main", "pairs", "probe", "scan"]

MOST_ERRORS = 0.05
"""Maximum share of loops with an error. Above this share, a job ends with an error after writing."""
TAKEN_TOGETHER = 20_000
"""Maximum number of rows that the driver writes to the store of a plant at a time."""
WINDOWS_A_TASK = 16
"""Maximum number of windows per task. A task with this number of windows takes some seconds, which are lost if a worker fails."""
WINDOWS_A_CORE = 4_000
"""Windows per core between two writes of the command. These windows take some minutes, which are lost if the driver fails."""
LOOPS_A_BLOCK = 200
"""Maximum number of loops that a task compares with as many other loops. The traces of these loops for a week take some hundred
megabytes."""
ROWS_A_BATCH = "spark.sql.execution.arrow.maxRecordsPerBatch"
PAIRS_TOGETHER = 200_000
"""Maximum number of pairs of loops that the driver collects without first reducing the number of pairs."""
DAY_US = 86_400_000_000
DAY_BITS, LENGTH_BITS = 28, 4
"""A window is one number, made of the loop, the first day and the length, because Spark sorts numbers fast."""
TRACE = ["trace_start", "trace_signal", "trace_unit", "trace_values"]
"""The trace of a window's signal, in columns after the columns of the window's row."""
TRACE_DDL = "trace_start BIGINT, trace_signal STRING, trace_unit DOUBLE, trace_values BINARY"
UNKNOWN = -32_768
"""The value for unknown samples of a trace. Values are whole numbers of two bytes, low byte first."""


@result
class Plan(Result):
    """The plan of a scan."""

    loops: int = about("Loops in the data.")
    windows: int = about(
        "Windows to judge, of one day each. A loop that swings slowly has fewer, longer windows."
    )
    done: int = about("Windows that were judged before.")
    partitions: int = about("Number of tasks.")
    samples: int = about("Samples sent to the tasks; for a wide table, rows.")
    bytes: int = about("Approximate size of the samples sent to the tasks.")


@result
class Scan(Result):
    """The result of a scan."""

    rows: Any = about(
        "The rows of the results, in the columns of `stiction.plant.schema`, followed by the traces with which "
        "a report finds loops that swing together; Spark keeps them until ``unpersist``.",
        kind="pyspark.sql.DataFrame",
    )
    plan: Plan = about("The plan of the scan.")
    windows: int = about("Number of rows.")
    errors: int = about("Number of windows that could not be judged.")
    loops_in_error: frozenset[str] = about("Loops with such windows.")


@result
class Pairs(Result):
    """The pairs of loops that may swing together in a week."""

    week: str = about("The week.")
    loops: int = about("Number of compared loops.")
    blocks: int = about("Number of blocks of loops. Each block was compared with each block.")
    compared: int = about("Number of compared pairs of loops.")
    kept: int = about(
        "Number of pairs kept for the report, counted once for each band in which the two loops may swing in step."
    )


Window: TypeAlias = tuple[int, int, int]
"""Loop, first day, number of days."""


def _number(window: Window) -> int:
    loop, day, days = window
    return (loop << DAY_BITS | day + (1 << DAY_BITS - 1)) << LENGTH_BITS | days


def _window(number: int) -> Window:
    rest, days = number >> LENGTH_BITS, number & (1 << LENGTH_BITS) - 1
    return rest >> DAY_BITS, (rest & (1 << DAY_BITS) - 1) - (1 << DAY_BITS - 1), days


def _frame(spark: Any, rows: Sequence[tuple[Any, ...]], columns: str) -> Any:
    return spark.createDataFrame(list(rows), columns)


def probe(spark: Any) -> None:
    """Check, before any work, that the executors have this version of the wheel.

    Parameters
    ----------
    spark : pyspark.sql.SparkSession
        The session.

    Raises
    ------
    RuntimeError
        If an executor has no wheel, or a wheel of another version or model. The message names the executor and the remedy.
    """
    expected = _made_by()

    def version_of(_batches: Any) -> Iterator[Any]:
        import socket

        import pyarrow

        host, version, model, problem = socket.gethostname(), "", "", ""
        try:
            import stiction
            import stiction.plant

            version, model = stiction.__version__, stiction.plant.model_version()
        except Exception as error:  # Whatever it is, the driver tells it.
            problem = f"{type(error).__name__}: {error}"
        row = {"host": [host], "version": [version], "model": [model], "problem": [problem]}
        yield pyarrow.RecordBatch.from_pydict(row)

    # Sent as code, because its module may be missing there.
    version_of.__module__ = "__main__"
    count = 2 * _cores(spark)
    try:
        of_each = spark.range(0, count, 1, count).mapInArrow(
            version_of, "host STRING, version STRING, model STRING, problem STRING"
        )
        answers = of_each.distinct().collect()
    except Exception as error:
        first = next((line for line in str(error).splitlines() if "Error" in line), str(error).partition("\n")[0])
        raise RuntimeError(f"the executors cannot run Python with Arrow: {first}; install pyarrow and NumPy on them") from error
    for answer in answers:
        if answer.problem:
            words = f"executor {answer.host} cannot use the wheel ({answer.problem})"
            remedy = "ship the wheel with --archives stiction.zip#deps and PYTHONPATH=./deps, or install it there"
            raise RuntimeError(f"{words}; {remedy}")
        if (answer.version, answer.model) != expected:
            words = f"executor {answer.host} has stiction {answer.version} ({answer.model})"
            raise RuntimeError(f"{words}, but the driver has {expected[0]} ({expected[1]}); ship the driver's wheel")


def _made_by() -> tuple[str, str]:
    return _core.__version__, model_version()


def _same(expected: tuple[str, str]) -> None:
    """Ends a task on an executor that joined later with a version or model different from the driver's."""
    found = _made_by()
    if found != expected:
        raise RuntimeError(f"this executor has stiction {found}, but the driver has {expected}; ship the driver's wheel")


def _cores(spark: Any) -> int:
    try:
        return max(1, int(spark.sparkContext.defaultParallelism))
    except Exception:  # Spark Connect has no context.
        return 8


class _Input:
    """A data frame of samples with the loops, and with the loop and the day of each row."""

    def __init__(self, df: Any, plant: _core.Plant, pattern: str | None) -> None:
        shape = plant.shape(df.columns)
        if shape is None:
            raise ValueError(f"the columns {df.columns} include no column of times; a long table has times, tags and values")
        time, long, about = shape
        self.time = df.columns[time]
        kind = df.schema[self.time].dataType.typeName()
        if kind not in {"timestamp", "timestamp_ntz"}:
            raise ValueError(f'the column "{self.time}" holds {kind}; cast it to timestamp')
        self.tag = None if long is None else df.columns[long[0]]
        if self.tag is None:
            names, rows = df.columns, about
        else:
            found = df.select(self.tag).where(F.col(f"`{self.tag}`").isNotNull()).distinct().collect()
            names, rows = sorted(str(row[0]) for row in found), []
        known = plant.loops(names, rows)
        fits = [each for each in known if pattern is None or fnmatch.fnmatch(each[0].lower(), pattern.lower())]
        if not fits:
            raise ValueError(f"no loop is recognised by the tags of the data{'' if known else ': ' + _some(names)}")
        self.names = [name for name, _, _ in fits]
        self.tags = [[names[k] for k in tags] for _, tags, _ in fits]
        self.about = [df.columns[k] for k in about if df.columns[k] not in {self.time, self.tag}]
        self.numeric = {
            field.name: field.dataType.typeName() not in {"string", "varchar", "char"} for field in df.schema
        }
        moment = F.col(f"`{self.time}`")
        if kind == "timestamp":
            local = F.unix_micros(F.from_utc_timestamp(moment, plant.zone))
            day = ((local - F.pmod(local, F.lit(DAY_US))) / F.lit(DAY_US)).cast("int")
        else:
            day = F.datediff(F.to_date(moment), F.lit("1970-01-01").cast("date"))
        self.kind = kind
        ops = [op for _, _, op in fits]

        def cut(df: Any) -> Any:
            return (self._long if self.tag else self._wide)(df, moment, day, ops, names)

        self._df, self._cut = df, cut
        self.samples = cut(df)
        self.payload = [name for name in self.samples.columns if name not in {"loop_id", "time", "day", "is_op", "tag"}]

    def samples_of(self, loops: set[int]) -> Any:
        """The samples of the given loops. For many loops or a wide table, samples of other loops are included."""
        if self.tag is None or 2 * len(loops) > len(self.names):
            return self.samples
        tags = sorted({tag for loop in loops for tag in self.tags[loop]})
        return self._cut(self._df.where(F.col(f"`{self.tag}`").isin(tags)))

    def _long(self, df: Any, moment: Any, day: Any, ops: list[int], names: list[str]) -> Any:
        """The samples of a long table: loop, number of the tag within the loop, time, and other columns."""
        places = [
            (tag, loop, k, tag == names[ops[loop]])
            for loop, own in enumerate(self.tags)
            for k, tag in enumerate(own)
        ]
        of = _frame(df.sparkSession, places, "of STRING, loop_id INT, tag INT, is_op BOOLEAN")
        tag = F.col(f"`{self.tag}`").cast("string")
        rest = [F.col(f"`{name}`").alias(f"of_{k}") for k, name in enumerate(self.about)]
        rows = df.select(tag.alias("of"), moment.alias("time"), day.alias("day"), *rest).where(moment.isNotNull())
        return rows.join(F.broadcast(of), "of").drop("of")

    def _wide(self, df: Any, moment: Any, day: Any, ops: list[int], names: list[str]) -> Any:
        """The rows of a wide table, split into the columns of each loop, with numbers, and texts such as modes."""

        def cells(own: list[str], numeric: bool, kind: str) -> Any:
            chosen = [F.col(f"`{name}`").cast(kind) for name in own if self.numeric[name] == numeric]
            return (F.array(*chosen) if chosen else F.array()).cast(f"array<{kind}>")

        loops = [
            F.struct(
                F.lit(loop).alias("loop_id"),
                cells(own, True, "double").alias("numbers"),
                cells(own, False, "string").alias("texts"),
            )
            for loop, own in enumerate(self.tags)
        ]
        rest = [F.col(f"`{name}`").alias(f"of_{k}") for k, name in enumerate(self.about)]
        rows = df.select(moment.alias("time"), day.alias("day"), F.explode(F.array(*loops)).alias("own"), *rest)
        rows = rows.where(F.col("time").isNotNull())
        return rows.select("own.*", "time", "day", *[f"of_{k}" for k in range(len(rest))], F.lit(True).alias("is_op"))

    def marks(self) -> Any:
        """The number of samples of each loop, tag and day, with a digest of the samples and the last sample."""
        keys = ["loop_id", "day", *(["tag"] if self.tag else [])]
        digest = F.xxhash64("time", *(["tag"] if self.tag else []), *self.payload)
        last = [F.max_by(name, "time").alias(name) for name in self.payload]
        return self.samples.groupBy(*keys).agg(
            F.count(F.lit(1)).alias("samples"),
            F.bit_xor(digest).alias("digest"),
            F.max("is_op").alias("is_op"),
            F.max("time").alias("time"),
            *last,
        )

    def table_of(self) -> Callable[[int, Any], Any]:
        """Rebuilds, on an executor, the source table from the rows of a group."""
        time, tag, about, tags, numeric = self.time, self.tag, self.about, self.tags, self.numeric

        def table(loop: int, group: Any) -> Any:
            import pyarrow as pa

            columns, own = {time: group["time"]}, tags[loop]
            if tag is not None:
                places = group["tag"].combine_chunks().cast(pa.int32())
                columns[tag] = pa.DictionaryArray.from_arrays(places, pa.array(own, pa.string()))
            else:
                for kind, names in [
                    ("numbers", [name for name in own if numeric[name]]),
                    ("texts", [name for name in own if not numeric[name]]),
                ]:
                    # Row by row, all of one length.
                    cells = group[kind].combine_chunks().flatten()
                    for k, name in enumerate(names):
                        columns[name] = cells.take(pa.array(range(k, len(cells), len(names)), pa.int64()))
            columns.update({name: group[f"of_{k}"] for k, name in enumerate(about)})
            return pa.table(columns)

        return table


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:5]) + (", ..." if len(names) > 5 else "")


class _Chain:
    """The known windows. Each window begins where the previous window ends."""

    def __init__(self, plant: _core.Plant, of: _Input, marks: Any, known: Any, since: int | None) -> None:
        self.plant, self.names = plant, of.names
        self.since = -(1 << 62) if since is None else since
        # The number of samples of each loop and day, their digest, and whether there is an OP.
        self.days: list[dict[int, tuple[int, int, bool]]] = [{} for _ in of.names]
        per_day = marks.groupBy("loop_id", "day").agg(
            F.sum("samples").alias("samples"), F.bit_xor("digest").alias("digest"), F.max("is_op").alias("is_op")
        )
        for row in per_day.collect():
            self.days[row.loop_id][row.day] = (row.samples, row.digest, row.is_op)
        self.hashes = [plant.settings_hash(name) for name in of.names]
        self.begin = functools.cache(plant.begin)
        self.kept: dict[tuple[str, int], tuple[int, str, str]] = {}
        if known is not None:
            columns = ["loop", "window_start", "window_s", "settings_hash", "input_fingerprint"]
            newest = "run" in known.columns
            rows = known.orderBy(F.col("run").cast("bigint")) if newest else known
            for row in rows.select(*columns).collect():
                self.kept[row[0], row[1]] = (row[2], row[3], row[4])
        # The number of days that a window beginning on a day should have, from those judged.
        self.wanted: dict[tuple[int, int], int] = {}
        self.judged: set[Window] = set()

    def fingerprint(self, loop: int, day: int, days: int) -> str:
        """SHA-256 of the data of a window, from the digests of the days of the window and of the day before."""
        own = self.days[loop]
        lines = [f"{d} {own[d][0]} {own[d][1]}" for d in range(day - 1, day + days) if d in own]
        return hashlib.sha256("\n".join(lines).encode()).hexdigest()

    def done(self, loop: int, day: int) -> int:
        """The number of days of the window that begins on `day`, if the window is judged; else 0."""
        start = self.begin(day)
        kept = self.kept.get((self.names[loop], start))
        if kept is None:
            return 0
        seconds, settings, made_of = kept
        days = self.plant.day(start + seconds - 1.0) + 1 - day
        return days if settings == self.hashes[loop] and made_of == self.fingerprint(loop, day, days) else 0

    def until(self, most: int | None) -> int:
        """The day before which about `most` windows remain to be judged, or all."""
        per_day: dict[int, int] = {}
        for _, day, _ in self.walk()[1]:
            per_day[day] = per_day.get(day, 0) + 1
        number = 0
        for day in sorted(per_day):
            if most is not None and number and number + per_day[day] > most:
                return day
            number += per_day[day]
        return 1 << 62

    def walk(self) -> tuple[list[Window], list[Window], int]:
        """Return the judged and valid windows, the windows to judge, and the number of windows judged before."""
        there: list[Window] = []
        open_: list[Window] = []
        done = 0
        for loop, own in enumerate(self.days):
            cursor = self.since
            for day in sorted(day for day, (_, _, is_op) in own.items() if is_op):
                if day < cursor:
                    continue
                if days := self.done(loop, day):
                    done += 1
                    cursor = day + days
                    continue
                days = self.wanted.get((loop, day), 1)
                (there if (loop, day, days) in self.judged else open_).append((loop, day, days))
                cursor = day + days
        return there, open_, done


def _partitions(windows: int, cores: int) -> int:
    """The number of tasks that keeps all cores busy and limits the loss of each task."""
    return max(1, min(windows, max(3 * cores, -(-windows // WINDOWS_A_TASK))))


def _judge(spark: Any, of: _Input, marks: Any, chain: _Chain, windows: list[Window]) -> Any:
    """The rows of windows, with the number of days that each should have."""
    words = chain.plant.text
    spread = [(loop, day + k, _number((loop, day, days))) for loop, day, days in windows for k in range(days)]
    held_from = [(loop, day - 1, _number((loop, day, days))) for loop, day, days in windows]
    # Both are numbers of 4 bytes, so that Spark looks them up as one of 8.
    of_days = "loop_id INT, day INT, window BIGINT"
    columns = ["window", "time", *(["tag"] if of.tag else []), *of.payload]
    samples = of.samples_of({loop for loop, _, _ in windows})
    if of.kind == "timestamp":
        # Rows that no window needs are not read, if files show the times of their rows.
        begin = chain.begin(min(day for _, day, _ in windows))
        end = chain.begin(max(day + days for _, day, days in windows))
        time = F.col("time")
        samples = samples.where((time >= F.timestamp_seconds(F.lit(begin))) & (time < F.timestamp_seconds(F.lit(end))))
    samples = samples.join(F.broadcast(_frame(spark, spread, of_days)), ["loop_id", "day"]).select(*columns)
    held = marks.join(F.broadcast(_frame(spark, held_from, of_days)), ["loop_id", "day"]).select(*columns)
    rows = samples.unionByName(held).repartition(_partitions(len(windows), _cores(spark)), "window")
    expected, names, table_of = _made_by(), of.names, of.table_of()

    def judge(batches: Iterator[Any]) -> Iterator[Any]:
        import pyarrow as pa

        from stiction.plant import diagnose_window

        _same(expected)
        for number, group in _groups(batches, "window"):
            loop, day, days = _window(number)
            row, trace, wanted = diagnose_window(table_of(loop, group), words, names[loop], day, days)
            table = pa.table(row)
            if len(table) == 0:
                # The driver must learn that it was judged.
                table = pa.table([pa.nulls(1, field.type) for field in table.schema], names=table.column_names)
            kept = pa.table(trace)
            start, signal, unit = (column.to_pylist() for column in kept.columns[1:4])
            values = []
            if len(kept):
                numbers = kept["values"].combine_chunks().flatten().fill_null(UNKNOWN).to_numpy()
                values = [numbers.astype("<i2").tobytes()]
            for field, value in zip(_trace_fields(), [start, signal, unit, values]):
                table = table.append_column(field, pa.array(value or [None], field.type))
            for name, value, kind in [
                ("window", number, pa.int64()),
                ("wanted", wanted, pa.int64()),
            ]:
                table = table.append_column(name, pa.array([value], kind))
            yield from table.to_batches()

    # Spark 3.5 lacks groupBy().applyInArrow(). This is equivalent, and never holds a whole group in Java's memory.
    return rows.sortWithinPartitions("window").mapInArrow(judge, f"{ddl()}, {TRACE_DDL}, window BIGINT, wanted BIGINT")


def _groups(batches: Iterator[Any], key: str) -> Iterator[tuple[int, Any]]:
    """Yield a table of the rows for each number in the column `key`, from batches sorted by this column."""
    import numpy as np
    import pyarrow as pa

    number = -1
    parts: list[Any] = []
    for batch in batches:
        if len(batch) == 0:
            continue
        of_each = batch.column(batch.schema.get_field_index(key)).to_numpy()
        changes = (np.flatnonzero(np.diff(of_each)) + 1).tolist()
        for begin, end in zip([0, *changes], [*changes, len(batch)]):
            own = int(of_each[begin])
            if parts and number != own:
                yield number, pa.Table.from_batches(parts)
                parts = []
            number = own
            parts.append(batch.slice(begin, end - begin))
    if parts:
        yield number, pa.Table.from_batches(parts)


def _begun(
    df: Any, settings: Settings, since: str | None, loops: str | None, known: Any
) -> tuple[_Input, Any, _Chain]:
    plant = _plant(settings)
    of = _Input(df, plant, loops)
    # A few loops have few rows, and tasks without work would cost more.
    marks = of.marks().coalesce(max(_cores(df.sparkSession), len(of.names) // 50)).persist()
    first = None if since is None else (date.fromisoformat(since) - date(1970, 1, 1)).days
    return of, marks, _Chain(plant, of, marks, known, first)


def _plan(spark: Any, of: _Input, chain: _Chain) -> Plan:
    _, windows, done = chain.walk()
    samples = sum(chain.days[loop].get(day, (0,))[0] for loop, day, _ in windows)
    # Keys and time, then the contents of a sample in Spark's rows, in words of 8 bytes.
    width = 8 * (6 + len(of.payload)) if of.tag else 8 * (10 + sum(map(len, of.tags)) // len(of.tags))
    return Plan(
        loops=len(of.names),
        windows=len(windows),
        done=done,
        partitions=_partitions(len(windows), _cores(spark)) if windows else 0,
        samples=samples,
        bytes=samples * width,
    )


def explain(
    df: Any, settings: Settings = None, *, since: str | None = None, loops: str | None = None, known: Any = None
) -> Plan:
    """Return the plan of `scan`. The data are read once, for loops and days.

    Parameters
    ----------
    df : pyspark.sql.DataFrame
        As for `scan`.
    settings : str or path, optional
        As for `scan`.
    since, loops : str, optional
        As for `scan`.
    known : pyspark.sql.DataFrame, optional
        As for `scan`.

    Returns
    -------
    Plan
        The numbers of windows, partitions and bytes.
    """
    of, marks, chain = _begun(df, settings, since, loops, known)
    plan = _plan(df.sparkSession, of, chain)
    marks.unpersist()
    return plan


@documented
def scan(
    df: Any, settings: Settings = None, *, since: str | None = None, loops: str | None = None, known: Any = None
) -> Scan:
    """Judge the new data of a plant whose samples are a data frame.

    Parameters
    ----------
    df : pyspark.sql.DataFrame
        Samples, long or wide, from Parquet, Delta or a table. The columns are recognised by name, as in files. The column
        of times is a timestamp.
    settings : str or path, optional
        The text of a ``plant.toml``, or the path of the folder with that file. By default the zone is UTC, and loops and columns
        are recognised by name.
    known : pyspark.sql.DataFrame, optional
        Rows of earlier scans. If the rows have a column ``run``, the last run of each window counts. A window is not judged again
        if a row has the samples and settings of the window.

    Returns
    -------
    Scan
        The rows, with the numbers of windows and errors.

    Raises
    ------
    RuntimeError
        If an executor has no wheel, or a wheel of another version or model.
    ValueError
        If the table has no column of times or no loop, or the settings are invalid.
    """
    (done,) = _scans(df, settings, since, loops, known, None)
    return done


def _scans(
    df: Any, settings: Settings, since: str | None, loops: str | None, known: Any, most: int | None
) -> Iterator[Scan]:
    """Yield scans of about `most` windows each, day after day; one scan if nothing is new. Rows are valid until the next scan."""
    spark = df.sparkSession
    probe(spark)
    of, marks, chain = _begun(df, settings, since, loops, known)
    plan = _plan(spark, of, chain)
    names = [*(field.name for field in spark.createDataFrame([], ddl()).schema), *TRACE]
    told: set[Window] = set()
    while True:
        until = chain.until(most)
        rounds: list[Any] = []
        while windows := [window for window in chain.walk()[1] if window[1] < until]:
            found = _judge(spark, of, marks, chain, windows).persist()
            rounds.append(found)
            chain.judged.update(windows)
            for row in found.select("window", "wanted").collect():
                loop, day, days = _window(row.window)
                if days == 1:
                    chain.wanted[loop, day] = row.wanted
        there, open_, _ = chain.walk()
        new = [window for window in there if window not in told]
        told.update(new)
        if rounds:
            counts = [(_number(window), chain.fingerprint(*window)) for window in new]
            final = _frame(spark, counts, "window BIGINT, input_fingerprint STRING")
            all_rows = functools.reduce(lambda a, b: a.unionByName(b), rounds).drop("input_fingerprint")
            rows = all_rows.join(F.broadcast(final), "window").where(F.col("loop").isNotNull()).select(*names)
        else:
            rows = spark.createDataFrame([], f"{ddl()}, {TRACE_DDL}")
        rows = rows.persist()
        failed = F.when(F.col("error").isNotNull(), F.col("loop"))
        counted = rows.agg(F.count(F.lit(1)), F.count("error"), F.collect_set(failed)).collect()[0]
        for each in rounds:
            each.unpersist()
        if not open_:
            marks.unpersist()
        yield Scan(rows=rows, plan=plan, windows=counted[0], errors=counted[1], loops_in_error=frozenset(counted[2]))
        if not open_:
            return
        rows.unpersist()


def _known(spark: Any, output: str) -> Any:
    """Rows of earlier runs, with the number of each row's run; None before the first run."""
    from pyspark.errors import AnalysisException

    try:
        found = spark.read.parquet(output)
        # Spark Connect checks only when a result is requested.
        _ = found.schema
        return found
    except AnalysisException as error:
        if any(word in str(error) for word in ("PATH_NOT_FOUND", "UNABLE_TO_INFER_SCHEMA")):
            return None
        raise


def _trace_fields() -> list[Any]:
    """The columns of `TRACE`, as an Arrow schema."""
    import pyarrow as pa

    return list(map(pa.field, TRACE, [pa.int64(), pa.string(), pa.float64(), pa.binary()]))


def _traces(rows: Any) -> Any:
    """Traces for the library, from a table of rows that have a trace."""
    return rows.select(["loop", *TRACE]).rename_columns(["loop", *(name.removeprefix("trace_") for name in TRACE)])


@documented
def pairs(rows: Any, folder: str | os.PathLike[str], *, week: str | None = None) -> Pairs:
    """Find pairs of loops that may swing together, in blocks, and keep the pairs in the store of the plant.

    The report of the week uses these pairs and finds the groups that a report without stored pairs would find. For thousands of
    loops, finding pairs is the slow part of a report.

    Parameters
    ----------
    rows : pyspark.sql.DataFrame
        Rows with their traces, as returned by `scan`. If the rows have a column ``run``, the last run of each window counts. The
        plant's store must already contain these rows.

    Returns
    -------
    Pairs
        The numbers of loops and pairs.

    Raises
    ------
    RuntimeError
        If an executor has no wheel, or a wheel of another version or model.
    ValueError
        If no window of the week was judged, or the rows differ from the rows of the store.
    """
    import pyarrow as pa

    spark, name = rows.sparkSession, os.fspath(folder)
    of_week, begin, end, periods = _core.plant_week(name, week)
    probe(spark)
    start = F.col("trace_start")
    found = rows.where((start >= begin) & (start < end))
    if "run" in rows.columns:
        last = F.max_by(F.struct(*TRACE[1:]), F.col("run").cast("bigint")).alias("own")
        found = found.groupBy("loop", "trace_start").agg(last).select("loop", "trace_start", "own.*")
    traces = found.select("loop", *TRACE).persist()
    digest = F.sha2("trace_values", 256).alias("digest")
    length = F.length("trace_values").alias("length")
    seen = traces.select("loop", "trace_start", "trace_unit", digest, length).collect()
    if not seen:
        raise ValueError(f"the rows have no traces in {of_week}")
    span = (
        min(row.trace_start for row in seen),
        max(row.trace_start + _core.TRACE_STEP_S * (row.length // 2) for row in seen),
    )
    loops = sorted({row.loop for row in seen})
    blocks = _blocks(len(loops), _cores(spark))
    places = _frame(spark, [(loop, k % blocks) for k, loop in enumerate(loops)], "loop STRING, block INT")
    both = F.transform(
        F.sequence(F.lit(0), F.lit(blocks - 1)),
        lambda other: (F.least("block", other) * F.lit(blocks) + F.greatest("block", other)).cast("bigint"),
    )
    sent = traces.join(F.broadcast(places), "loop").withColumn("pair", F.explode(both))
    tasks = blocks * (blocks + 1) // 2
    of_block = [set(loops[k::blocks]) for k in range(blocks)]
    expected = _made_by()

    def compare(batches: Iterator[Any]) -> Iterator[Any]:
        import pyarrow as pa

        from stiction import _core

        _same(expected)
        for number, group in _groups(batches, "pair"):
            first, second = divmod(number, blocks)
            own = of_block[first] | of_block[second]
            told = [each for each in periods if each[0] in own]
            block = None if first == second else of_block[first]
            yield from pa.table(_core.plant_pairs(_traces(group), told, span, block)).to_batches()

    sent = sent.select("pair", "loop", *TRACE).repartition(tasks, "pair").sortWithinPartitions("pair")
    edges = sent.mapInArrow(compare, _core.plant_pairs_ddl()).persist()
    before = spark.conf.get(ROWS_A_BATCH)
    # A row has 17 kB, and a batch is transferred whole.
    spark.conf.set(ROWS_A_BATCH, "500")
    try:
        count = edges.count()
    finally:
        spark.conf.set(ROWS_A_BATCH, before)
    # Only a few of all pairs can count. Their maximum number follows from the number of pairs.
    while count > PAIRS_TOGETHER:
        edges_left = edges.where(F.col("p") <= _core.plant_most_that_counts(count, len(loops)))
        fewer = edges_left.count()
        if fewer == count:
            break
        count = fewer
    limit = _core.plant_most_that_counts(count, len(loops))
    kept = [row.asDict() for row in edges.where(F.col("p") <= limit).collect()]
    edges.unpersist()
    traces.unpersist()
    compared = [(row.loop, row.trace_start, row.trace_unit, row.digest) for row in seen]
    _core.plant_keep_pairs(name, of_week, pa.Table.from_pylist(kept, pa.schema(_core.plant_pairs_schema())), compared)
    return Pairs(
        week=of_week, loops=len(loops), blocks=blocks, compared=len(loops) * (len(loops) - 1) // 2, kept=len(kept)
    )


def _blocks(loops: int, cores: int) -> int:
    """The number of blocks that limits the size of each and keeps all cores busy."""
    blocks = -(-loops // LOOPS_A_BLOCK)
    while loops > LOOPS_A_BLOCK // 2 and blocks * (blocks + 1) < 4 * cores:
        blocks += 1
    return blocks


def _taken(folder: str, rows: Any) -> None:
    """Writes rows with traces to the store of a plant."""
    import pyarrow as pa
    import pyarrow.compute as pc

    def some(part: list[dict[str, Any]]) -> None:
        table = pa.Table.from_pylist(part, pa.schema([*schema(), *_trace_fields()]))
        take(folder, table, _traces(table.filter(pc.is_valid(table["trace_start"]))))

    part: list[dict[str, Any]] = []
    for row in rows.orderBy("loop", "window_start").toLocalIterator():
        part.append(row.asDict())
        if len(part) == TAKEN_TOGETHER:
            some(part)
            part = []
    if part:
        some(part)


def _session(of: argparse.Namespace) -> Any:
    from pyspark.sql import SparkSession

    builder = SparkSession.builder.appName("stiction")
    if of.master and of.master.startswith("sc:"):
        if of.wheel:
            raise ValueError("Spark Connect cannot send a wheel; install it in the Python of the server's executors")
        builder = builder.remote(of.master)
    elif of.master:
        builder = builder.master(of.master)
        if of.master.startswith("local"):
            # Otherwise Spark uses the first Python of the path, which may be a different one.
            os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
    if of.wheel:
        builder = builder.config("spark.archives", f"{of.wheel}#deps").config("spark.executorEnv.PYTHONPATH", "./deps")
    for setting in of.conf:
        name, _, value = setting.partition("=")
        builder = builder.config(name, value)
    # Pandas is not used here.
    warnings.filterwarnings("ignore", message="PySpark does not yet fully support pandas")
    spark = builder.getOrCreate()
    _quiet(spark)
    return spark


def _quiet(spark: Any) -> None:
    """Prevents stack traces in the log of Spark 4 for paths that are patterns or do not exist yet. These paths are no faults."""
    jvm = getattr(spark, "_jvm", None)
    if jvm is not None:
        log4j = jvm.org.apache.logging.log4j
        log4j.core.config.Configurator.setLevel("org.apache.spark.sql.execution.streaming", log4j.Level.ERROR)


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m stiction.plant.spark", description="Judge all loops of a plant, day by day, on Apache Spark."
    )
    parser.add_argument("--plant", required=True, metavar="DIR", help="the folder of plant.toml, whose store gets the rows")
    parser.add_argument("--output", required=True, metavar="PATH", help="where rows are written, by run, as Parquet")
    parser.add_argument("--input", nargs="*", metavar="PATH", help="data; by default the data named in plant.toml")
    parser.add_argument("--format", default="parquet", help="format of the data, such as delta [default: parquet]")
    parser.add_argument("--table", metavar="NAME", help="a table of the catalog instead of data")
    parser.add_argument("--since", metavar="DAY", help="judge windows from this day on, such as 2026-03-01")
    parser.add_argument("--loops", metavar="GLOB", help='judge only loops whose names match this pattern, such as "FIC*"')
    parser.add_argument(
        "--windows", type=int, metavar="N", help=f"write after about N windows [default: {WINDOWS_A_CORE} a core]"
    )
    parser.add_argument("--again", action="store_true", help="judge all windows again, not only new data")
    parser.add_argument(
        "--groups",
        nargs="?",
        const="",
        metavar="WEEK",
        help="after the scan, compare all loops of a week, such as 2026-W10 [default: the last], for the groups in its report",
    )
    parser.add_argument("--explain", action="store_true", help="show windows, partitions and bytes, without judging")
    parser.add_argument("--most-errors", type=float, default=MOST_ERRORS, metavar="SHARE", help="most loops with an error [default: 0.05]")
    parser.add_argument(
        "--master", metavar="URL", help="the cluster, unless spark-submit names it; sc://HOST:PORT is Spark Connect"
    )
    parser.add_argument("--wheel", metavar="FILE.zip", help="the wheel as a .zip, which is sent to the executors")
    parser.add_argument("--conf", action="append", default=[], metavar="NAME=VALUE", help="a setting of Spark")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Arguments; by default the arguments of the process.

    Returns
    -------
    int
        0, or 1 if the command failed or too many loops have an error. If too many loops have an error, all rows are written.
    """
    of = _arguments(arguments)
    try:
        return _run(of)
    except (RuntimeError, ValueError, OSError) as error:
        print(f"stiction: {error}", file=sys.stderr)
        return 1


def _run(of: argparse.Namespace) -> int:
    folder = Path(of.plant)
    data = of.input or [str(folder / pattern) for pattern in _plant(folder).data]
    spark = _session(of)
    try:
        df = spark.table(of.table) if of.table else spark.read.format(of.format).load(data)
        before = _known(spark, of.output)
        known = None if of.again else before
        if of.explain:
            plan = explain(df, folder, since=of.since, loops=of.loops, known=known)
            print(
                f"{plan.loops} loops, {plan.windows} windows to be judged, {plan.done} done; "
                f"{plan.partitions} partitions, {plan.samples} samples, {plan.bytes / 1e6:.0f} MB"
            )
            return 0
        run = 1 if before is None else 1 + (before.agg(F.max(F.col("run").cast("bigint"))).collect()[0][0] or 0)
        windows, errors = 0, 0
        wrong: frozenset[str] = frozenset()
        for done in _scans(df, folder, of.since, of.loops, known, of.windows or WINDOWS_A_CORE * _cores(spark)):
            if done.windows:
                # The store comes first. Rows in the output are not judged again, so they would never reach the store later.
                _taken(of.plant, done.rows)
                done.rows.write.mode("append").parquet(f"{of.output.rstrip('/')}/run={run:04}")
            windows, errors, wrong = windows + done.windows, errors + done.errors, wrong | done.loops_in_error
            print(f"{windows} of at most {done.plan.windows} windows were judged and written", file=sys.stderr)
        print(
            f"{windows} windows judged, {errors} of them with an error; {done.plan.loops} loops; "
            + (f"run {run:04}" if windows else "nothing was new")
        )
        if of.groups is not None:
            rows = _known(spark, of.output)
            if rows is None:
                raise ValueError(f"{of.output} has no rows of any run")
            found = pairs(rows, folder, week=of.groups or None)
            print(
                f"{found.compared} pairs of {found.loops} loops compared in {found.week}, "
                f"{found.kept} kept for the groups in the report of the week"
            )
        if len(wrong) > of.most_errors * done.plan.loops:
            words = f"{len(wrong)} of {done.plan.loops} loops have an error, more than {of.most_errors:.0%}"
            raise RuntimeError(f"{words}; all rows were written, and the column error has the reasons")
        return 0
    finally:
        spark.stop()


if __name__ == "__main__":
    sys.exit(main())
