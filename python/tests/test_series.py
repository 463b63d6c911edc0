"""Helpers for series, against NumPy, SciPy and the definitions."""

import pickle

import numpy as np
import pytest
import scipy.stats
import stiction

RNG = np.random.default_rng(1)


def test_a_swinging_door_keeps_within_its_deviation():
    walk = np.cumsum(RNG.normal(size=500))
    assert np.abs(stiction.series.swinging_door(walk, 0.5) - walk).max() <= 0.5 + 1e-12


def test_crossings():
    wave = np.sin(2 * np.pi * (np.arange(200) + 0.3) / 20)
    found = stiction.series.zero_crossings(wave)
    assert found.upward.tolist() == [bool(k % 2) for k in range(len(found.place))]
    assert np.diff(found.place) == pytest.approx(10, abs=1e-6)
    waves = stiction.series.half_waves(wave)
    assert waves.length == pytest.approx(waves.end - waves.begin) and len(waves.length) == len(found.place) - 1
    for first, stop, above in zip(waves.first, waves.stop, waves.above):
        assert ((wave[first:stop] > 0) == above).all()
    assert stiction.series.reversals(wave, 0.5) == 20 and stiction.series.reversals(wave, 3.0) == 0
    assert stiction.series.cycle_period(wave, 0.5) == pytest.approx(10)
    assert stiction.series.cycle_period([1, 2, 3]) is None


def test_trends_and_groups():
    assert stiction.series.mann_kendall([1, 1, 1]) == 1 and stiction.series.mann_kendall(np.arange(20)) < 1e-6
    a, b = RNG.normal(size=15), 1 + 2 * RNG.normal(size=12)
    expected = scipy.stats.ttest_ind(a, b, equal_var=False).pvalue
    assert stiction.series.difference_of_means(a, b) == pytest.approx(expected, rel=1e-9)
    exact = scipy.stats.permutation_test(
        (a[:4], b[:5]), lambda x, y, axis: x.mean(axis) - y.mean(axis), vectorized=True, n_resamples=np.inf
    )
    # SciPy doubles the smaller tail; both count the same partitions.
    null = np.abs(exact.null_distribution - exact.null_distribution.mean())
    seen = abs(a[:4].mean() - b[:5].mean() - exact.null_distribution.mean())
    assert stiction.series.difference_of_means(a[:4], b[:5]) == pytest.approx((null >= seen - 1e-9).mean())
    assert stiction.series.difference_of_means([1], [1, 2]) is None


def test_results_are_results():
    found = stiction.series.zero_crossings([-1, 1, 2, -2])
    again = pickle.loads(pickle.dumps(found))
    assert repr(again) == repr(found) and set(found.to_dict()) == {"place", "next", "upward"}
    place, *_ = found
    assert place is found.place


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: stiction.series.zero_crossings([]), (TypeError, ValueError), "x"),
        (lambda: stiction.series.zero_crossings([1, np.nan]), ValueError, "sample 1 of x is NaN"),
        (lambda: stiction.series.half_waves("a"), (TypeError, ValueError), "x"),
        (lambda: stiction.series.reversals([1, 2], -1), ValueError, "band is -1"),
        (lambda: stiction.series.cycle_period([1, 2], 0), ValueError, "sample_time is 0, but must be"),
        (lambda: stiction.series.cycle_period([1, 2], noise_band="a"), TypeError, "noise_band must be a number"),
        (lambda: stiction.series.swinging_door([1, 2], np.nan), ValueError, "deviation is nan"),
        (lambda: stiction.series.difference_of_means([1, 2], [np.nan, 1]), ValueError, "sample 0 of b is NaN"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
