"""Detection of oscillations: whether a signal cycles, how regularly, with which period, and when."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiction import _core
from stiction._arguments import number
from stiction._arrays import Samples, samples
from stiction._result import Result, about, result, result_of
from stiction._words import documented

__all__ = ["Episode", "Oscillation", "Peak", "Supervision", "oscillation"]


@result
class Supervision(Result):
    """Hägglund's supervision: half waves with a large integrated absolute error count as disturbances."""

    threshold: float = about("Integrated absolute error from which a half wave counts, units of the signal times s.")
    disturbances: int = about("Half waves that count.")
    half_waves: int = about("All half waves.")
    counter: float = about("The largest value of the forgetting counter.")
    alarm_s: float | None = about("Time at which the counter first exceeded 10, s; None if it did not.")
    oscillates: bool = about("Whether it did.")


@result
class Peak(Result):
    """One of several simultaneous oscillations: a peak of the spectrum."""

    period_s: float = about("Period, s.")
    amplitude: float = about("Half of its peak-to-peak value, units of the signal.")
    share: float = about("Share of the signal's variance in its band.")
    regularity: float | None
    decay_ratio: float | None = about("Regularity and decay ratio in its band.")
    chance: float = about("Probability that noise makes such a peak.")
    over_background: float = about("Power over that of the background.")
    harmonic: int | None = about("Multiple of the frequency of a stronger peak that it may be.")
    band: tuple[float, float] = about("Its band, cycles per sample.")
    is_oscillation: bool = about(
        "Whether it is a separate oscillation: regular, lasting, with a tenth of the variance, and not a harmonic."
    )


@result
class Episode(Result):
    """A period of time with the dominant oscillation."""

    from_s: float
    to_s: float = about("Its beginning and end, s.")
    half_waves: int = about("Half waves in it.")
    amplitude: float = about("Amplitude in it, units of the signal.")


@result
class Oscillation(Result):
    """Whether and how a signal oscillates.

    Times are s from the first sample; in a diagnosis they are on the recording's clock.
    """

    found: bool = about("Whether it oscillates.")
    basis: str | None = about("The evidence for it.", kind='{"autocorrelation", "spectral peak"} or None')
    period_s: float | None = about("Period of the dominant oscillation, s.")
    amplitude: float | None = about(
        "Swing, in units of the signal: half of the peak-to-peak value in a period, without noise, the median over the periods."
    )
    cycles: float | None = about("Number of periods in the signal.")
    regularity: float | None = about(
        "Regularity of the zero crossings of the autocorrelation (Thornhill, Huang and Zhang, 2003); above 1 is "
        "regular."
    )
    intervals: int = about("Intervals between zero crossings behind the regularity.")
    decay_ratio: float | None = about(
        "Decay ratio of the autocorrelation (Miao and Seborg, 1999); above 0.5 is oscillatory."
    )
    supervision: Supervision | None = about("Supervision of half waves (Hägglund, 1995).")
    peaks: list[Peak] = about("All oscillations above the background of the spectrum, strongest first.")
    episodes: list[Episode] = about("Times with the dominant oscillation.")
    reasons: list[str] = about("Reasons for the result.")


@documented
def oscillation(signal: Samples, sample_time: float) -> Oscillation:
    """Return whether and how a signal oscillates.

    Mean and straight trend are removed first.

    Parameters
    ----------
    signal : array_like
        The signal, such as the control error, one-dimensional and finite.

    Raises
    ------
    TypeError
        If `signal` holds no real numbers.
    ValueError
        If a sample is not finite, or `sample_time` is not above 0.

    Examples
    --------
    >>> import numpy as np, stiction
    >>> found = stiction.oscillations.oscillation(np.sin(0.1 * np.arange(2000)), sample_time=2)
    >>> found.found, round(found.period_s, 1)
    (True, 125.7)
    """
    return result_of(Oscillation, _core.oscillation_of(samples("signal", signal), _step(sample_time)))


def _step(sample_time: Any) -> float:
    """Return a sample time."""
    step = number("sample_time", sample_time)
    if not 0 < step < np.inf:
        raise ValueError(f"sample_time is {step:g}, but must be a finite number above 0")
    return step


def _period(period_s: Any) -> float | None:
    """Return a period, if there is one."""
    if period_s is None:
        return None
    period = number("period_s", period_s)
    if not 0 < period < np.inf:
        raise ValueError(f"period_s is {period:g}, but must be a finite number above 0")
    return period
