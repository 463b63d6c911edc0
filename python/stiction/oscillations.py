"""Whether a signal cycles, how regularly, with what period, and when."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiction import _core
from stiction._arguments import number
from stiction._arrays import Samples, samples
from stiction._result import Result, result, result_of

__all__ = ["Episode", "Oscillation", "Peak", "Supervision", "oscillation"]


@result
class Supervision(Result):
    """Hägglund's supervision: half waves with a large integrated absolute error count as disturbances.

    Attributes
    ----------
    threshold : float
        Integrated absolute error from which a half wave counts, units of the signal times s.
    disturbances : int
        Half waves that count.
    half_waves : int
        All half waves.
    counter : float
        The largest value of the forgetting counter.
    alarm_s : float or None
        When the counter first passed 10, s; None if it did not.
    oscillates : bool
        Whether it did.
    """

    threshold: float
    disturbances: int
    half_waves: int
    counter: float
    alarm_s: float | None
    oscillates: bool


@result
class Peak(Result):
    """One of several simultaneous oscillations: a peak of the spectrum.

    Attributes
    ----------
    period_s : float
        Period, s.
    amplitude : float
        Half of its peak-to-peak value, units of the signal.
    share : float
        Share of the signal's variance in its band.
    regularity, decay_ratio : float or None
        Regularity and decay ratio in its band.
    chance : float
        Probability that noise makes such a peak.
    over_background : float
        Power over that of the background.
    harmonic : int or None
        Which multiple of the frequency of a stronger peak it may be.
    band : tuple of float
        Its band, cycles a sample.
    is_oscillation : bool
        Whether it is an oscillation of its own: regular, lasting, with a tenth of the variance, no harmonic.
    """

    period_s: float
    amplitude: float
    share: float
    regularity: float | None
    decay_ratio: float | None
    chance: float
    over_background: float
    harmonic: int | None
    band: tuple[float, float]
    is_oscillation: bool


@result
class Episode(Result):
    """A time in which the dominant oscillation was there.

    Attributes
    ----------
    from_s, to_s : float
        Its beginning and end, s.
    half_waves : int
        Half waves in it.
    amplitude : float
        Amplitude in it, units of the signal.
    """

    from_s: float
    to_s: float
    half_waves: int
    amplitude: float


@result
class Oscillation(Result):
    """Whether and how a signal oscillates.

    Times are s from the first sample; in a diagnosis they are on the recording's clock.

    Attributes
    ----------
    found : bool
        Whether it oscillates.
    basis : {"autocorrelation", "spectral peak"} or None
        What it was found by.
    period_s : float or None
        Period of the dominant oscillation, s.
    amplitude : float or None
        Half of its typical peak-to-peak value, units of the signal.
    cycles : float or None
        How many periods the signal spans.
    regularity : float or None
        Regularity of the zero crossings of the autocorrelation (Thornhill, Huang and Zhang, 2003); above 1 is
        regular.
    intervals : int
        Intervals between zero crossings that the regularity rests on.
    decay_ratio : float or None
        Decay ratio of the autocorrelation (Miao and Seborg, 1999); above 0.5 is oscillatory.
    supervision : Supervision or None
        Supervision of half waves (Hägglund, 1995).
    peaks : list of Peak
        All oscillations that stand out of the spectrum, strongest first.
    episodes : list of Episode
        When the dominant one was there.
    reasons : list of str
        What led to the result.
    """

    found: bool
    basis: str | None
    period_s: float | None
    amplitude: float | None
    cycles: float | None
    regularity: float | None
    intervals: int
    decay_ratio: float | None
    supervision: Supervision | None
    peaks: list[Peak]
    episodes: list[Episode]
    reasons: list[str]


def oscillation(signal: Samples, sample_time: float) -> Oscillation:
    """Tell whether and how a signal oscillates.

    Mean and straight trend are removed first.

    Parameters
    ----------
    signal : array_like
        The signal, such as the control error, one-dimensional and finite.
    sample_time : float
        Time between samples, s.

    Returns
    -------
    Oscillation

    Raises
    ------
    TypeError
        If `signal` holds no real numbers.
    ValueError
        If a sample is not finite, or `sample_time` is not above 0.

    Examples
    --------
    >>> import numpy as np, stiction
    >>> found = stiction.oscillation(np.sin(0.1 * np.arange(2000)), sample_time=2)
    >>> found.found, round(found.period_s, 1)
    (True, 125.7)
    """
    return result_of(Oscillation, _core.oscillation_of(samples("signal", signal), _step(sample_time)))


def _step(sample_time: Any) -> float:
    """Give a sample time."""
    step = number("sample_time", sample_time)
    if not 0 < step < np.inf:
        raise ValueError(f"sample_time is {step:g}, but must be a finite number above 0")
    return step


def _period(period_s: Any) -> float | None:
    """Give a period, if there is one."""
    if period_s is None:
        return None
    period = number("period_s", period_s)
    if not 0 < period < np.inf:
        raise ValueError(f"period_s is {period:g}, but must be a finite number above 0")
    return period
