"""Events of a plant: new conclusions on loops in the ranking.

The verdicts, changes and the health of the data come from the week's ranking. A loop has an event when two successive judgements
find a fault of the valve or the data. The loop has a second event when two successive judgements no longer find the fault.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from stiction.live.hours import live_folder

__all__: list[str] = []

KINDS = ("new sticking", "no response", "data dead", "repaired", "data back")
"""The kinds of events."""

DEAD = ("no data", "errors", "dead or frozen")
"""The name of the health of dead data."""
VALVE = {"sticks": "new sticking", "does not respond": "no response"}
"""The name of the event of each verdict."""

Reported = dict[str, dict[str, str]]


def path_of(plant: Path) -> Path:
    """Return the path of the file with all events of a plant, one line of JSON each."""
    return plant / ".stiction" / "events.jsonl"


def _verdict(row: Mapping[str, Any]) -> str | None:
    """Return the conclusion that counts: the conclusion of a person, the conclusion of a decisive test, or the verdict on the
    operation.
    """
    test = row["test"] if row["test"] != "cannot tell" else None
    chosen = row["override"] or test or row["verdict"]
    return None if chosen is None else str(chosen)


def derive(reported: Reported, rows: Iterable[Mapping[str, Any]], now: datetime | None = None) -> tuple[list[dict[str, Any]], Reported]:
    """Return the events of a ranking, and the updated reports on each loop."""
    at = (now or datetime.now(timezone.utc)).isoformat(timespec="seconds")
    events, after = [], {name: dict(each) for name, each in reported.items()}
    for row in rows:
        name, verdict = row["loop"], _verdict(row)
        known = after.setdefault(name, {})

        def event(kind: str, text: str, row: Mapping[str, Any] = row) -> None:
            keys = ("area", "unit", "grade", "probability", "S", "change", "change_day", "change_from", "change_to", "health", "until")
            events.append({"event": kind, "loop": row["loop"], "at": at, "text": text} | {key: row[key] for key in keys})

        def again(what: str, found: str | None) -> bool:
            """Return whether the previous judgement found this fault, too."""
            was = known.pop(f"{what} before", None)
            if found:
                known[f"{what} before"] = found
            return found is not None and found == was

        before = known.get("valve")
        accused = VALVE.get(verdict or "")
        if again("valve", accused) and accused and accused != before:
            known["valve"] = accused
            since = f", since {row['change_day']}" if row["change"] in ("new", "returned") and row["change_day"] else ""
            event(accused, f"{name}: the valve {row['grade'] or verdict}{since}")
        elif before and not accused and (row["change"] == "gone" or verdict == "does not stick"):
            del known["valve"]
            since = f" since {row['change_day']}" if row["change"] == "gone" and row["change_day"] else ""
            event("repaired", f"{name}: the valve no longer shows the fault{since}")
        dead = row["health"] in DEAD
        if again("data", "dead" if dead else None) and "data" not in known:
            known["data"] = str(row["health"])
            event("data dead", f"{name}: {row['health']}" + (f" ({row['error']})" if row["error"] else ""))
        elif not dead and known.pop("data", None) is not None:
            event("data back", f"{name}: the data are {row['health']}")
    return events, after


def load(plant: Path) -> Reported:
    """Return the reports on each loop so far."""
    try:
        found: Reported = json.loads((live_folder(plant) / "reported.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found


def keep(plant: Path, events: Iterable[Mapping[str, Any]], reported: Reported) -> None:
    """Append events to the file of events, and store the reports on each loop."""
    lines = "".join(json.dumps(event, ensure_ascii=False) + "\n" for event in events)
    if lines:
        with open(path_of(plant), "a", encoding="utf-8") as file:
            file.write(lines)
    path = live_folder(plant) / "reported.json"
    part = path.with_suffix(".part")
    part.write_text(json.dumps(reported, ensure_ascii=False), encoding="utf-8")
    part.replace(path)
