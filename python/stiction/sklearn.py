"""Estimators for scikit-learn, a classifier and a regressor based on diagnoses of recordings.

The model behind a verdict is frozen, so fitting learns nothing. `fit` only checks arguments, and the probabilities come from
the verdicts. These estimators are for scoring, comparing and chaining. The package does not import this module by itself.

Cases are recordings, tables of one loop each, or an array of the shape ``(n_cases, n_channels, n_timepoints)``. The channels are
OP in percent of span, PV and, as a third channel, SP. NaN is missing.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from stiction._arguments import choice, number
from stiction._arrays import Array, unmasked
from stiction._core import Recording
from stiction._words import documented
from stiction.diagnosis import Diagnosis, diagnose_all
from stiction.recordings import RecordingLike, _checked, _is_table, recording

try:
    from sklearn.base import BaseEstimator, ClassifierMixin, RegressorMixin
    from sklearn.utils.validation import check_is_fitted
except ImportError:
    raise ImportError("stiction.sklearn needs scikit-learn: pip install stiction[sklearn]") from None

__all__ = ["StictionDetector", "StictionQuantifier"]


class StictionDetector(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """A classifier of recordings that predicts whether the valve of each recording sticks.

    Parameters
    ----------
    threshold : float, default 0.5
        Probability from which a valve counts as sticking.
    undecided : float, default 0.5
        Probability for a verdict "cannot tell" without a probability.
    loop_type : str, optional
        Type of the loops; by default as in the recordings.
    sample_time : float, optional
        Time between samples, s; required for arrays and tables without times. For recordings and other tables, the sample time of
        the grid; by default the most frequent sample time.

    Attributes
    ----------
    classes_ : ndarray
        ``[False, True]``: does not stick, sticks.

    Examples
    --------
    >>> import numpy as np
    >>> import stiction
    >>> from stiction.sklearn import StictionDetector
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> loops = [stiction.recording(run.op, run.pv, run.sp, sample_time=1)]
    >>> StictionDetector().fit(loops).predict(loops)
    array([ True])

    With an array of one case:

    >>> case = [[run.op, run.pv, run.sp]]
    >>> StictionDetector(sample_time=1).fit(np.array(case)).predict(np.array(case))
    array([ True])
    """

    def __init__(
        self,
        threshold: float = 0.5,
        undecided: float = 0.5,
        loop_type: str | None = None,
        sample_time: float | None = None,
    ) -> None:
        self.threshold = threshold
        self.undecided = undecided
        self.loop_type = loop_type
        self.sample_time = sample_time

    @documented
    def fit(self, X: Iterable[RecordingLike], y: npt.ArrayLike | None = None) -> StictionDetector:
        """Check recordings and labels. Nothing is learnt.

        Parameters
        ----------
        y : array_like, optional
            Whether the valves stick, as truth values, or 0 and 1.

        Returns
        -------
        StictionDetector
            Itself.

        Raises
        ------
        TypeError
            If `X` contains anything except recordings and tables.
        ValueError
            If a parameter is out of its range, a label is neither true nor false, or the numbers of labels and recordings differ.
        """
        for name in ("threshold", "undecided"):
            given = number(name, getattr(self, name))
            if not 0 <= given <= 1:
                raise ValueError(f"{name} is {given:g}, but must be between 0 and 1")
        labels = _same_length(_recordings(X, self.sample_time), y)
        if labels is not None and not np.isin(labels, [0, 1]).all():
            raise ValueError("y must hold truth values, or 0 and 1, only")
        self.classes_ = np.array([False, True])
        return self

    @documented
    def predict_proba(self, X: Iterable[RecordingLike]) -> Array:
        """Return the probabilities of both classes.

        Returns
        -------
        ndarray
            One row per recording, with the probabilities that the valve does not stick and that the valve sticks. A verdict without
            a probability counts as certain, or as `undecided` if the verdict is "cannot tell".
        """
        check_is_fitted(self)
        found = _diagnoses(X, self.loop_type, self.sample_time)
        p = np.array([self._probability(each) for each in found], dtype=np.float64)
        return np.column_stack([1 - p, p])

    @documented
    def predict(self, X: Iterable[RecordingLike]) -> npt.NDArray[np.bool_]:
        """Return whether valves stick."""
        sticks: npt.NDArray[np.bool_] = self.predict_proba(X)[:, 1] >= self.threshold
        return sticks

    def _probability(self, diagnosis: Diagnosis) -> float:
        verdict = diagnosis.verdict
        if verdict.probability is not None:
            return verdict.probability
        return {"sticks": 1.0, "cannot tell": float(self.undecided)}.get(verdict.class_, 0.0)


class StictionQuantifier(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A regressor for the size of stiction from recordings.

    Parameters
    ----------
    quantity : {"S", "J"}, default "S"
        The predicted quantity: stick band plus dead band, or slip jump.
    loop_type : str, optional
        Type of the loops; by default as in the recordings.
    sample_time : float, optional
        Time between samples, s; required for arrays and tables without times. For recordings and other tables, the sample time of
        the grid; by default the most frequent sample time.

    Attributes
    ----------
    is_fitted_ : bool
        True after `fit`.

    Examples
    --------
    >>> import stiction
    >>> from stiction.sklearn import StictionQuantifier
    >>> run = stiction.simulate("samples/sticky-flow")
    >>> loops = [stiction.recording(run.op, run.pv, run.sp, sample_time=1)]
    >>> [[low, high]] = StictionQuantifier().fit(loops).predict_interval(loops)
    >>> bool(low < 4 < high)
    True
    """

    def __init__(
        self, quantity: str = "S", loop_type: str | None = None, sample_time: float | None = None
    ) -> None:
        self.quantity = quantity
        self.loop_type = loop_type
        self.sample_time = sample_time

    @documented
    def fit(self, X: Iterable[RecordingLike], y: npt.ArrayLike | None = None) -> StictionQuantifier:
        """Check recordings and values. Nothing is learnt.

        Parameters
        ----------
        y : array_like, optional
            True S or J of the valves, percent of span.

        Returns
        -------
        StictionQuantifier
            Itself.

        Raises
        ------
        TypeError
            If `X` contains anything except recordings and tables.
        ValueError
            If there is no such quantity, or the numbers of recordings and values differ.
        """
        choice("quantity", self.quantity, ("S", "J"))
        _same_length(_recordings(X, self.sample_time), y)
        self.is_fitted_ = True
        return self

    @documented
    def predict(self, X: Iterable[RecordingLike]) -> Array:
        """Estimate S or J.

        Returns
        -------
        ndarray
            Percent of span; NaN if a diagnosis has no estimate.
        """
        return self._estimates(X)[:, 0]

    @documented
    def predict_interval(self, X: Iterable[RecordingLike]) -> Array:
        """Return the intervals of the estimates.

        Returns
        -------
        ndarray
            One row per recording, with the lower and upper end of the 90 % interval, percent of span; NaN as in `predict`.
        """
        return self._estimates(X)[:, 1:]

    def _estimates(self, X: Iterable[RecordingLike]) -> Array:
        check_is_fitted(self)
        found = [getattr(each.stiction, self.quantity) for each in _diagnoses(X, self.loop_type, self.sample_time)]
        rows = [(np.nan,) * 3 if each is None else (each.value, each.low, each.high) for each in found]
        return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _recordings(X: Any, sample_time: float | None) -> list[Recording]:
    """Return the cases as recordings."""
    if _is_table(X):
        raise TypeError("X must be a list of recordings or tables, but is one table")
    if getattr(X, "ndim", None) != 3:
        return [_checked(each, f"X[{place}]", sample_time) for place, each in enumerate(X)]
    cases = unmasked(X)
    if cases.shape[1] not in (2, 3):
        raise ValueError(f"X has the shape {cases.shape}, but must have 2 or 3 channels: OP, PV and SP")
    if sample_time is None:
        raise ValueError("sample_time must be given with an array: the time between its samples, s")
    return [recording(*case, sample_time=sample_time, name=f"X[{place}]") for place, case in enumerate(cases)]


def _diagnoses(X: Any, loop_type: str | None, sample_time: float | None) -> list[Diagnosis]:
    recordings = _recordings(X, sample_time)
    return diagnose_all(recordings, loop_type=loop_type, detectors="none", sample_time=sample_time)


def _same_length(recordings: list[Recording], y: Any) -> npt.NDArray[Any] | None:
    if y is None:
        return None
    if np.ma.is_masked(y):
        raise ValueError("y has masked values, but every recording needs its label")
    given = np.asarray(y)
    if given.shape != (len(recordings),):
        raise ValueError(f"y has the shape {given.shape}, but X holds {len(recordings)} recordings")
    return given
