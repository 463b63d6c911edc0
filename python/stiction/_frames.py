"""Data frames. Pandas is imported only when a data frame is requested."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

__all__: list[str] = []


def frame(columns: Mapping[str, Any], index: str | None = None) -> Any:
    """Return columns as a pandas data frame, with the column `index` as the index."""
    try:
        import pandas  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise ImportError("data frames need pandas: pip install stiction[pandas]") from None
    made = pandas.DataFrame(dict(columns))
    return made if index is None else made.set_index(index)


def rows(columns: Mapping[str, Sequence[Any]]) -> Iterator[dict[str, Any]]:
    """Return the rows of columns as dictionaries."""
    return (dict(zip(columns, row)) for row in zip(*columns.values()))
