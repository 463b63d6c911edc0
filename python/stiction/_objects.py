"""Converts frames of pandas and columns of objects for the library."""

from __future__ import annotations

from collections import Counter
from datetime import timedelta
from decimal import Decimal
from typing import Any

import numpy as np

from stiction._arrays import Array

_NUMBERS = (int, float, Decimal, np.integer, np.floating)


def plain_frame(frame: Any) -> Any:
    """Return a pandas frame with the index as a column, plain names, and columns without objects."""
    index = frame.index
    kind = getattr(index.dtype, "kind", "")
    if hasattr(index, "to_timestamp") and not hasattr(index, "tz"):
        frame = frame.set_axis(index.to_timestamp())
        index, kind = frame.index, "M"
    if index.nlevels > 1:
        frame = frame.reset_index()
    elif kind == "m":
        # Its unit is certain.
        name = f"{index.name or 'time'} [s]"
        frame = frame.reset_index(drop=True)
        frame.insert(0, name, np.asarray(index.total_seconds(), dtype=np.float64))
    elif kind == "M" or hasattr(index, "tz"):
        frame = _with_index(frame, index.name or "time")
    elif type(index).__name__ != "RangeIndex":
        is_text = index.dtype == object or str(index.dtype).startswith("str")
        frame = _with_index(frame, index.name or ("time" if is_text else "index"))
    else:
        frame = frame.copy(deep=False)
    frame.columns = [_joined(name) for name in frame.columns]
    # The name that reset_index() gives to an index of times.
    kinds = dict(zip(frame.columns, (dtype.kind for dtype in frame.dtypes)))
    if kinds.get("index") in ("m", "M") and "time" not in kinds:
        frame = frame.rename(columns={"index": "time"})
    twice = [name for name, count in Counter(frame.columns).items() if count > 1]
    if twice:
        raise ValueError(f"table has {Counter(frame.columns)[twice[0]]} columns named {twice[0]!r}; rename them")
    for name in frame.columns:
        column = frame[name]
        if column.dtype == object:
            frame[name] = _series(column)
        elif column.dtype.kind == "m":
            frame[name] = column.dt.total_seconds()
    return frame


def _with_index(frame: Any, name: Any) -> Any:
    """Return a frame with the index as the column called `name`."""
    if name in frame.columns:
        raise ValueError(f"table has a column and an index named {str(name)!r}; rename one")
    return frame.reset_index(names=name)


def _joined(name: Any) -> str:
    """Return the name of a column as text, with dots between levels if the name has several."""
    return ".".join(str(part) for part in name if str(part)) if isinstance(name, tuple) else str(name)


def _series(column: Any) -> Any:
    """Return a series of objects as numbers or text."""
    plain = plain_objects(column.tolist())
    return np.asarray(plain, dtype=np.float64) if isinstance(plain, np.ndarray) else plain


def _is_null(value: Any) -> bool:
    # NaN, NaT and NaN as Decimal differ from themselves; pandas.NA gives no answer.
    return value is None or type(value).__name__ in ("NAType", "NaTType") or bool(value != value)


def plain_objects(values: list[Any]) -> Array | list[str]:
    """Return objects as numbers if all are numbers, else as text with an empty string for null."""
    values = [None if _is_null(value) else value for value in values]
    present = [value for value in values if value is not None]
    if present and all(isinstance(value, timedelta) for value in present):
        return np.array([np.nan if value is None else value.total_seconds() for value in values])
    if all(isinstance(value, _NUMBERS) and not isinstance(value, bool) for value in present):
        return np.array([np.nan if value is None else float(value) for value in values], dtype=np.float64)
    return ["" if value is None else _text(value) for value in values]


def _text(value: Any) -> str:
    """Return an object as text, with all digits of a number."""
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    if isinstance(value, bool):
        return str(value)
    return repr(float(value)) if isinstance(value, _NUMBERS) else str(value)
