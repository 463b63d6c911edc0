"""The files of fetched days: ``data/sql/SOURCE/YYYY-MM-DD.parquet``, one folder for each table or server.

The file of a day only grows. Rows that a source no longer has stay in the file. If a source has different values for known times,
the new values replace the stored values, with a note.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stiction.live import hours

__all__: list[str] = []


def folder_of(plant: Path, name: str) -> Path:
    """Return the folder of a source."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip(".-")[:60]
    if plain != name:
        # Names that differ have folders that differ.
        plain = f"{plain or 'table'}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"
    return plant / "data" / "sql" / plain


def begin(folder: Path, tags: Iterable[str]) -> None:
    """Prepare the folder of a source while no other run writes to the folder. Partial files of killed runs are removed. Files of
    days by earlier versions, which had one folder for all sources, are moved here.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for each in (folder, folder.parent):
        for part in each.glob(".*.parquet.part"):
            part.unlink(missing_ok=True)
    own = set(tags)
    for path in sorted(folder.parent.glob("[0-9]*.parquet")):
        try:
            stored = {tag for tag, _ in hours.tables_by_tag(path)}
        except (OSError, ValueError, KeyError):
            continue  # Not a file of ours.
        if stored and stored <= own and not (folder / path.name).exists():
            os.replace(path, folder / path.name)


def add(path: Path, new: Iterable[tuple[str, hours.Rows]], note: Callable[[str], None]) -> int:
    """Add the rows of a day to the file of the day, and return the number of rows that the source gave. Without rows the file
    stays unchanged.
    """
    count = 0
    changed: dict[str, int] = {}
    fresh = False

    def tables() -> Iterator[Any]:
        nonlocal count, fresh
        done = set()
        with hours.Stored(path) as stored:
            for tag, rows in new:
                done.add(tag)
                count += len(rows)
                known = stored.rows(tag)
                if known is not None:
                    whole, differ = merged(known, rows)
                    if differ:
                        changed[tag] = differ
                    fresh = fresh or not hours.same(known, whole)
                    rows = whole
                else:
                    fresh = fresh or bool(len(rows))
                yield hours.table_of(tag, rows)
            for tag in stored.groups:
                if tag not in done:
                    known = stored.rows(tag)
                    assert known is not None
                    yield hours.table_of(tag, known)

    hours.written(path, tables(), lambda: fresh)
    for tag, differ in list(changed.items())[:5]:
        some = "1 value differs" if differ == 1 else f"{differ} values differ"
        note(f"{path.parent.name} {path.stem}: {some} from those fetched before for {tag}; the new ones are stored")
    if len(changed) > 5:
        note(f"{path.parent.name} {path.stem}: values of {len(changed) - 5} more tags also differ")
    return count


def merged(known: hours.Rows, new: hours.Rows) -> tuple[hours.Rows, int]:
    """Return the rows of a file and the rows of a source as one series, and the number of times with different values."""
    kept = ~np.isin(known.time, new.time[new.status < hours.BAD])
    rest = hours.Rows(known.time[kept], known.value[kept], known.status[kept])
    return hours.joined([rest, new]), hours.differing(known, new)
