"""Helpers for series, against NumPy, SciPy and the definitions."""

import pickle

import matplotlib

matplotlib.use("Agg")

import numpy as np
import pytest
import scipy.signal
import scipy.stats
import stiction

RNG = np.random.default_rng(1)
X = RNG.normal(size=500)
Y = np.roll(X, 3) + 0.1 * RNG.normal(size=500)


def test_moments():
    found = stiction.moments(X)
    expected = {
        "mean": X.mean(),
        "variance": X.var(),
        "std": X.std(),
        "skewness": scipy.stats.skew(X),
        "excess_kurtosis": scipy.stats.kurtosis(X),
        "median": np.median(X),
        "median_absolute_deviation": 1.4826 * np.median(np.abs(X - np.median(X))),
        "span": np.ptp(X),
    }
    for name, value in expected.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-12, abs=1e-14), name
    slow = 10 * np.sin(np.arange(5000) / 300)
    noise = 0.3 * RNG.normal(size=5000)
    assert stiction.moments(slow + noise).noise_std == pytest.approx(0.3, rel=0.05)


def test_correlations():
    assert stiction.correlation(X, Y) == pytest.approx(np.corrcoef(X, Y)[0, 1], rel=1e-12)
    assert stiction.correlation(X, np.ones(500)) is None
    centred = X - X.mean()
    whole = np.correlate(centred, centred, "full")[499:]
    assert stiction.autocorrelation(X, 50) == pytest.approx(whole[:51] / whole[0], abs=1e-12)
    assert stiction.autocorrelation([1, 1, 1], 2) is None
    found = stiction.cross_correlation(X, Y, 10)
    assert found.lags[found.values.argmax()] == 3 and len(found.values) == len(found.lags) == 21
    assert stiction.cross_correlation(X, np.zeros(500), 3) is None


def test_spectra_and_filters():
    found = stiction.periodogram(X)
    assert found.frequency[[0, -1]].tolist() == [0, 0.5]
    assert found.power.sum() == pytest.approx(X.var(), rel=0.1)
    t = np.arange(1024)
    slow, fast = np.sin(2 * np.pi * t / 64), np.sin(2 * np.pi * t / 4)
    assert stiction.band_passed(slow + fast + 5, 0.01, 0.1) == pytest.approx(slow, abs=1e-10)
    b, a = scipy.signal.butter(3, 0.1)
    inner = slice(200, -200)
    expected = scipy.signal.filtfilt(b, a, slow + fast)
    assert stiction.low_passed(slow + fast, 0.1)[inner] == pytest.approx(expected[inner], abs=1e-6)
    assert stiction.decimated(t, 4) == pytest.approx(t.reshape(-1, 4).mean(axis=1))
    assert stiction.detrended(X + 3 * np.arange(500)) == pytest.approx(scipy.signal.detrend(X), abs=1e-9)
    back = stiction.swinging_door(np.cumsum(X), 0.5)
    assert np.abs(back - np.cumsum(X)).max() <= 0.5 + 1e-12


def test_crossings():
    wave = np.sin(2 * np.pi * (np.arange(200) + 0.3) / 20)
    found = stiction.zero_crossings(wave)
    assert found.upward.tolist() == [bool(k % 2) for k in range(len(found.place))]
    assert np.diff(found.place) == pytest.approx(10, abs=1e-6)
    waves = stiction.half_waves(wave)
    assert waves.length == pytest.approx(waves.end - waves.begin) and len(waves.length) == len(found.place) - 1
    for first, stop, above in zip(waves.first, waves.stop, waves.above):
        assert ((wave[first:stop] > 0) == above).all()
    assert stiction.reversals(wave, 0.5) == 20 and stiction.reversals(wave, 3.0) == 0
    assert stiction.cycle_period(wave, 0.5) == pytest.approx(10)
    assert stiction.cycle_period([1, 2, 3]) is None


def test_trends_and_groups():
    t = np.arange(40.0)
    y = 0.02 * t + RNG.normal(size=40)
    assert stiction.theil_sen(t, y) == pytest.approx(scipy.stats.theilslopes(y, t).slope, rel=1e-12)
    assert stiction.theil_sen([1, 1], [2, 3]) is None
    line = scipy.stats.linregress(t, y)
    found = stiction.weighted_trend(t, y)
    assert (found.slope, found.p_value) == pytest.approx((line.slope, line.pvalue), rel=1e-9)
    half = scipy.stats.t.ppf(0.975, 38) * line.stderr
    assert (found.low, found.high) == pytest.approx((line.slope - half, line.slope + half), rel=1e-9)
    assert stiction.weighted_trend([1, 2], [1, 2]) is None
    assert stiction.mann_kendall([1, 1, 1]) == 1 and stiction.mann_kendall(np.arange(20)) < 1e-6
    a, b = RNG.normal(size=15), 1 + 2 * RNG.normal(size=12)
    expected = scipy.stats.ttest_ind(a, b, equal_var=False).pvalue
    assert stiction.welch(a, b) == stiction.difference_of_means(a, b) == pytest.approx(expected, rel=1e-9)
    exact = scipy.stats.permutation_test(
        (a[:4], b[:5]), lambda x, y, axis: x.mean(axis) - y.mean(axis), vectorized=True, n_resamples=np.inf
    )
    # SciPy doubles the smaller tail; both count the same partitions.
    null = np.abs(exact.null_distribution - exact.null_distribution.mean())
    seen = abs(a[:4].mean() - b[:5].mean() - exact.null_distribution.mean())
    assert stiction.difference_of_means(a[:4], b[:5]) == pytest.approx((null >= seen - 1e-9).mean())
    assert stiction.welch([1], [1, 2]) is None
    assert stiction.cliffs_delta(a, b) == pytest.approx(np.sign(b[None] - a[:, None]).mean())


def test_results_are_results():
    found = stiction.periodogram(X)
    again = pickle.loads(pickle.dumps(found))
    assert repr(again) == repr(found) and set(found.to_dict()) == {"frequency", "power"}
    frequency, power = found
    assert frequency is found.frequency and power is found.power
    for ax in (found.plot(), stiction.cross_correlation(X, Y, 10).plot()):
        assert ax.get_xlabel() and ax.get_ylabel() and ax.get_legend()


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.moments([]), (TypeError, ValueError), "x"),
        (lambda: stiction.moments([1, np.nan]), ValueError, "sample 1 of x is NaN"),
        (lambda: stiction.moments("a"), (TypeError, ValueError), "x"),
        (lambda: stiction.correlation([1, 2], [1]), ValueError, "y has 1 samples, but 2 are needed"),
        (lambda: stiction.cross_correlation([1, 2], [1, np.inf], 1), ValueError, "sample 1 of y is inf"),
        (lambda: stiction.autocorrelation([1, 2], -1), ValueError, "max_lag is -1"),
        (lambda: stiction.autocorrelation([1, 2], 1.5), TypeError, "max_lag must be a whole number"),
        (lambda: stiction.reversals([1, 2], -1), ValueError, "band is -1"),
        (lambda: stiction.cycle_period([1, 2], 0), ValueError, "sample_time is 0.0 s, but must be"),
        (lambda: stiction.cycle_period([1, 2], noise_band="a"), TypeError, "noise_band must be a number"),
        (lambda: stiction.decimated([1, 2], 0), ValueError, "factor is 0, but must be at least 1"),
        (lambda: stiction.low_passed([1, 2], 1.0), ValueError, "cutoff is 1.0, but must be above 0 and below 1"),
        (lambda: stiction.band_passed([1, 2], 0.2, 0.1), ValueError, "high is 0.1, but must be at least low"),
        (lambda: stiction.band_passed([1, 2], -1, 0.1), ValueError, "low is -1.0"),
        (lambda: stiction.swinging_door([1, 2], np.nan), ValueError, "deviation is nan"),
        (lambda: stiction.theil_sen([1, 2], [1, 2, 3]), ValueError, "y has 3 samples, but 2 are needed"),
        (lambda: stiction.weighted_trend([1, 2], [1, 2], [1]), ValueError, "weights has 1 samples"),
        (lambda: stiction.welch([1, 2], [np.nan, 1]), ValueError, "sample 0 of b is NaN"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
