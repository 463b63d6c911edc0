"""Dates and times in UTC, from seconds since 1970."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone
from typing import Any

import numpy as np
import numpy.typing as npt

from stiction._arrays import Array

__all__: list[str] = []

_EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)


def moment(start: float) -> datetime:
    """Return seconds since 1970-01-01 UTC as a datetime, to the microsecond."""
    return _EPOCH + timedelta(seconds=start)


def moments(start: float, time_s: Array) -> npt.NDArray[np.datetime64]:
    """Return times on a clock that began at `start` as datetimes, to the millisecond."""
    milliseconds: Any = np.round(1000 * (start + time_s)).astype(np.int64)
    found: npt.NDArray[np.datetime64] = milliseconds.astype("datetime64[ms]")
    return found
