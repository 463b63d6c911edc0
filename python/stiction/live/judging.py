"""Writes finished hours to files and judges the hours. The judgement runs in a separate process, so that collection never waits
for the judgement.

``python -m stiction.live.judging`` reads settings as JSON from standard input, and prints the result as JSON.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any

__all__: list[str] = []


def judge(
    plant: Path, data: Path, *, keep_s: float | None, most_bytes: float | None, now: int, time_limit_s: int | None = None
) -> dict[str, Any]:
    """Write ready hours, remove old files, scan, and derive events."""
    import stiction.plant
    from stiction.live import events, hours

    begun = time.monotonic()
    folded = hours.fold(plant, data)
    age_from = hours.steady(plant, now, time.time_ns() // 1000)
    removed = hours.retain(data, keep_s=keep_s, most_bytes=most_bytes, now=age_from)
    written = time.monotonic()
    found: dict[str, Any] = {
        "hours": [hours.shown(each.hour) for each in folded],
        "rows": sum(each.rows for each in folded),
        "removed": [str(path.relative_to(data)) for path in removed],
        "notes": [note for each in folded for note in each.problems],
        "events": [],
        "words": {},
        "unknown": {},
        "windows": 0,
    }
    done = stiction.plant.scan(plant, time_limit_s=time_limit_s)
    found["windows"] = done.windows
    problems = [problem.message for problem in done.problems if problem.file or problem.loop is None]
    found["notes"] += problems[:5] + ([f"{len(problems) - 5} more files have problems"] if len(problems) > 5 else [])
    try:
        rows = list(_rows(stiction.plant.ranking(plant).to_dict()))
    except ValueError:
        rows = []  # Nothing was judged so far.
    new, reported = events.derive(events.load(plant), rows)
    events.keep(plant, new, reported)
    words: dict[str, int] = {}
    unknown = {"window not judged": 0}
    for row in rows:
        word = row["grade"] or "not judged"
        words[word] = words.get(word, 0) + 1
        unknown["window not judged"] += row["windows"] - row["windows_judged"]
    for each in done.unknown:
        if each.kind != "window not judged":
            unknown[each.kind] = unknown.get(each.kind, 0) + each.count
    found |= {"events": new, "words": words, "unknown": unknown, "loops": len(rows)}
    return found | {"write_s": round(written - begun, 3), "scan_s": round(time.monotonic() - written, 3)}


def _rows(columns: dict[str, list[Any]]) -> Any:
    return (dict(zip(columns, row)) for row in zip(*columns.values()))


def main() -> int:
    """Run the judgement, as the module describes."""
    settings = json.load(sys.stdin)
    if hasattr(os, "nice"):
        os.nice(10)
    try:
        plant, data = Path(settings.pop("plant")), Path(settings.pop("data"))
        found = judge(plant, data, **settings)
    except Exception as error:
        print(json.dumps({"error": f"{type(error).__name__}: {error}"}))
        return 1
    print(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
