"""Recorded values, in files of one hour each.

A collector appends each value to the *journal* of its hour, a file in ``.stiction/live/open`` of the plant. When the hour is
over, the journal moves to ``.stiction/live/ready``. `fold` writes the values to ``data/YYYY-MM-DD/HH.parquet`` (UTC), whole or
not at all, and removes the journal. Values that arrive later for that hour make another journal, with which the file is written
again. A second file of an hour is not possible, because the scan refuses files of one loop whose times interleave.

A file of an hour is a long table: ``time`` (UTC), ``tag``, ``value``, ``status_code`` (OPC UA). The file has one row group per tag,
so that a scan reads only the necessary loops. Every tag of the collector is in every file. A tag without a value in the hour has
a held value at the start of the hour (`HELD`), or no value (`NONE`). Where values may be missing, a row without a value marks the
start of the gap (`LOST`), so that no value is held across the gap.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import struct
import sys
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

from stiction.live.errors import Refused

__all__: list[str] = []

HOUR = 3_600_000_000
"""Microseconds of an hour. Times are microseconds since 1970-01-01 UTC."""
GOOD = 0
BAD = 0x8000_0000
"""A status code from here on has no usable value."""
HELD = 0x402
"""The status code of a good value that was stored earlier and was still valid at this time (interpolated)."""
LOST = 0x809D_0000
"""The status code at the start of a gap: data were lost, because collection stopped (BadDataLost)."""
NONE = 0x809B_0000
"""The status code of a tag that has no value in an hour (BadNoData)."""
MARK = 0xFFFF_FFFF
"""The tag of a record without a value, which states the time up to which all values are known. The value of such a record is the
number of the record. The record with the highest number counts, because a clock may go back.
"""
VOID = 1
"""The status of a record of the tag `MARK` that invalidates earlier values in its journal with the same time or a later time."""
LEAD = 600_000_000
"""Microseconds by which values may be ahead of the server's clock."""
MOST_ROWS = 2_000_000
"""Maximum number of rows in memory while an hour is written."""
MOST_BUFFERED = 1 << 20
"""Maximum size of the data that wait for a write, bytes."""
MOST_OPEN = 16
"""Maximum number of journals that are open at a time."""

RECORD = np.dtype([("tag", "<u4"), ("status", "<u4"), ("time", "<i8"), ("value", "<f8")])
PACK = struct.Struct("<IIqd").pack
Records: TypeAlias = "npt.NDArray[Any]"


def live_folder(plant: Path) -> Path:
    """The collector's own folder in a plant."""
    return plant / ".stiction" / "live"


def hour_of(time: int) -> int:
    """The start of the hour that contains a time."""
    return time - time % HOUR


def moment(time: int) -> datetime:
    """A time as a date with a time zone."""
    return datetime.fromtimestamp(time // 1_000_000, timezone.utc).replace(microsecond=time % 1_000_000)


def shown(time: int) -> str:
    """A time as text, to the second."""
    return moment(time).strftime("%Y-%m-%d %H:%M:%S")


def hour_file(data: Path, hour: int) -> Path:
    """The file of the hour that begins at this time."""
    at = moment(hour)
    return data / at.strftime("%Y-%m-%d") / at.strftime("%H.parquet")


def _journal_hour(path: Path) -> int:
    at = datetime.strptime(path.name.partition(".")[0], "%Y-%m-%dT%H").replace(tzinfo=timezone.utc)
    return int(at.timestamp()) * 1_000_000


def _sync_folder(folder: Path) -> None:
    """Makes the names in a folder durable, if the system can."""
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextlib.contextmanager
def alone(plant: Path, name: str, refusal: str) -> Iterator[None]:
    """Holds a lock of a plant, which the system releases if the process is killed."""
    folder = live_folder(plant)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / name, "a") as file:
        try:
            if sys.platform == "win32":
                import msvcrt

                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            else:
                import fcntl

                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise Refused(refusal) from None
        yield


class Recorder:
    """Appends each value to the journal of an hour."""

    def __init__(self, plant: Path, tags: Sequence[str]) -> None:
        self.folder = live_folder(plant)
        self.open, self.ready = self.folder / "open", self.folder / "ready"
        self.open.mkdir(parents=True, exist_ok=True)
        self.ready.mkdir(exist_ok=True)
        numbers = [int(path.name.split(".")[1]) for path in _journals(self.open, self.ready)]
        self.run = 1 + max(numbers, default=0)
        self._header = json.dumps({"format": 1, "tags": list(tags)}).encode()
        self._files: OrderedDict[int, BinaryIO] = OrderedDict()
        self._lengths: dict[int, int] = {}
        self._waiting: dict[int, bytearray] = {}
        self._bytes = 0
        self.values = 0
        self.sequence = 0

    def add(self, tag: int, time: int, value: float, status: int) -> None:
        """Append a value. `flush` writes it."""
        hour = time - time % HOUR
        waiting = self._waiting.get(hour)
        if waiting is None:
            waiting = self._waiting[hour] = bytearray()
        waiting += PACK(tag, status, time, value)
        self._bytes += RECORD.itemsize
        self.values += 1
        if self._bytes >= MOST_BUFFERED:
            self.flush()

    def mark(self, time: int) -> None:
        """Record that all values up to a time are known."""
        self.sequence += 1
        self.add(MARK, time, float(self.sequence), 0)
        self.values -= 1

    def void(self, begin: int) -> None:
        """Void the values from a time on, because a wrong clock gave these times."""
        self.sequence += 1
        self.flush()
        record = PACK(MARK, VOID, begin, float(self.sequence))
        # Earlier runs may have written some of them.
        for path in _journals(self.open):
            if _journal_hour(path) + HOUR > begin:
                rest = (path.stat().st_size - _read_head(path)[1]) % RECORD.itemsize
                with open(path, "ab", buffering=0) as file:
                    file.truncate(path.stat().st_size - rest)
                    _write(file, record)
        self._forget()

    def flush(self, durable: bool = False) -> None:
        """Write the waiting values. An error, such as a full disk, loses these values but leaves the journals intact."""
        waiting, self._waiting, self._bytes = self._waiting, {}, 0
        for hour, values in waiting.items():
            try:
                file = self._file(hour)
                _write(file, values)
                if durable:
                    os.fsync(file.fileno())
            except OSError:
                self._cut(hour)
                raise
            self._lengths[hour] += len(values)

    def _file(self, hour: int) -> BinaryIO:
        file = self._files.get(hour)
        if file is None:
            name = f"{moment(hour):%Y-%m-%dT%H}.{self.run:06d}.values"
            path = self.open / name
            file = open(path, "ab", buffering=0)  # noqa: SIM115
            self._files[hour] = file
            self._lengths[hour] = file.seek(0, os.SEEK_END)
            if self._lengths[hour] == 0:
                head = len(self._header).to_bytes(8, "little") + self._header
                _write(file, head)
                self._lengths[hour] = len(head)
            while len(self._files) > MOST_OPEN:
                oldest, other = self._files.popitem(last=False)
                other.close()
                self._lengths.pop(oldest, None)
        self._files.move_to_end(hour)
        return file

    def _cut(self, hour: int) -> None:
        """Removes a half-written record, and forgets the file. Later values begin another journal."""
        self.run += 1
        file, length = self._files.pop(hour, None), self._lengths.pop(hour, 0)
        if file is None:
            return
        try:
            file.truncate(length)
        except OSError:
            pass  # `fold` ignores a partial record at the end.
        file.close()

    def release(self, before: int) -> int:
        """Hand over the journals of all hours that end by this time, and return the number of journals."""
        count = 0
        for path in _journals(self.open):
            hour = _journal_hour(path)
            if hour + HOUR > before or hour in self._waiting:
                continue
            file = self._files.pop(hour, None)
            if file is not None:
                os.fsync(file.fileno())
                file.close()
                self._lengths.pop(hour, None)
            os.replace(path, self.ready / path.name)
            count += 1
        if count:
            # A later value of the same hour begins another journal.
            self.run += 1
            _sync_folder(self.ready)
        return count

    def close(self) -> None:
        """Write everything, durably, and close the journals."""
        try:
            self.flush(durable=True)
        finally:
            self._forget()

    def _forget(self) -> None:
        """Closes the journals. The next value opens a journal again."""
        for file in self._files.values():
            file.close()
        self._files.clear()
        self._lengths.clear()


_JOURNAL = re.compile(r"[0-9]{4}-(0[1-9]|1[0-2])-([0-2][0-9]|3[01])T([01][0-9]|2[0-3])\.[0-9]{1,12}\.values")
"""The names of journals. Other files in the folders are ignored."""


def _write(file: BinaryIO, data: bytes | bytearray) -> None:
    """Writes all bytes. A disk that becomes full may accept only some values."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def _journals(*folders: Path) -> list[Path]:
    return sorted(path for folder in folders if folder.is_dir() for path in folder.glob("*.values") if _is_journal(path))


def _is_journal(path: Path) -> bool:
    try:
        return _JOURNAL.fullmatch(path.name) is not None and _journal_hour(path) >= 0
    except ValueError:
        # Such as 31 February.
        return False


def _read_head(path: Path) -> tuple[list[str], int]:
    """Return the tags of a journal and the offset of the first record, or no tags if the head is incomplete."""
    with open(path, "rb") as file:
        length = int.from_bytes(file.read(8), "little")
        head = file.read(length) if length <= 1 << 28 else b""
    try:
        return json.loads(head)["tags"], 8 + length
    except (ValueError, KeyError, TypeError):
        return [], 8 + length


def _blocks(path: Path, begin: int, rows: int = 1 << 18) -> Iterator[Records]:
    """The complete records of a journal, in blocks, without records of other hours, which a damaged file may have."""
    hour = _journal_hour(path)
    with open(path, "rb") as file:
        file.seek(begin)
        while data := file.read(rows * RECORD.itemsize):
            block = np.frombuffer(data, RECORD, len(data) // RECORD.itemsize)
            own = (block["time"] >= hour) & (block["time"] < hour + HOUR)
            if not own.all():
                block = block[own | ((block["tag"] == MARK) & (block["status"] == VOID))]
            yield block


@dataclass
class Known:
    """The content of the journals."""

    until: int | None = None
    """The time up to which the journals contain all values; None without a journal."""
    last: dict[str, int] = field(default_factory=dict)
    """The last time of each tag."""
    sequence: int = 0
    """The highest number of the records with the tag `MARK`."""
    lost: dict[str, int] = field(default_factory=dict)
    """The time of the last row of each tag whose last row begins a gap (`LOST`)."""


def known(plant: Path, before: int = 1 << 62) -> Known:
    """Return the content of the journals up to a time. Later values may exist if a clock was wrong."""
    folder = live_folder(plant)
    found = Known()
    newest = (-1.0, -(1 << 62))
    for path in _journals(folder / "open", folder / "ready"):
        tags, begin = _read_head(path)
        if not tags:
            continue
        own, lost = np.full((2, len(tags) + 1), -(1 << 62), np.int64)
        for block in _blocks(path, begin):
            marks = block[(block["tag"] == MARK) & (block["status"] == 0)]
            numbers = np.nan_to_num(marks["value"], nan=0.0)
            found.sequence = max(found.sequence, int(numbers.max(initial=0.0)))
            within = marks["time"] <= before
            newest = max([newest, *zip(numbers[within].tolist(), marks["time"][within].tolist())])
            block = block[block["time"] <= before]
            np.maximum.at(own, np.minimum(block["tag"], len(tags)), block["time"])
            block = block[block["status"] == LOST]
            np.maximum.at(lost, np.minimum(block["tag"], len(tags)), block["time"])
        for tag, time, gap in zip(tags, own, lost):
            if time > found.last.get(tag, -(1 << 62)):
                found.last[tag] = int(time)
                found.lost.pop(tag, None)
                if gap == time:
                    found.lost[tag] = int(gap)
    if newest[0] >= 0.0:
        found.until = int(newest[1])
        # What is later was dated by a clock that went back since.
        found.last = {tag: min(at, found.until + LEAD) for tag, at in found.last.items()}
    return found


@dataclass
class Rows:
    """The values of a tag in order of time."""

    time: npt.NDArray[np.int64]
    value: npt.NDArray[np.float64]
    status: npt.NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.time)


@dataclass
class Folded:
    """An hour that was written."""

    hour: int
    rows: int
    problems: list[str] = field(default_factory=list)


def _schema() -> Any:
    import pyarrow as pa

    return pa.schema(
        [
            ("time", pa.timestamp("us", tz="UTC")),
            ("tag", pa.string()),
            ("value", pa.float64()),
            ("status_code", pa.uint32()),
        ]
    )


def table_of(tag: str, rows: Rows) -> Any:
    """The rows of a tag as an Arrow table. A value with a bad status is empty."""
    import pyarrow as pa

    empty = np.isnan(rows.value) | (rows.status >= BAD)
    tags = pa.DictionaryArray.from_arrays(pa.array(np.zeros(len(rows), np.int32)), pa.array([tag]))
    columns = [
        pa.array(rows.time, pa.timestamp("us", tz="UTC")),
        tags.cast(pa.string()),
        pa.array(rows.value, pa.float64(), mask=empty),
        pa.array(rows.status, pa.uint32()),
    ]
    return pa.Table.from_arrays(columns, schema=_schema())


def written(path: Path, tables: Iterator[Any], is_new: Callable[[], bool] = lambda: True) -> int:
    """Write tables as one Parquet file, each as a row group, whole or not at all, and return the number of rows.

    A file stays unchanged if `is_new` finds, after all tables, that the tables contain nothing new.
    """
    import pyarrow.parquet as pq

    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.part")
    rows = 0
    try:
        with open(part, "wb") as file:
            with pq.ParquetWriter(
                file,
                _schema(),
                compression="zstd",
                use_dictionary=["tag", "status_code"],
                column_encoding={"time": "DELTA_BINARY_PACKED"},
            ) as writer:
                for table in tables:
                    if len(table):
                        writer.write_table(table, row_group_size=max(1, len(table)))
                        rows += len(table)
            file.flush()
            os.fsync(file.fileno())
        if not is_new():
            part.unlink()
            return rows
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    _sync_folder(path.parent)
    return rows


def tables_by_tag(path: Path) -> Iterator[tuple[str, Rows]]:
    """The rows of each tag of a file that `written` wrote, one tag at a time."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        for group in range(file.num_row_groups):
            table = file.read_row_group(group)
            if len(table):
                yield table["tag"][0].as_py(), _rows(table)


def _rows(table: Any) -> Rows:
    import pyarrow as pa

    time = table["time"].cast(pa.int64()).to_numpy()
    value = table["value"].to_numpy(zero_copy_only=False).astype(np.float64)
    return Rows(time, value, table["status_code"].to_numpy().astype(np.uint32))


class Stored:
    """The rows of a file by tag. The rows of a tag are read when requested."""

    def __init__(self, path: Path) -> None:
        import pyarrow.parquet as pq

        self.path = path
        self.file: Any = None
        self.groups: dict[str, int] = {}
        if path.exists():
            self.file = pq.ParquetFile(path)
            place = self.file.schema_arrow.get_field_index("tag")
            for group in range(self.file.num_row_groups):
                # A row group holds one tag, so its statistics state it, unless it is very long.
                known = self.file.metadata.row_group(group).column(place).statistics
                tag = known.min if known is not None and known.has_min_max and len(known.min) < 1000 else None
                self.groups[tag or self.file.read_row_group(group, ["tag"])["tag"][0].as_py()] = group

    def __enter__(self) -> Stored:
        return self

    def __exit__(self, *_: object) -> None:
        if self.file is not None:
            self.file.close()

    def rows(self, tag: str) -> Rows | None:
        """The rows of a tag; None for a tag without rows."""
        group = self.groups.get(tag)
        return None if group is None else _rows(self.file.read_row_group(group))


def joined(parts: Sequence[Rows]) -> Rows:
    """The rows of parts in order of time, without duplicates. If a usable value and a bad value have one time, the bad value is
    left out.
    """
    time = np.concatenate([part.time for part in parts])
    value = np.concatenate([part.value for part in parts])
    status = np.concatenate([part.status for part in parts])
    order = np.argsort(time, kind="stable")
    time, value, status = time[order], value[order], status[order]
    keep = np.ones(len(time), bool)
    # Almost always each time occurs once.
    again = np.flatnonzero(time[1:] == time[:-1])
    last = -1
    for first in again.tolist():
        if first <= last:
            continue
        last = first + 1
        while last + 1 < len(time) and time[last + 1] == time[first]:
            last += 1
        group = range(first, last + 1)
        usable = any(status[k] < BAD for k in group)
        seen = set()
        for k in group:
            bad = bool(status[k] >= BAD)
            key = (None if bad else value[k].tobytes(), int(status[k]))
            keep[k] = key not in seen and not (bad and usable)
            seen.add(key)
    return Rows(time[keep], value[keep], status[keep])


def fold(plant: Path, data: Path) -> list[Folded]:
    """Write all ready journals to the files of their hours, the oldest first, and remove the journals."""
    for part in data.glob("[0-9]*/.[0-9][0-9].parquet.part"):
        # A run that was killed left it.
        part.unlink(missing_ok=True)
    ready = live_folder(plant) / "ready"
    by_hour: dict[int, list[Path]] = {}
    for path in _journals(ready):
        by_hour.setdefault(_journal_hour(path), []).append(path)
    done = []
    for hour, journals in sorted(by_hour.items()):
        folded, changed = _fold_hour(data, hour, journals)
        done.append(folded)
        for path in journals:
            path.unlink()
        # Values that arrived late may change those that later hours hold.
        while changed and hour + HOUR not in by_hour and hour_file(data, hour + HOUR).exists():
            hour += HOUR
            _, changed = _fold_hour(data, hour, [])
    return done


def _fold_hour(data: Path, hour: int, journals: Sequence[Path]) -> tuple[Folded, bool]:
    """Writes the file of an hour, and returns whether the rows changed."""
    folded = Folded(hour, 0)
    heads = [_read_head(path) for path in journals]
    for path, (tags, begin) in zip(journals, heads):
        rest = (path.stat().st_size - begin) % RECORD.itemsize
        if not tags or rest:
            folded.problems.append(f"the journal {path.name} ends within a record, which was left out")
        elif strange := (path.stat().st_size - begin) // RECORD.itemsize - sum(map(len, _blocks(path, begin))):
            folded.problems.append(f"the journal {path.name} is damaged: records with times of other hours were left out ({strange})")
    path = hour_file(data, hour)
    with Stored(path) as stored, Stored(hour_file(data, hour - HOUR)) as before:
        names = sorted({tag for tags, _ in heads for tag in tags} | stored.groups.keys() | before.groups.keys())
        if not names:
            return folded, False
        changed = not path.exists()
        differ: list[str] = []

        def tables() -> Iterator[Any]:
            nonlocal changed
            for batch, own in _batches(names, journals, heads):
                for tag in batch:
                    known, new = stored.rows(tag), own.get(tag)
                    if known is not None and new is not None and differing(known, new):
                        differ.append(tag)
                    rows = _of_hour(hour, known, new, lambda tag=tag: before.rows(tag))
                    changed = changed or known is None or not same(known, rows)
                    yield table_of(tag, rows)

        if not journals:
            # Only the held values may have changed; most often they have not.
            for _ in tables():
                pass
            if not changed:
                return folded, False
        folded.rows = written(path, tables())
    if differ:
        some = f"{', '.join(differ[:3])}{', ...' if len(differ) > 3 else ''}"
        folded.problems.append(f"{shown(hour)}: values that arrived later differ from stored values of the same times; both are kept ({some})")
    return folded, changed


def differing(known: Rows, new: Rows) -> int:
    """The number of times at which both series have usable values, but the new values lack a known value. Held values do not
    count.
    """
    old, usable = (known.status < BAD) & (known.status & 0xFFF != HELD), new.status < BAD
    old[old] = np.isin(known.time[old], new.time[usable])
    if not old.any():
        return 0
    # Of several values of one time, any may be the same.
    pairs = set(zip(new.time[usable].tolist(), new.value[usable].tolist()))
    return len({time for time, value in zip(known.time[old].tolist(), known.value[old].tolist()) if (time, value) not in pairs})


def same(a: Rows, b: Rows) -> bool:
    """Return whether two series are equal."""
    return (
        len(a) == len(b)
        and bool(np.array_equal(a.time, b.time))
        and bool(np.array_equal(a.status, b.status))
        and bool(np.array_equal(a.value, b.value, equal_nan=True))
    )


def _of_hour(hour: int, known: Rows | None, new: Rows | None, before: Any) -> Rows:
    """The rows of a tag in an hour. Without rows, the last earlier value of the tag, as held."""
    parts = []
    if known is not None:
        # What was held at the start is found again.
        own = ~((known.time == hour) & ((known.status == NONE) | (known.status & 0xFFF == HELD)))
        parts.append(Rows(known.time[own], known.value[own], known.status[own]))
    if new is not None:
        parts.append(new)
    rows = joined(parts) if parts else Rows(np.empty(0, np.int64), np.empty(0), np.empty(0, np.uint32))
    if len(rows):
        return rows
    last: Rows | None = before()
    value, status = np.nan, NONE
    if last is not None and last.status[-1] < BAD:
        value, status = float(last.value[-1]), int(last.status[-1]) & 0xC000_0000 | HELD
    return Rows(np.array([hour], np.int64), np.array([value]), np.array([status], np.uint32))


def _batches(
    names: Sequence[str], journals: Sequence[Path], heads: Sequence[tuple[list[str], int]]
) -> Iterator[tuple[list[str], Mapping[str, Rows]]]:
    """The tags in order, in batches, each tag with the rows in the journals."""
    place = {tag: k for k, tag in enumerate(names)}
    # From the numbers of a journal to those of the names.
    maps = [np.array([place[tag] for tag in tags] + [len(names)], np.int64) for tags, _ in heads]
    counts = np.zeros(len(names) + 1, np.int64)

    # Where a journal takes back what it holds, and from which time on.
    voids: dict[Path, list[tuple[int, int]]] = {}

    def blocks() -> Iterator[tuple[npt.NDArray[np.int64], Records]]:
        for path, (tags, begin), to in zip(journals, heads, maps):
            position = 0
            for block in _blocks(path, begin) if tags else ():
                size = len(block)
                if path in voids:
                    gone = np.zeros(size, bool)
                    for until, time in voids[path]:
                        gone |= (position + np.arange(size) < until) & (block["time"] >= time)
                    block = block[~gone]
                position += size
                yield to[np.minimum(block["tag"], len(to) - 1)], block

    for path, (tags, begin), to in zip(journals, heads, maps):
        position = 0
        for block in _blocks(path, begin) if tags else ():
            counts += np.bincount(to[np.minimum(block["tag"], len(to) - 1)], minlength=len(counts))
            for k in np.flatnonzero((block["tag"] == MARK) & (block["status"] == VOID)).tolist():
                voids.setdefault(path, []).append((position + k, int(block["time"][k])))
            position += len(block)
    first = 0
    while first < len(names):
        until, rows = first, 0
        while until < len(names) and (until == first or rows + counts[until] <= MOST_ROWS):
            rows += int(counts[until])
            until += 1
        parts = []
        for own, block in blocks():
            within = (own >= first) & (own < until)
            if within.any():
                parts.append((own[within], block[within]))
        found: dict[str, Rows] = {}
        if parts:
            own = np.concatenate([part[0] for part in parts])
            block = np.concatenate([part[1] for part in parts])
            order = np.argsort(own, kind="stable")
            edges = np.searchsorted(own[order], np.arange(first, until + 1))
            for k in range(until - first):
                chosen = block[order[edges[k] : edges[k + 1]]]
                if len(chosen):
                    rows_of = Rows(chosen["time"].copy(), chosen["value"].copy(), chosen["status"].copy())
                    found[names[first + k]] = joined([rows_of])
        yield list(names[first:until]), found
        first = until


def steady(plant: Path, server: int, computer: int) -> int:
    """The time from which the age of files is counted, chosen so that a jumping clock removes no file.

    The time is from the server's clock, but never ahead of this computer's clock. Between calls the time advances at most twice
    as fast as this computer's clock.
    """
    path = live_folder(plant) / "retention.json"
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        newest, at = int(stored["now"]), int(stored["computer"])
    except (OSError, ValueError, KeyError, TypeError):
        ends = [hour + HOUR for hour in map(_file_hour, _hour_files(plant / "data")) if hour + HOUR <= min(server, computer)]
        newest, at = max(ends, default=min(server, computer)), computer
    allowed = newest + 2 * max(0, computer - at)
    now = min(server, computer, allowed)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(json.dumps({"now": max(now, newest), "computer": computer}), encoding="utf-8")
    part.replace(path)
    return now


def _hour_files(data: Path) -> list[Path]:
    files = data.glob("[0-9][0-9][0-9][0-9]-[0-9][0-9]-[0-9][0-9]/[0-9][0-9].parquet")
    return sorted(path for path in files if _HOUR_FILE.fullmatch(f"{path.parent.name}/{path.name}"))


_HOUR_FILE = re.compile(r"[0-9]{4}-(0[1-9]|1[0-2])-([0-2][0-9]|3[01])/([01][0-9]|2[0-3])\.parquet")


def _file_hour(path: Path) -> int:
    """The start of the hour of a file."""
    at = datetime.strptime(f"{path.parent.name}T{path.stem}", "%Y-%m-%dT%H").replace(tzinfo=timezone.utc)
    return int(at.timestamp()) * 1_000_000


def retain(data: Path, *, keep_s: float | None, most_bytes: float | None, now: int) -> list[Path]:
    """Remove the oldest files of hours, by age and by total size, and return the removed files."""
    files = _hour_files(data)
    sizes = {path: path.stat().st_size for path in files}
    total, removed = sum(sizes.values()), []
    for path in files:
        age = (now - _file_hour(path) - HOUR) / 1e6
        if not ((keep_s is not None and age > keep_s) or (most_bytes is not None and total > most_bytes)):
            break
        path.unlink()
        removed.append(path)
        total -= sizes[path]
        if not any(path.parent.iterdir()):
            shutil.rmtree(path.parent)
    return removed
