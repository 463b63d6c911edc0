"""Signals as float64 arrays, from any source."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from stiction import _core

__all__: list[str] = []

Array: TypeAlias = npt.NDArray[np.float64]
"""The type of returned arrays."""

Samples: TypeAlias = Any
"""The type of array arguments: a NumPy array of any real dtype and stride, a sequence of numbers, or a column of a table.
Tables have the Arrow capsule interface, as tables of pandas, polars and pyarrow have. Masked values and Arrow nulls count as
missing.
"""


def unmasked(values: Any) -> npt.NDArray[Any]:
    """Return `values` as an array, with NaN, NaT or None for masked values."""
    if not isinstance(values, np.ma.MaskedArray):
        return np.asarray(values)
    if not np.ma.is_masked(values):
        return np.asarray(values.data)
    array, mask = np.array(values.data), np.ma.getmaskarray(values)
    if array.dtype.kind == "M":
        array[mask] = np.datetime64("NaT")
        return array
    numeric = array.dtype.kind in "biuf"
    array = array.astype(np.float64 if numeric else object)
    array[mask] = np.nan if numeric else None
    return array


def samples(name: str, values: Samples) -> Array:
    """Return `values` as a contiguous float64 array, copied only if necessary.

    Nulls of Arrow columns, masked values and NaN become NaN. The caller decides whether NaN is allowed.
    """
    if not isinstance(values, np.ndarray) and (
        hasattr(values, "__arrow_c_stream__") or hasattr(values, "__arrow_c_array__")
    ):
        try:
            return _core.arrow_column(name, values)
        except TypeError:
            raise
        except Exception as error:
            raise TypeError(f"{name} must be a column of numbers: {error}") from None
    try:
        array = unmasked(values)
    except ValueError as error:
        raise TypeError(f"{name} must be a one-dimensional array of numbers: {error}") from None
    if array.dtype.kind not in "fiu":
        raise TypeError(
            f"{name} must hold real numbers, but its dtype is {array.dtype}"
            if array.size
            else f"{name} is empty, but needs at least one sample"
        )
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}, but must be one-dimensional")
    return np.ascontiguousarray(array, dtype=np.float64)
