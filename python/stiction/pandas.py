"""Recordings and diagnoses from pandas data frames, through ``frame.stiction`` after this module is imported.

The package does not import this module by itself.
"""

from __future__ import annotations

from typing import Any

from stiction._core import Recording
from stiction.diagnosis import Diagnosis, diagnose
from stiction.recordings import recording_from

try:
    from pandas.api.extensions import register_dataframe_accessor
except ImportError:
    raise ImportError("stiction.pandas needs pandas: pip install stiction[pandas]") from None

__all__ = ["StictionAccessor"]


@register_dataframe_accessor("stiction")  # type: ignore[untyped-decorator, unused-ignore]
class StictionAccessor:
    """The accessor ``frame.stiction``.

    Parameters
    ----------
    frame : pandas.DataFrame
        The columns of one loop.

    Examples
    --------
    >>> import pandas as pd
    >>> import stiction.pandas
    >>> frame = pd.read_csv(stiction.datasets.path("FIC101-sticky"))
    >>> frame.stiction.diagnose(detectors="none").verdict.class_
    'sticks'
    """

    def __init__(self, frame: Any) -> None:
        self._frame = frame

    def recording(self, **keywords: Any) -> Recording:
        """Make a recording from the data frame.

        Parameters
        ----------
        **keywords
            As in `stiction.recording_from`.
        """
        return recording_from(self._frame, **keywords)

    def diagnose(self, **keywords: Any) -> Diagnosis:
        """Diagnose the data frame.

        Parameters
        ----------
        **keywords
            As in `stiction.diagnose`. If columns or the tag must be named, diagnose ``frame.stiction.recording()``.
        """
        return diagnose(self._frame, **keywords)
