"""The estimators for scikit-learn."""

import numpy as np
import pandas as pd
import pytest
import stiction

pytest.importorskip("sklearn")
from pathlib import Path

from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import GridSearchCV, cross_val_score
from stiction.sklearn import StictionDetector, StictionQuantifier

SAMPLES = sorted((Path(__file__).parents[2] / "samples").glob("*IC*.csv"))
STICKS = np.array(["sticky" in path.name or "cascade" in path.name for path in SAMPLES])


@pytest.fixture(scope="module")
def loops():
    return [stiction.read(path)[0] for path in SAMPLES]


def test_a_classifier_of_recordings(loops):
    detector = StictionDetector().fit(loops, STICKS)
    proba = detector.predict_proba(loops)
    assert proba.shape == (5, 2) and np.allclose(proba.sum(axis=1), 1)
    expected = [each.verdict.probability for each in stiction.diagnose_all(loops)]
    assert proba[:, 1].tolist() == expected
    assert np.array_equal(detector.predict(loops), STICKS) and detector.score(loops, STICKS) == 1
    assert roc_auc_score(STICKS, proba[:, 1]) == 1
    assert not StictionDetector(threshold=1).fit(loops).predict(loops[1:2]).any()


def test_what_cannot_be_reported_is_undecided():
    dead = [stiction.recording(np.full(300, 50.0), sample_time=1)]
    assert StictionDetector(undecided=0.3).fit(dead).predict_proba(dead)[0, 1] == 0.3
    assert np.isnan(StictionQuantifier().fit(dead).predict(dead)).all()


def test_a_regressor_of_recordings(loops):
    sticky = [loop for loop, sticks in zip(loops, STICKS) if sticks]
    quantifier = StictionQuantifier().fit(sticky, [4, 5])
    s, interval = quantifier.predict(sticky), quantifier.predict_interval(sticky)
    assert np.all(interval[:, 0] <= s) and np.all(s <= interval[:, 1]) and interval.shape == (2, 2)
    assert interval[0, 0] <= 4 <= interval[0, 1]
    assert quantifier.predict([]).shape == (0,)


def test_parameters_and_clones(loops):
    detector = StictionDetector(threshold=0.8)
    assert clone(detector).get_params() == {
        "loop_type": None,
        "sample_time": None,
        "threshold": 0.8,
        "undecided": 0.5,
    }
    assert clone(StictionQuantifier("J")).set_params(quantity="S").quantity == "S"
    search = GridSearchCV(StictionDetector(), {"threshold": [0.3, 0.9]}, cv=2)
    assert search.fit(loops[:4], STICKS[:4]).best_score_ > 0.5


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda: StictionDetector().predict([]), NotFittedError, "not fitted"),
        (lambda: StictionDetector(threshold=2).fit([]), ValueError, "threshold is 2, but must be between 0 and 1"),
        (lambda: StictionDetector().fit([3]), TypeError, r"X\[0\] must be a Recording or a table"),
        (lambda: StictionDetector().fit([], np.ma.array([1], mask=[True])), ValueError, "y has masked values"),
        (lambda: StictionDetector().fit([], [1]), ValueError, r"y has the shape \(1,\), but X holds 0 recordings"),
        (lambda: StictionQuantifier("K").fit([]), ValueError, "quantity is 'K'"),
    ],
)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_labels_are_truth_values(loops):
    with pytest.raises(ValueError, match="y must hold truth values"):
        StictionDetector().fit(loops[:2], ["sticky", "healthy"])


@pytest.fixture(scope="module")
def cases():
    kinds = ["sticky-flow", "disturbed-flow", "aggressive-flow"]
    runs = [stiction.simulate(f"samples/{kind}") for kind in kinds]
    return np.array([[run.op, run.pv, run.sp] for run in runs] * 2), np.array([1, 0, 0] * 2)


def test_arrays_of_cases_channels_and_time(cases):
    X, y = cases
    detector = StictionDetector(sample_time=1).fit(X, y)
    assert detector.classes_.tolist() == [False, True]
    one = stiction.diagnose(*X[0], sample_time=1, detectors="none").verdict.probability
    assert detector.predict_proba(X)[0, 1] == one
    assert detector.predict(X).astype(int).tolist() == y.tolist()
    assert detector.predict_proba(X[:, :2]).shape == (6, 2)
    assert StictionQuantifier(sample_time=1).fit(X).predict(X[:1])[0] == pytest.approx(4, abs=1)


def test_they_are_cross_validated(cases):
    assert cross_val_score(StictionDetector(sample_time=1), *cases, cv=2).tolist() == [1, 1]


def test_tables_are_cases(loops):
    frame = pd.read_csv(SAMPLES[0])
    assert StictionDetector().fit([frame]).predict([frame]).tolist() == [True]
    untimed = [frame.drop(columns="t")]
    assert StictionDetector(sample_time=1).fit(untimed).predict(untimed).tolist() == [True]


@pytest.mark.parametrize(
    "fit, error, words",
    [
        (lambda: StictionDetector().fit(np.ones((2, 3, 50))), ValueError, "sample_time must be given with an array"),
        (lambda: StictionDetector(sample_time=1).fit(np.ones((2, 4, 50))), ValueError, "2 or 3 channels: OP, PV and SP"),
        (lambda: StictionDetector().fit(pd.DataFrame({"op": [1.0]})), TypeError, "a list of recordings or tables, but is one table"),
    ],
)
def test_other_cases_are_refused(fit, error, words):
    with pytest.raises(error, match=words):
        fit()
