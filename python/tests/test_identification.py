"""Oscillation, detectors and fits, against the reference in the repository and against known truth."""

import gzip
import json
import pickle
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
import pytest
import stiction

matplotlib.use("Agg")
import matplotlib.pyplot as plt

FIXTURES = Path(__file__).parents[2] / "crates" / "stiction-diagnose" / "tests" / "fixtures" / "detect"
REFERENCE = json.loads((FIXTURES / "detectors.json").read_text())


@pytest.fixture(scope="module")
def scenarios():
    with gzip.open(FIXTURES / "detector_scenarios.csv.gz", "rt") as file:
        return dict(list(pd.read_csv(file).groupby("scenario")))


@pytest.fixture(scope="module")
def sticky():
    return stiction.simulate("samples/sticky-flow")


@pytest.mark.parametrize("name", REFERENCE["scenarios"])
def test_detectors_are_the_reference(name, scenarios):
    rows, expected = scenarios[name], REFERENCE["scenarios"][name]
    signals = [rows[column].to_numpy() for column in ("op", "pv", "sp")]
    given = {"sample_time": 0.1, "period_s": expected["acf_period_s"]}

    def close(found, wanted):
        assert found == pytest.approx(wanted, rel=1e-6, abs=1e-9)

    flow, level = ({**given, "loop_type": kind} for kind in ("flow", "level"))
    close(stiction.detect("curve-fit", *signals, **flow).statistic, expected["he_SI_op"])
    close(stiction.detect("curve-fit", *signals, **level).statistic, expected["he_SI_pv"])
    close(stiction.detect("area-ratio", *signals, **flow).numbers["mean ratio"], expected["area_ratio_e"])
    horch = stiction.detect("horch", *signals, **flow)
    for number, key in (("delta tau", "dtau"), ("delta rho", "drho")):
        close(horch.numbers[number], expected["horch"][key])
    close(stiction.detect("yamashita", *signals, **flow).statistic, expected["yamashita_pv"][0])


def test_every_detector_answers_or_says_why(sticky):
    found = stiction.detection.detect_all(sticky.op, sticky.pv, sticky.sp, sticky.vp, sample_time=1, loop_type="flow")
    described = {method.name: method for method in stiction.detection.detectors()}
    assert list(found) == list(described)
    for name, finding in found.items():
        assert finding.reason and (finding.decision == "abstains" or finding.statistic is not None)
        assert set(finding.numbers) == set(finding.units) and finding.parameters == described[name].parameters
        assert finding.family == described[name].family
        assert repr(pickle.loads(pickle.dumps(finding))) == repr(finding)
        alone = stiction.detect(name, sticky.op, sticky.pv, sticky.sp, sticky.vp, sample_time=1, loop_type="flow")
        assert alone.to_dict() == finding.to_dict()
    assert found["direct"].decision == "sticks"


def test_without_an_oscillation_its_cause_is_not_reported():
    noise = np.random.default_rng(1).normal(size=(2, 900))
    finding = stiction.detect("horch", *noise, sample_time=1, loop_type="flow")
    assert finding.decision == "abstains" and "none was found" in finding.reason


def test_oscillations():
    t = np.arange(3000.0)
    rng = np.random.default_rng(2)
    found = stiction.oscillations.oscillation(np.sin(2 * np.pi * t / 60) + 0.1 * rng.normal(size=3000), 2)
    assert found.found and found.basis == "autocorrelation" and abs(found.period_s / 120 - 1) < 0.01
    assert found.regularity > 1 and found.decay_ratio > 0.5 and abs(found.amplitude - 1) < 0.1
    assert found.peaks[0].is_oscillation and found.episodes[0].to_s > 5000
    none = stiction.oscillations.oscillation(rng.normal(size=3000), 2)
    assert not none.found and none.basis is None and none.reasons


def test_a_process_is_identified():
    steps = np.repeat(np.random.default_rng(4).normal(size=60), 20)
    pv, a = np.zeros(1200), np.exp(-0.5 / 6)
    for k in range(4, 1200):
        pv[k] = a * pv[k - 1] + (1 - a) * 1.5 * steps[k - 4]
    fit = stiction.identification.fit_first_order(steps, pv, sample_time=0.5)
    for name, truth in {"gain": 1.5, "time_constant_s": 6, "dead_time_s": 1.5}.items():
        assert abs(getattr(fit, name) / truth - 1) < 0.02, name
    assert fit.explained > 0.999 and len(fit.pv) == 1200 and fit.delay == 4


def test_bands_are_found(sticky):
    for method in ("srinivasan", "lee", "jelali", "karra-karim"):
        fit = stiction.identification.fit_hammerstein(sticky.op, sticky.pv, sample_time=1, method=method)
        assert fit.sticks == (fit.gain > fit.threshold) == (method != "srinivasan")
        assert (fit.cause is not None) == (method == "karra-karim")
        finding = stiction.detect(method, sticky.op, sticky.pv, sticky.sp, sample_time=1, loop_type="flow")
        assert finding.numbers["S"] == fit.S and finding.statistic == fit.gain
    valve = stiction.identification.weigh_valve(sticky.op, sticky.pv, sample_time=1)
    assert valve.two_phase.gain > 0.1 and valve.best in {"two-phase", "he"} and valve.over_placebo > 0
    fits = stiction.identification.fit_position(sticky.op, sticky.vp)
    assert abs(fits.S.value - 4) < 0.1 and abs(fits.J.value - 2) < 0.1 and fits.S.low <= fits.S.value <= fits.S.high
    assert fits.ranked[0].explained > 0.99


def test_a_stem_is_found():
    k = np.arange(1500)
    op = 50 + 9 * np.sin(0.045 * k) + 5 * np.sin(0.0173 * k)
    fit = stiction.identification.fit_stem(op, stiction.valve(op, S=6, J=2), sample_time=1)
    assert abs(fit.bands.S - 6) < 1 and fit.explained > 0.98
    assert fit.static_band.value >= fit.coulomb_band.value > 0
    assert repr(pickle.loads(pickle.dumps(fit))) == repr(fit)


def test_an_arx_model():
    rng = np.random.default_rng(3)
    op = 50 + rng.normal(size=2000)
    pv = np.full(2000, 20.0)
    for k in range(4, 2000):
        pv[k] = 1 + 0.8 * pv[k - 1] + 0.3 * op[k - 4] + 0.001 * rng.normal()
    fit = stiction.identification.fit_arx(op[200:], pv[200:], longest_delay=10)
    assert 1 <= fit.delay <= 4 and abs(fit.gain - 1.5) < 0.01
    assert abs(fit.taps[4 - fit.delay] - 0.3) < 1e-3 and abs(fit.past[0] - 0.8) < 0.1
    assert 0.0009 < fit.residual_std < 0.0011 and fit.explained > 0.999
    assert np.allclose(fit.predicted, pv[200:], atol=0.01) and fit.predicted[0] == pv[200]


def test_an_extended_arx_model():
    rng = np.random.default_rng(3)
    x = np.sign(np.sin(0.1 * np.arange(800)))
    y = np.zeros(800)
    for k in range(2, 800):
        y[k] = 0.6 * y[k - 1] + 0.3 * x[k - 2] + 0.01 * rng.normal()
    fit = stiction.identification.fit_extended_arx(x, y, delay=1, walk=0)
    process, disturbance = fit.process, fit.disturbance
    assert fit.variance < 1e-3 and abs(sum(fit.taps) / (1 - sum(fit.past)) - 0.75) < 0.05
    assert np.allclose((process + disturbance)[100:], fit.predicted[100:], atol=0.05)


def test_profiles_are_drawn(sticky):
    fit = stiction.identification.fit_hammerstein(sticky.op, sticky.pv, sample_time=1)
    ax = fit.plot()
    assert ax.get_xlabel() == "S (% of span)" and ax.get_legend() is not None
    assert fit.plot(ax) is ax
    plt.close("all")


def test_the_frozen_model_says_where_it_comes_from():
    model = stiction.fusion.verdict_model()
    assert model.features == [feature.name for feature in stiction.fusion.evidence_features()]
    assert model.trained > 0 and "train" in model.command and model.coverage == 0.9


def test_evidence_of_the_op_alone(sticky):
    seen = stiction.evidence(sticky.op, sample_time=1)
    op_only = {feature.name for feature in stiction.fusion.evidence_features() if feature.op_only}
    measured = {name for name, value in seen.values.items() if not np.isnan(value)}
    assert seen.op_only and op_only & measured and 0 <= stiction.weigh(seen).probability <= 1


WAVE = np.sin(0.1 * np.arange(600))
GAP = np.where(np.arange(600) == 7, np.nan, WAVE)
BAD = [
    (lambda: stiction.oscillations.oscillation(WAVE, 0), ValueError, "sample_time is 0"),
    (lambda: stiction.oscillations.oscillation(GAP, 1), ValueError, "sample 7 of signal is NaN"),
    (lambda: stiction.oscillations.oscillation("wave", 1), (TypeError, ValueError), "signal"),
    (lambda: stiction.detect("x", WAVE, sample_time=1), ValueError, 'no detector named "x"'),
    (lambda: stiction.detect(3, WAVE, sample_time=1), TypeError, "method must be a string"),
    (lambda: stiction.detect("horch", WAVE, WAVE[:9], sample_time=1), ValueError, "pv"),
    (lambda: stiction.detect("horch", WAVE, GAP, sample_time=1), ValueError, "sample 7 of pv is NaN"),
    (lambda: stiction.detect("horch", WAVE, WAVE, sample_time=1, period_s=-1), ValueError, "period_s is -1"),
    (lambda: stiction.detect("horch", WAVE, WAVE, sample_time=1, loop_type="x"), ValueError, "loop type"),
    (lambda: stiction.detection.detect_all(WAVE, sample_time=float("nan")), ValueError, "sample_time is nan"),
    (lambda: stiction.identification.fit_first_order(WAVE[:9], WAVE[:9], sample_time=1), ValueError, "at least 120 samples"),
    (lambda: stiction.identification.fit_first_order(WAVE, WAVE, sample_time=1, longest_delay=0), ValueError, "longest_delay is 0"),
    (lambda: stiction.identification.fit_first_order(WAVE, WAVE, sample_time=1, longest_delay=1.5), TypeError, "longest_delay"),
    (lambda: stiction.identification.fit_arx(WAVE, WAVE[:9]), ValueError, "there are 600 and 9"),
    (lambda: stiction.identification.fit_arx(WAVE, np.ones(600)), ValueError, "does not move"),
    (lambda: stiction.identification.fit_arx(WAVE, WAVE, longest_delay=0), ValueError, "longest_delay is 0"),
    (lambda: stiction.identification.fit_extended_arx(WAVE, WAVE[:9], delay=1, walk=0), ValueError, "input has 600 samples"),
    (lambda: stiction.identification.fit_extended_arx(WAVE, WAVE, delay=0, walk=0), ValueError, "delay is 0"),
    (lambda: stiction.identification.fit_extended_arx(WAVE, WAVE, delay=1, walk=-1), ValueError, "walk is -1"),
    (lambda: stiction.identification.fit_extended_arx(WAVE[:9], WAVE[:9], delay=1, walk=0), ValueError, "nothing can be fitted"),
    (lambda: stiction.identification.fit_hammerstein(WAVE, WAVE, sample_time=1, method="x"), ValueError, "method is 'x'"),
    (lambda: stiction.identification.fit_hammerstein(WAVE, GAP, sample_time=1), ValueError, "sample 7 of pv is NaN"),
    (lambda: stiction.identification.fit_hammerstein(WAVE, 0 * WAVE, sample_time=1, period_s=60), ValueError, "does not move"),
    (lambda: stiction.identification.weigh_valve(WAVE[:50], WAVE[:50], sample_time=1, period_s=20), ValueError, "needs at least"),
    (lambda: stiction.identification.fit_position(WAVE, WAVE[:9]), ValueError, "600 and 9"),
    (lambda: stiction.identification.fit_position(WAVE, 0 * WAVE), ValueError, "move"),
    (lambda: stiction.identification.fit_stem(WAVE, WAVE, sample_time=0), ValueError, "sample_time is 0"),
    (lambda: stiction.evidence(0 * WAVE, sample_time=1), ValueError, "never moves|does not move"),
    (lambda: stiction.weigh(3), TypeError, "evidence must be an Evidence"),
    (
        lambda: stiction.weigh(stiction.fusion.Evidence(values={}, op_span=1, period_s=1, op_only=False)),
        ValueError,
        "evidence has no value of",
    ),
    (
        lambda: stiction.identification.bands_of_cycle(
            1, 1, process_gain=3, controller_gain=0.2, time_constant_s=10, dead_time_s=10
        ),
        ValueError,
        "short|period",
    ),
]


@pytest.mark.parametrize("call, error, words", BAD)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
