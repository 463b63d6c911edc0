"""Detection of oscillations: whether a signal cycles, how regularly, with which period, and when."""

from __future__ import annotations

from stiction import _core
from stiction._arguments import positive
from stiction._arrays import Samples, samples
from stiction._document import Episode, Oscillation, Peak, Supervision
from stiction._result import result_of
from stiction._words import documented

__all__ = ["Episode", "Oscillation", "Peak", "Supervision", "oscillation"]


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
    return result_of(Oscillation, _core.oscillation_of(samples("signal", signal), positive("sample_time", sample_time)))
