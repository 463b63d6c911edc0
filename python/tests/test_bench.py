"""The benchmark: any detector, the same numbers by each door, and detectors that misbehave."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import stiction
from stiction import bench

SUITE = "v1-trial"


def evenness(recording):
    op = recording.op - recording.op.mean()
    if not op.any():
        return "abstain"
    score = -np.mean(op**4) / np.mean(op**2) ** 2
    return {"score": score, "decision": "sticks" if score > -1.9 else "does not stick", "S": np.float64(2)}


def wild(recording):
    k = int(recording.name[-5:])
    if k == 10:
        raise ValueError("a matrix\nof no rank")
    if k == 20:
        return float("nan")
    if k == 30:
        time.sleep(60)
    if k == 40:
        return "perhaps"
    if k == 50:
        return [1]
    if k == 60:
        return {"probability": 2}
    return k % 7


def deadly(recording):
    k = int(recording.name[-5:])
    if k == 10:
        os._exit(7)
    if k == 30:
        while True:
            pass
    return k % 7


def _command():
    """Give the command beside this clone, which the tests of CI before these have built."""
    root = Path(__file__).parents[2]
    for folder in (os.environ.get("CARGO_TARGET_DIR"), root / "target"):
        for profile in ("debug", "release"):
            command = Path(folder or root) / profile / "stiction"
            if command.is_file():
                return str(command)
    pytest.skip("the command is not built")


def timeless(found):
    """The entries without what depends on time."""
    entries = found.to_dict()["entries"]
    for entry in entries:
        entry.pop("time")
        for answer in entry["answers"]:
            answer.pop("time_s", None)
    return entries


def test_suites_are_known_and_hide_their_truth():
    assert {name: len(bench.suite(name)) for name in bench.suites()} == {"v1": 4000, SUITE: 120, "v1-training": 10000}
    loops = bench.suite(SUITE)
    assert loops[-1] == loops[119] and loops[3:5] == [loops[3], loops[4]]
    assert isinstance(loops[0], stiction.recordings.Recording) and loops[0].name == "v1-trial-00000"
    hidden = bench.suite(SUITE, passphrase="a long passphrase")
    assert hidden[0] != loops[0] and hidden[0] == bench.suite(SUITE, passphrase="a long passphrase")[0]
    for wrong in [{"name": "v0"}, {"passphrase": "short"}, {"name": "v1-training", "passphrase": "a long passphrase"}]:
        with pytest.raises(ValueError, match="v1|16 characters"):
            bench.suite(**{"name": SUITE, **wrong})


def test_training_loops_are_labelled_and_in_no_suite():
    recordings, labels = bench.training(60, first=20)
    assert len(recordings) == len(labels) < 60 and 0 < labels.mean() < 1 and labels.dtype == bool
    tested = {each.op.tobytes() for each in bench.suite(SUITE)}
    assert not tested & {each.op.tobytes() for each in recordings}
    with pytest.raises(ValueError, match="10000 loops"):
        bench.training(2, first=9999)


def test_results_have_every_form(tmp_path):
    done = []
    found = bench.run({"even": evenness, "odd": lambda r: -len(r.op)}, SUITE, version="1.2", progress=done.append)
    assert done[-1] == 120 and done == sorted(done)
    table = found.table().to_pandas()
    assert list(table.detector) == ["even", "odd"]
    measured = found.to_dict()
    first = measured["entries"][0]
    assert first["detector"] == {
        "name": "even", "version": "1.2", "command": "stiction.bench.run(evenness, 'v1-trial')"
    }
    assert table.auc[0] == first["measures"]["auc"]["value"]
    assert table.recall[0] == first["measures"]["decisions"]["recall"]["value"]
    assert table.auc_low[0] <= table.auc[0] <= table.auc_high[0]
    assert first["measures"]["S"]["quantified"]["k"] > 0 and not found.failures()
    assert "even" in repr(found) and "| even |" in found.to_markdown() and "Leaderboard" in found.to_html()
    for name in ["both.json", "both.md", "both.html"]:
        found.save(tmp_path / name)
    assert (tmp_path / "both.html").read_text().startswith("<!DOCTYPE html>")
    with pytest.raises(ValueError, match="must end in"):
        found.save(tmp_path / "both.txt")
    again = bench.read(tmp_path / "both.json")
    assert again.to_json() == found.to_json()
    bench.run(evenness, SUITE, name="even").save(tmp_path / "one.json")
    names = bench.read(tmp_path / "one.json", tmp_path / "both.json").table()["detector"]
    assert names[0] == "even" and names[1].startswith("even (") and names[2] == "odd"
    bench.run(evenness, SUITE, passphrase="a long passphrase").save(tmp_path / "hidden.json")
    with pytest.raises(ValueError, match="passphrase"):
        bench.read(tmp_path / "hidden.json")
    with pytest.raises(ValueError, match="about other loops"):
        bench.read(tmp_path / "one.json", tmp_path / "hidden.json", passphrase="a long passphrase")
    assert len(bench.read(tmp_path / "hidden.json", passphrase="a long passphrase").table()) == 1


PROGRAM = """
import json, sys
import stiction
from stiction import bench

horch = bench.method("horch")
for line in sys.stdin:
    r = json.loads(line)
    signals = [r.get(key) for key in ("op", "pv", "sp", "vp")]
    each = stiction.recording(*signals, sample_time=r["sample_time_s"], name=r["id"], loop_type=r["type"])
    print(bench.answer(each, horch(each)), flush=True)
"""


def test_our_own_answers_are_those_of_the_command(tmp_path):
    own = {"verdict": bench.verdict, "horch": bench.method("horch")}
    found = {entry["detector"]["name"]: entry for entry in timeless(bench.run(own, SUITE))}
    command = _command()
    line = [command, "bench", "detector", "--suite", SUITE, "--method", "horch", "--json"]
    printed = json.loads(subprocess.run(line, capture_output=True, check=True, text=True).stdout)
    for entry in printed["entries"]:
        name = entry["detector"]["name"]
        if name in found:
            assert entry["sha256"] == found[name]["sha256"] and entry["measures"] == found[name]["measures"]
    # And a Python program through standard input.
    (tmp_path / "program.py").write_text(PROGRAM)
    detector = f"{sys.executable} program.py"
    line = [command, "bench", "detector", detector, "--suite", SUITE, "--json"]
    printed = json.loads(subprocess.run(line, capture_output=True, check=True, text=True, cwd=tmp_path).stdout)
    [entry] = printed["entries"]
    assert entry["sha256"] == found["horch"]["sha256"] and entry["measures"] == found["horch"]["measures"]


def test_the_verdict_is_that_of_diagnose():
    loops = bench.suite(SUITE)[:20]
    for each in loops:
        said, verdict = bench.verdict(each), stiction.diagnose(each, detectors="none").verdict
        assert said.get("probability") == verdict.probability
        called = {"sticks": "sticks", "does not respond": "sticks", "does not stick": "does not stick"}
        assert said["decision"] == called.get(verdict.class_, "abstain")


@pytest.mark.skipif(not hasattr(__import__("signal"), "setitimer"), reason="no timers here")
def test_what_misbehaves_is_listed():
    found = bench.run(wild, SUITE, limit=0.5)
    reasons = {loop[-2:]: reason for _, loop, reason in found.failures()}
    wanted = {
        "10": "ValueError: a matrix",
        "20": "NaN",
        "30": "no answer within 0.5 s",
        "40": "must be",
        "50": "TypeError: the answer must be a number",
        "60": "between 0 and 1",
    }
    assert reasons.keys() == wanted.keys()
    for number, words in wanted.items():
        assert words in reasons[number], reasons[number]
    assert found.table()["answered"] == [114 / 120]


def test_processes_survive_what_ends_them():
    assert timeless(bench.run(evenness, SUITE, processes=2)) == timeless(bench.run(evenness, SUITE))
    found = bench.run(deadly, SUITE, processes=2, limit=1.5)
    # The first answer of a process may take longer, so a hang is noticed only after an answer.
    reasons = {loop[-2:]: reason for _, loop, reason in found.failures()}
    assert reasons.keys() == {"10", "30"}
    assert "exit code 7" in reasons["10"] and "no answer within" in reasons["30"]


def test_an_estimator_is_fitted_on_training_loops():
    sklearn = pytest.importorskip("sklearn")
    from sklearn.linear_model import LogisticRegression
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import FunctionTransformer
    from sklearn.svm import LinearSVC

    assert sklearn

    def features(recordings):
        # NaN of a record that says too little makes the whole batch fail.
        return np.array([[np.log1p(np.ptp(r.op)), np.mean(np.diff(r.op) == 0)] for r in recordings])

    def made(last):
        return make_pipeline(FunctionTransformer(features), last)

    found = bench.run({"p": made(LogisticRegression()), "svm": made(LinearSVC())}, SUITE, train=150)
    entries = found.to_dict()["entries"]
    assert entries[0]["measures"]["calibration"]["n"] > 60 and entries[1]["measures"]["calibration"] is None
    assert not found.failures() and all(entry["measures"]["auc"] for entry in entries)


@pytest.mark.parametrize(("baseline", "needs"), [("boosting", "sklearn"), ("multirocket", "aeon"), ("convolution", "jax")])
def test_the_baselines_of_the_examples_run(tmp_path, baseline, needs):
    pytest.importorskip(needs, reason=f"{needs} is in examples/baselines/requirements.txt only")
    baselines = Path(__file__).parents[2] / "examples/baselines/baselines.py"
    asked = [sys.executable, str(baselines), baseline, "--train", "200", "--suite", SUITE]
    done = subprocess.run(asked, cwd=tmp_path, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    found = bench.read(tmp_path / f"{baseline}.json")
    assert f"{baseline}: AUC" in repr(found) and "answered 100%" in repr(found)


def test_an_estimator_that_fails_on_one_loop_answers_the_others():
    class Picky:
        def fit(self, X, y):
            return self

        def predict(self, X):
            if any(each.name.endswith("07") for each in X):
                raise RuntimeError("seven")
            return [len(each.op) > 700 for each in X]

    found = bench.run(Picky(), SUITE, train=20)
    assert [(loop[-2:], reason) for _, loop, reason in found.failures()] == [("07", "RuntimeError: seven")] * 2


def test_labelled_recordings_are_cross_validated_by_valve(tmp_path):
    class Memory:
        """Knows only the recordings that it was fitted on, by the first value of their OP."""

        def fit(self, X, y):
            self.known = {each.op[0] for each in X}
            assert len(X) == len(y)
            return self

        def decision_function(self, X):
            return np.array([float(each.op[0] in self.known) for each in X])

        def predict(self, X):
            return self.decision_function(X) > 0

    # Two recordings of each of twelve valves, which begin with the same OP.
    loops = [
        stiction.recording([k, 1, 2, 3], sample_time=1, name=f"{k}-{half}") for k in range(12) for half in range(2)
    ]
    valves = [each.name.split("-")[0] for each in loops]
    suite = bench.labelled(loops, [k % 4 < 2 for k in range(24)], valves=valves, licences=["CC0"] * 24)
    found = bench.run(Memory(), suite)
    answers = found.to_dict()["entries"][0]["answers"]
    assert [answer["score"] for answer in answers] == [0.0] * 24
    assert found.to_dict()["loops"]["labels"][0] == {
        "id": "0-0", "valve": "0", "sticks": True, "source": "", "licence": "CC0"
    }
    found.save(tmp_path / "own.json")
    assert bench.read(tmp_path / "own.json").to_json() == found.to_json()
    for wrong, words in [
        ({"sticks": [True]}, "equal lengths"),
        ({"sticks": [True] * 24}, "labels of both classes"),
        ({"recordings": [loops[0]] * 24}, "same name"),
    ]:
        with pytest.raises(ValueError, match=words):
            bench.labelled(**{"recordings": loops, "sticks": [k % 2 for k in range(24)], **wrong})


@pytest.mark.parametrize(
    ("said", "line"),
    [
        (1, {"score": 1.0}),
        ("abstain", {"decision": "abstain"}),
        (None, {"decision": "abstain"}),
        (np.True_, {"decision": "sticks"}),
        (False, {"decision": "does not stick"}),
        ({"probability": np.float32(0.5), "S": None, "id": "x"}, {"probability": 0.5}),
    ],
)
def test_answers_are_lines(said, line):
    each = bench.suite(SUITE)[0]
    assert json.loads(bench.answer(each, said)) == {"id": each.name, **line}


def test_arguments_are_checked():
    for arguments, error, words in [
        ((3,), TypeError, "function of a recording"),
        (({},), ValueError, "empty mapping"),
        ((evenness, "v7"), ValueError, "v1-trial"),
    ]:
        with pytest.raises(error, match=words):
            bench.run(*arguments)
    for more, error in [({"limit": 0}, ValueError), ({"processes": -1}, ValueError), ({"progress": 3}, TypeError)]:
        with pytest.raises(error):
            bench.run(evenness, SUITE, **more)
    with pytest.raises(ValueError, match="no-such"):
        bench.method("no-such")(bench.suite(SUITE)[0])
