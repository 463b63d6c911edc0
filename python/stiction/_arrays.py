"""Signals as float64 arrays, whatever they come as."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from stiction import _core

__all__: list[str] = []

Array: TypeAlias = npt.NDArray[np.float64]
"""What is given out."""

Samples: TypeAlias = Any
"""What is taken: a NumPy array of any real dtype and stride, a sequence of numbers, or a column of any table that
speaks the Arrow capsule interface (pandas, polars, pyarrow)."""


def samples(name: str, values: Samples) -> Array:
    """Give `values` as a contiguous float64 array, without a copy if they are one.

    Nulls of Arrow columns and NaN stay NaN: whether they are allowed is the callee's to say.
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
        array = np.asarray(values)
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
