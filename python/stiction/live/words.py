"""Values of servers and databases as numbers, and counts in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

__all__: list[str] = []

WORDS = {
    "manual": 0.0,
    "man": 0.0,
    "m": 0.0,
    "auto": 1.0,
    "automatic": 1.0,
    "aut": 1.0,
    "a": 1.0,
    "cascade": 2.0,
    "cas": 2.0,
    "c": 2.0,
    "rcas": 2.0,
    "false": 0.0,
    "true": 1.0,
}
"""The numbers for words in tags of modes, as listed in docs/recordings.md."""


def number_of(content: Any, modes: Mapping[str, float]) -> float:
    """The number for a value, or NaN for a value without a number. `modes` are the mode words of a plant."""
    if isinstance(content, str):
        word = content.strip().lower()
        if word in modes or word in WORDS:
            return modes.get(word, WORDS.get(word, math.nan))
        content = word
    try:
        number = float(content)
    except (TypeError, ValueError):
        return math.nan
    return number if math.isfinite(number) else math.nan


def counted(count: int, what: str) -> str:
    """A number of things, such as "1 day" or "2 days"."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
