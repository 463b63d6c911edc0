"""Functions on series of samples that NumPy and SciPy lack.

Places are in samples. All samples must be finite.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiction import _core
from stiction._arguments import at_least_zero, positive
from stiction._arrays import Array, Samples, samples
from stiction._result import Result, about, result
from stiction._words import documented

__all__ = [
    "HalfWaves",
    "ZeroCrossings",
    "cycle_period",
    "difference_of_means",
    "half_waves",
    "mann_kendall",
    "reversals",
    "swinging_door",
    "zero_crossings",
]


@result
class ZeroCrossings(Result):
    """The zero crossings of a series, one entry per crossing."""

    place: Array = about("Place of the crossing, samples, interpolated.")
    next: npt.NDArray[np.int64] = about("The first sample after the crossing.")
    upward: npt.NDArray[np.bool_] = about("Whether the series goes from below zero to above zero.")


@documented
def zero_crossings(x: Samples) -> ZeroCrossings:
    """Find the sign changes of a series. A series that touches zero and turns back does not cross zero.

    Raises
    ------
    ValueError
        If the series is empty, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.series.zero_crossings([-1, 1, 2, -2]).place
    array([0.5, 2.5])
    """
    return ZeroCrossings(**_core.zero_crossings(samples("x", x)))


@result
class HalfWaves(Result):
    """The complete half waves of a series, between two zero crossings."""

    begin: Array
    end: Array = about("Beginning and end of the half waves, samples, interpolated.")
    length: Array = about("Their lengths, samples.")
    first: npt.NDArray[np.int64]
    stop: npt.NDArray[np.int64] = about("Index of the first sample of each half wave, and index after the last sample.")
    above: npt.NDArray[np.bool_] = about("Whether the series is above zero.")


@documented
def half_waves(x: Samples) -> HalfWaves:
    """Find the complete half waves of a series.

    Raises
    ------
    ValueError
        If the series is empty, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.series.half_waves([-1, 1, 2, -2, -2, 2]).length
    array([2., 2.])
    """
    return HalfWaves(**_core.half_waves(samples("x", x)))


@documented
def reversals(x: Samples, band: float) -> int:
    """Count the reversals of a series that exceed a band.

    Parameters
    ----------
    band : float
        The band, in units of the series, not negative.

    Raises
    ------
    ValueError
        If the band is negative, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.series.reversals([0, 5, 4.9, 6, 1, 7], band=1)
    2
    """
    return _core.reversals(samples("x", x), at_least_zero("band", band))


@documented
def cycle_period(x: Samples, sample_time: float = 1.0, *, noise_band: float = 0.0) -> float | None:
    """Return the mean time between upward crossings of the middle of a series' range.

    Parameters
    ----------
    sample_time : float, default 1
        Time between samples, s.
    noise_band : float, default 0
        Distance below and above the middle that a crossing must span, in units of the series. Three standard deviations of the
        noise are a good choice.

    Returns
    -------
    float or None
        The period, s; None with fewer than three crossings.

    Raises
    ------
    ValueError
        If the sample time is not above 0, the band is negative, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.series.cycle_period([0, 1, 0, -1] * 5, sample_time=0.5)
    2.0
    """
    time, band = positive("sample_time", sample_time), at_least_zero("noise_band", noise_band)
    return _core.cycle_period(samples("x", x), time, band)


@documented
def swinging_door(x: Samples, deviation: float) -> Array:
    """Return the series that a historian with swinging-door compression and interpolation would return (Bristol 1990).

    Parameters
    ----------
    deviation : float
        Permitted deviation from a sample, in units of the series, not negative.

    Returns
    -------
    ndarray
        The compressed series, with as many samples as the given series.

    Raises
    ------
    ValueError
        If the deviation is negative, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.series.swinging_door([0, 1.1, 2, 3, 0], deviation=0.2)
    array([0., 1., 2., 3., 0.])
    """
    return _core.swinging_door(samples("x", x), at_least_zero("deviation", deviation))


def mann_kendall(y: Samples) -> float:
    """Test values in order of time for a monotonic trend of any shape (Mann 1945, Kendall).

    Parameters
    ----------
    y : array_like
        The values.

    Returns
    -------
    float
        The two-sided p-value, by the normal approximation with corrections for continuity and ties.

    Raises
    ------
    ValueError
        If there is no value, or a value is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.series.mann_kendall([1, 2, 3, 5, 8, 13, 21]) < 0.01
    True
    """
    return _core.mann_kendall(samples("y", y))


def difference_of_means(a: Samples, b: Samples) -> float | None:
    """Test whether the means of two groups differ.

    The test is Fisher's exact permutation test for up to 20 values in total, and Welch's t-test for more.

    Parameters
    ----------
    a, b : array_like
        The groups.

    Returns
    -------
    float or None
        The two-sided p-value; None if a group has fewer than two values.

    Raises
    ------
    ValueError
        If a group is empty, or a value is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.series.difference_of_means([1, 2, 3], [4, 5, 6])
    0.1
    """
    return _core.difference_of_means(samples("a", a), samples("b", b))
