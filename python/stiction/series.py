"""What every method needs of a series of samples: moments, correlation, spectra, crossings, filters, trends.

Lags and places are in samples, frequencies in cycles per sample. All samples must be finite.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stiction import _core
from stiction._arguments import integer, number
from stiction._arrays import Array, Samples, samples
from stiction._plots import axes, legend
from stiction._result import Result, about, result

__all__ = [
    "CrossCorrelation",
    "HalfWaves",
    "Moments",
    "Periodogram",
    "Trend",
    "ZeroCrossings",
    "autocorrelation",
    "band_passed",
    "cliffs_delta",
    "correlation",
    "cross_correlation",
    "cycle_period",
    "decimated",
    "detrended",
    "difference_of_means",
    "half_waves",
    "low_passed",
    "mann_kendall",
    "moments",
    "periodogram",
    "reversals",
    "swinging_door",
    "theil_sen",
    "weighted_trend",
    "welch",
    "zero_crossings",
]


@result
class Moments(Result):
    """Moments and order statistics of a series."""

    mean: float = about("Arithmetic mean.")
    variance: float
    std: float = about("Mean square deviation from the mean (divisor n), and its root.")
    skewness: float = about(
        "Third central moment over the cube of the standard deviation; NaN if all samples are equal."
    )
    excess_kurtosis: float = about(
        "Fourth central moment over the squared variance, less 3; NaN if all samples are equal."
    )
    median: float = about("The value in the middle.")
    median_absolute_deviation: float = about("Median distance from the median, times 1.4826.")
    noise_std: float = about("Standard deviation of white noise on a slower signal, from the second differences.")
    span: float = about("Largest less smallest sample.")


def moments(x: Samples) -> Moments:
    """Give moments and order statistics of a series.

    Parameters
    ----------
    x : array_like
        The series.

    Returns
    -------
    Moments

    Raises
    ------
    ValueError
        If it is empty, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.moments([1, 2, 3, 6])
    >>> found.mean, found.variance, found.median
    (3.0, 3.5, 2.5)
    """
    return Moments(**_core.moments(samples("x", x)))


def autocorrelation(x: Samples, max_lag: int) -> Array | None:
    """Correlate a series, less its mean, with itself (biased, divisor n).

    Parameters
    ----------
    x : array_like
        The series.
    max_lag : int
        The largest lag, samples; at most one less than there are samples.

    Returns
    -------
    ndarray or None
        Coefficients at the lags 0 to `max_lag`, 1 at lag 0; None if all samples are equal.

    Raises
    ------
    ValueError
        If it is empty, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.autocorrelation([1, -1, 1, -1], 2).round(12)
    array([ 1.  , -0.75,  0.5 ])
    """
    return _core.autocorrelation(samples("x", x), integer("max_lag", max_lag))


def correlation(x: Samples, y: Samples) -> float | None:
    """Correlate two series.

    Parameters
    ----------
    x, y : array_like
        Series of one length.

    Returns
    -------
    float or None
        Their correlation, -1 to 1; None if either does not move.

    Raises
    ------
    ValueError
        If lengths differ, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.correlation([1, 2, 3], [2, 4, 6])
    1.0
    """
    return _core.correlation(samples("x", x), samples("y", y))


@result
class CrossCorrelation(Result):
    """The correlation of two series over lags of both signs."""

    values: Array = about("Coefficients at the lags ``-max_lag`` to ``max_lag``.")
    max_lag: int = about("The largest lag, samples.")

    @property
    def lags(self) -> npt.NDArray[np.int64]:
        """The lags, samples."""
        return np.arange(-self.max_lag, self.max_lag + 1, dtype=np.int64)

    def plot(self, ax: Any = None) -> Any:
        """Plot the coefficients over the lags.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; by default new ones.

        Returns
        -------
        matplotlib Axes
        """
        (only,) = axes(ax)
        only.axhline(0, color="0.7", linewidth=0.8)
        only.plot(self.lags, self.values, color="C0", label="cross-correlation")
        only.set_xlabel("lag (samples)")
        only.set_ylabel("coefficient (-)")
        legend(only)
        return only


def cross_correlation(u: Samples, y: Samples, max_lag: int) -> CrossCorrelation | None:
    """Correlate two series, less their means, over lags: ``sum u(k) y(k + lag) / (n sd(u) sd(y))``.

    Where it peaks at a positive lag, `y` follows `u`.

    Parameters
    ----------
    u, y : array_like
        Series of one length.
    max_lag : int
        The largest lag, samples; at most one less than there are samples.

    Returns
    -------
    CrossCorrelation or None
        None if either series is constant.

    Raises
    ------
    ValueError
        If lengths differ, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> found = stiction.cross_correlation([0, 1, 0, 0, 0], [0, 0, 0, 1, 0], 2)
    >>> int(found.lags[found.values.argmax()])
    2
    """
    found = _core.cross_correlation(samples("u", u), samples("y", y), integer("max_lag", max_lag))
    return None if found is None else CrossCorrelation(**found)


@result
class Periodogram(Result):
    """Power over frequency."""

    frequency: Array = about("Frequencies, cycles per sample, from 0 to 0.5.")
    power: Array = about("Power of each, in squared units of the series; the sum is the series' windowed variance.")

    def plot(self, ax: Any = None) -> Any:
        """Plot the power over the frequency.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; by default new ones.

        Returns
        -------
        matplotlib Axes
        """
        (only,) = axes(ax)
        only.semilogy(self.frequency[1:], self.power[1:], color="C0", label="periodogram")
        only.set_xlabel("frequency (cycles per sample)")
        only.set_ylabel("power (squared units)")
        legend(only)
        return only


def periodogram(x: Samples) -> Periodogram:
    """Give the periodogram of a series less its mean, under a Hann window, padded to a power of two.

    Parameters
    ----------
    x : array_like
        The series.

    Returns
    -------
    Periodogram

    Raises
    ------
    ValueError
        If it is empty, or a sample not finite.

    Examples
    --------
    >>> import numpy as np, stiction
    >>> found = stiction.periodogram(np.sin(2 * np.pi * np.arange(256) / 16))
    >>> float(found.frequency[found.power.argmax()])
    0.0625
    """
    return Periodogram(**_core.periodogram(samples("x", x)))


@result
class ZeroCrossings(Result):
    """Where a series crosses zero, one entry a crossing."""

    place: Array = about("Where, samples, interpolated.")
    next: npt.NDArray[np.int64] = about("The first sample beyond it.")
    upward: npt.NDArray[np.bool_] = about("Whether it goes from below zero to above.")


def zero_crossings(x: Samples) -> ZeroCrossings:
    """Find the changes of sign of a series; one that touches zero and turns back does not cross it.

    Parameters
    ----------
    x : array_like
        The series.

    Returns
    -------
    ZeroCrossings

    Raises
    ------
    ValueError
        If it is empty, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.zero_crossings([-1, 1, 2, -2]).place
    array([0.5, 2.5])
    """
    return ZeroCrossings(**_core.zero_crossings(samples("x", x)))


@result
class HalfWaves(Result):
    """The complete half waves of a series, those between two crossings of zero."""

    begin: Array
    end: Array = about("Where they begin and end, samples, interpolated.")
    length: Array = about("Their lengths, samples.")
    first: npt.NDArray[np.int64]
    stop: npt.NDArray[np.int64] = about("Their first sample, and one past their last.")
    above: npt.NDArray[np.bool_] = about("Whether the series is above zero.")


def half_waves(x: Samples) -> HalfWaves:
    """Find the complete half waves of a series.

    Parameters
    ----------
    x : array_like
        The series.

    Returns
    -------
    HalfWaves

    Raises
    ------
    ValueError
        If it is empty, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.half_waves([-1, 1, 2, -2, -2, 2]).length
    array([2., 2.])
    """
    return HalfWaves(**_core.half_waves(samples("x", x)))


def reversals(x: Samples, band: float) -> int:
    """Count the turns of a series by more than a band.

    Parameters
    ----------
    x : array_like
        The series.
    band : float
        The band, in units of the series, not negative.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        If the band is negative, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.reversals([0, 5, 4.9, 6, 1, 7], band=1)
    2
    """
    return _core.reversals(samples("x", x), _at_least_zero("band", band))


def cycle_period(x: Samples, sample_time: float = 1.0, *, noise_band: float = 0.0) -> float | None:
    """Give the mean time between upward crossings of the middle of the range of a series.

    Parameters
    ----------
    x : array_like
        The series.
    sample_time : float, default 1
        Time between samples, s.
    noise_band : float, default 0
        How far it must fall below and rise above the middle for a crossing to count, in its units; three
        standard deviations of the noise is a good choice.

    Returns
    -------
    float or None
        The period, s; None if there are fewer than three crossings.

    Raises
    ------
    ValueError
        If the sample time is not above 0, the band negative, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.cycle_period([0, 1, 0, -1] * 5, sample_time=0.5)
    2.0
    """
    time = number("sample_time", sample_time)
    if not 0 < time < float("inf"):
        raise ValueError(f"sample_time is {time} s, but must be a finite number above 0")
    return _core.cycle_period(samples("x", x), time, _at_least_zero("noise_band", noise_band))


def decimated(x: Samples, factor: int) -> Array:
    """Give the means of every `factor` neighbouring samples; what is left at the end is dropped.

    Parameters
    ----------
    x : array_like
        The series.
    factor : int
        Samples to one, at least 1.

    Returns
    -------
    ndarray

    Raises
    ------
    ValueError
        If the factor is below 1, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.decimated([1, 3, 5, 7, 9], 2)
    array([2., 6.])
    """
    return _core.decimated(samples("x", x), integer("factor", factor, 1))


def detrended(x: Samples) -> Array:
    """Give a series less its straight line of least squares.

    Parameters
    ----------
    x : array_like
        The series.

    Returns
    -------
    ndarray

    Raises
    ------
    ValueError
        If it is empty, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.detrended([1, 2, 3])
    array([0., 0., 0.])
    """
    return _core.detrended(samples("x", x))


def low_passed(x: Samples, cutoff: float) -> Array:
    """Filter by a Butterworth low pass of the third order, forwards and backwards, so that nothing is delayed.

    Parameters
    ----------
    x : array_like
        The series.
    cutoff : float
        Where it begins to damp, as a share of the Nyquist frequency, above 0 and below 1.

    Returns
    -------
    ndarray

    Raises
    ------
    ValueError
        If the cutoff is out of its range, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.low_passed([1, 1, 1], 0.5)
    array([1., 1., 1.])
    """
    share = number("cutoff", cutoff)
    if not 0 < share < 1:
        raise ValueError(f"cutoff is {share}, but must be above 0 and below 1")
    return _core.low_passed(samples("x", x), share)


def band_passed(x: Samples, low: float, high: float) -> Array:
    """Give what of a series lies between two frequencies, without its mean.

    Parameters
    ----------
    x : array_like
        The series.
    low, high : float
        The frequencies, cycles per sample, 0 to 0.5; all other bins of its Fourier transform are set to zero.

    Returns
    -------
    ndarray

    Raises
    ------
    ValueError
        If `high` is below `low`, one of them is negative, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.band_passed([1, -1, 1, -1], 0.0, 0.3)
    array([0., 0., 0., 0.])
    """
    lowest = _at_least_zero("low", low)
    highest = number("high", high)
    if not highest >= lowest:
        raise ValueError(f"high is {highest}, but must be at least low, {lowest}")
    return _core.band_passed(samples("x", x), lowest, highest)


def swinging_door(x: Samples, deviation: float) -> Array:
    """Give what comes back from a historian that compresses by swinging doors and interpolates (Bristol 1990).

    Parameters
    ----------
    x : array_like
        The series.
    deviation : float
        How far what comes back may lie from a sample, in units of the series, not negative.

    Returns
    -------
    ndarray
        As many samples.

    Raises
    ------
    ValueError
        If the deviation is negative, or a sample not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.swinging_door([0, 1.1, 2, 3, 0], deviation=0.2)
    array([0., 1., 2., 3., 0.])
    """
    return _core.swinging_door(samples("x", x), _at_least_zero("deviation", deviation))


def theil_sen(x: Samples, y: Samples) -> float | None:
    """Give the median of the slopes of all pairs of points (Theil 1950, Sen 1968).

    Parameters
    ----------
    x, y : array_like
        The points. Time and memory grow with the square of their number.

    Returns
    -------
    float or None
        The slope, units of `y` per unit of `x`; None if no two points differ in `x`.

    Raises
    ------
    ValueError
        If lengths differ, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.theil_sen([0, 1, 2, 3, 4], [0, 1, 2, 3, 90])
    1.0
    """
    return _core.theil_sen(samples("x", x), samples("y", y))


def mann_kendall(y: Samples) -> float:
    """Test values in order of time for a trend, whatever its shape (Mann 1945, Kendall).

    Parameters
    ----------
    y : array_like
        The values.

    Returns
    -------
    float
        The two-sided p-value, by the normal approximation with its corrections for continuity and ties.

    Raises
    ------
    ValueError
        If there is none, or a value is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.mann_kendall([1, 2, 3, 5, 8, 13, 21]) < 0.01
    True
    """
    return _core.mann_kendall(samples("y", y))


@result
class Trend(Result):
    """A straight line of weighted least squares, with what is known of its slope."""

    slope: float = about("Units of y per unit of x.")
    low: float
    high: float = about("Ends of the 95 % interval of the slope.")
    p_value: float = about("Probability of a slope as far from zero if there were none, two-sided.")


def weighted_trend(x: Samples, y: Samples, weights: Samples | None = None) -> Trend | None:
    """Fit a straight line of weighted least squares (Draper and Smith 1998).

    Parameters
    ----------
    x, y : array_like
        The points.
    weights : array_like, optional
        Their weights, the ratios of 1 over their variances; points of weight 0 do not count. By default 1.

    Returns
    -------
    Trend or None
        None for fewer than three points of positive weight, or if they have one `x` only.

    Raises
    ------
    ValueError
        If lengths differ, or a sample is not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.weighted_trend([0, 1, 2], [1, 3, 5]).slope
    2.0
    """
    points = samples("x", x)
    given = np.ones(len(points)) if weights is None else samples("weights", weights)
    found = _core.weighted_trend(points, samples("y", y), given)
    return None if found is None else Trend(**found)


def difference_of_means(a: Samples, b: Samples) -> float | None:
    """Test whether the means of two groups differ.

    Of up to 20 values together Fisher's exact permutation test, of more Welch's t-test.

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
        If a group is empty, or a value not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.difference_of_means([1, 2, 3], [4, 5, 6])
    0.1
    """
    return _core.difference_of_means(samples("a", a), samples("b", b))


def welch(a: Samples, b: Samples) -> float | None:
    """Test whether the means of two groups differ, whose variances may differ (Welch 1947).

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
        If a group is empty, or a value not finite.

    Examples
    --------
    >>> import stiction
    >>> round(stiction.welch([1, 2, 3], [4, 5, 6]), 4)
    0.0213
    """
    return _core.welch(samples("a", a), samples("b", b))


def cliffs_delta(a: Samples, b: Samples) -> float:
    """Say how far the values of one group lie above those of another (Cliff 1993).

    Parameters
    ----------
    a, b : array_like
        The groups.

    Returns
    -------
    float
        Share of pairs in which the value of `b` is above that of `a`, less the share in which it is below.

    Raises
    ------
    ValueError
        If a group is empty, or a value not finite.

    Examples
    --------
    >>> import stiction
    >>> stiction.cliffs_delta([1, 2, 3], [2, 3, 4])
    0.5555555555555556
    """
    return _core.cliffs_delta(samples("a", a), samples("b", b))


def _at_least_zero(name: str, value: Any) -> float:
    found = number(name, value)
    if not 0 <= found < float("inf"):
        raise ValueError(f"{name} is {found}, but must be a finite number of at least 0")
    return found
