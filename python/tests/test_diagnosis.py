"""Diagnoses: what the command line says, the same from every source and on every thread."""

import json
import os
import pickle
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime, timezone
from html import unescape
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
import stiction
from stiction._result import result_of

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[2]
SAMPLES = sorted((ROOT / "samples").glob("*IC*.csv"))
STICKY = ROOT / "samples" / "FIC101-sticky.csv"


@pytest.fixture(scope="module")
def recordings():
    return [stiction.read(path)[0] for path in SAMPLES]


@pytest.fixture(scope="module")
def diagnoses(recordings):
    return stiction.diagnose_all(recordings)


@pytest.fixture(scope="module")
def sticky(diagnoses):
    return diagnoses[0]


def _said(diagnosis):
    """The document of a diagnosis, less where it comes from."""
    [loop] = diagnosis.to_dict()["loops"]
    if loop["verdict"]["confirm"] is not None:
        # The sheet of a test has the name of the loop.
        del loop["verdict"]["confirm"]["name"]
    return {key: value for key, value in loop.items() if key not in {"loop", "source"}}


def test_the_truth_of_the_samples(diagnoses):
    truth = pd.read_csv(ROOT / "samples" / "truth.csv").set_index("file")
    assert len(diagnoses) == len(truth) == 5
    for path, diagnosis in zip(SAMPLES, diagnoses):
        wrong = "does not stick" if truth.loc[path.name, "label"] == "stiction" else "sticks"
        assert diagnosis.verdict.class_ != wrong
        s = diagnosis.stiction.S
        assert s is None or s.low <= truth.loc[path.name, "S"] <= s.high


def test_the_numbers_of_the_command_line(sticky):
    # Those that the command line's own tests look for.
    assert sticky.name == "FIC101-sticky" and sticky.loop_type == "flow" and sticky.fitness.class_ == "fit"
    assert sticky.verdict.class_ == "sticks" and sticky.verdict.probability > 0.98
    assert sticky.oscillating_signal == "error" and round(sticky.oscillation.period_s, 2) == 73.86
    assert sticky.judged.samples == 2400 and sorted(sticky.judged.signals) == ["OP", "PV", "SP"]
    assert sticky.findings["direct"].decision == "abstains"
    assert sticky.verdict.confirm.grow[0].op == 0.56 and sticky.verdict.confirm.instructions
    assert abs(sticky.stiction.S.value - 4) < 0.5 and sticky.stiction.coverage == 0.9
    assert sticky.kpis["Harris index"].value is not None
    assert len(sticky.findings) == len(stiction.detection.detectors()) >= 20


def _command():
    """The command line that was built beside this package, if there is one."""
    for folder in (os.environ.get("CARGO_TARGET_DIR"), ROOT / "target"):
        for profile in ("release", "debug"):
            program = Path(folder or "", profile, "stiction")
            if folder and program.exists():
                return program
    return None


@pytest.mark.skipif(_command() is None, reason="the command line is not built")
def test_the_document_is_that_of_the_command_line(diagnoses):
    files = [str(path) for path in SAMPLES]
    run = subprocess.run([_command(), "diagnose", *files, "--json"], capture_output=True, text=True, check=True)
    assert stiction.diagnosis.document(diagnoses) == json.loads(run.stdout)


def test_attributes_and_document_agree(diagnoses):
    for diagnosis in diagnoses:
        [loop] = diagnosis.to_dict()["loops"]
        assert loop["verdict"]["class"] == diagnosis.verdict.class_
        assert loop["verdict"]["probability"] == diagnosis.verdict.probability
        assert loop["oscillation"]["period_s"] == diagnosis.oscillation.period_s
        assert loop["stiction"]["S"] == (diagnosis.stiction.S and diagnosis.stiction.S.to_dict())
        assert [each["statistic"] for each in loop["detectors"]] == [f.statistic for f in diagnosis.findings.values()]
        for detector in loop["detectors"]:
            assert len(detector["numbers"]) == len(diagnosis.findings[detector["name"]].numbers), detector["name"]
        assert [each["from_s"] for each in loop["windows"]] == [window.from_s for window in diagnosis.windows]
        for each, window in zip(loop["windows"], diagnosis.windows):
            assert each["S_below"] == (window.S_below and window.S_below.to_dict())
        assert loop["relation"] == diagnosis.relation and loop["no_response"] == diagnosis.no_response
        assert (loop["evidence"] and loop["evidence"]["z"]) == (diagnosis.evidence and diagnosis.evidence.z)
        assert len(loop["kpis"]) == len(diagnosis.kpis)


def test_all_sources_give_the_same_diagnosis(sticky):
    frame = pd.read_csv(STICKY)
    signals = [frame[name].to_numpy() for name in ("op", "pv", "sp")]
    made = [
        stiction.recording_from(frame, name="FIC101"),
        stiction.recording_from(pl.from_pandas(frame), name="FIC101"),
        stiction.recording_from(pa.Table.from_pandas(frame), name="FIC101"),
        stiction.recording_from(frame.to_dict(orient="list"), name="FIC101"),
        stiction.recording(*signals, sample_time=1, name="FIC101"),
        stiction.recording(*[pl.Series(signal) for signal in signals], time=frame["t"], name="FIC101"),
    ]
    for diagnosis in stiction.diagnose_all(made):
        assert _said(diagnosis) == _said(sticky)


def test_eight_threads_give_the_same(recordings, diagnoses):
    with ThreadPoolExecutor(8) as threads:
        again = list(threads.map(stiction.diagnose, recordings * 4))
    expected = stiction.diagnosis.document(diagnoses)["loops"]
    assert [stiction.diagnosis.document([each])["loops"][0] for each in again] == expected * 4


def test_progress_is_reported_and_can_stop(recordings):
    told = []
    stiction.diagnose_all(recordings, detectors="none", progress=told.append)
    assert told and told == sorted(told) and told[-1] == 5

    def stop(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stiction.diagnose_all(recordings * 20, progress=stop)


def test_every_method_that_judges_shows_its_evidence(sticky):
    segment = sticky.segment
    for name, finding in sticky.findings.items():
        seen = sticky.method_evidence(name)
        if finding.decision == "abstains":
            continue
        assert seen.method == name and seen.caption and seen.panels
        for panel in seen.panels:
            assert panel.x_label and panel.y_label and panel.series
            for x, y, style in panel.series.values():
                assert x.dtype == y.dtype == np.float64 and len(x) == len(y) > 0, style
        plt.close(seen.plot()[0].figure)
        alone = stiction.detection.method_evidence(
            name,
            segment.op,
            segment.pv,
            segment.sp,
            sample_time=1,
            period_s=sticky.oscillation.period_s,
            loop_type="flow",
        )
        assert [list(each.series) for each in alone.panels] == [list(each.series) for each in seen.panels]


def test_the_evidence_is_what_the_numbers_are_of(sticky):
    [panel] = sticky.method_evidence("horch").panels
    lag, values, style = panel.series["correlation"]
    assert style == "line" and lag[len(lag) // 2] == 0 and np.abs(values).max() <= 1
    assert panel.series["r opt, the peak"].y[0] == values[np.abs(values).argmax()]
    assert panel.series["r0, at lag 0"].y[0] == values[len(lag) // 2]
    assert stiction.detection.method_evidence("horch", np.full(600, 50.0), np.full(600, 1.0), sample_time=1) is None
    with pytest.raises(ValueError, match='no detector named "x"'):
        sticky.method_evidence("x")
    with pytest.raises(ValueError, match='no detector named "x"'):
        stiction.detection.method_evidence("x", [1.0], sample_time=1)


def test_detectors_can_be_left_out(recordings, sticky):
    none = stiction.diagnose(recordings[0], detectors="none")
    assert set(none.findings) == {"direct", "yamashita-vp"}
    assert none.verdict.probability == sticky.verdict.probability
    one = stiction.diagnose(recordings[0], detectors=["horch"])
    assert one.findings["horch"].to_dict() == sticky.findings["horch"].to_dict()


def test_the_detectors_say_the_same_alone(recordings, sticky):
    segment = sticky.segment
    signals = (segment.op, segment.pv, segment.sp)
    alone = stiction.detection.detect_all(*signals, sample_time=1, loop_type="flow")
    assert {k: v.to_dict() for k, v in alone.items()} == {k: v.to_dict() for k, v in sticky.findings.items()}
    assert stiction.recordings.fitness(recordings[0]).to_dict() == sticky.fitness.to_dict()
    assert stiction.oscillations.oscillation(segment.sp - segment.pv, 1).to_dict() == sticky.oscillation.to_dict()
    assert np.array_equal(recordings[0].op, segment.op)


def test_evidence_is_what_the_verdict_rests_on(recordings, sticky):
    recording = recordings[0]
    alone = stiction.weigh(stiction.evidence(recording.op, recording.pv, recording.sp, sample_time=1))
    assert sticky.verdict.basis == "evidence in OP and PV"
    assert abs(sum(sticky.evidence.causes.values()) - 1) < 1e-9
    if len(sticky.windows) == 1:
        of_windows = {"changes", "features", "op_range", "strangest"}
        told = {k: v for k, v in sticky.evidence.to_dict().items() if k not in of_windows}
        assert alone.to_dict().keys() == told.keys() and alone.causes == pytest.approx(sticky.evidence.causes)
        assert alone.probability == sticky.evidence.probability
        assert alone.S.to_dict() == pytest.approx(sticky.evidence.S.to_dict())
    assert set(sticky.evidence.features) == {feature.name for feature in stiction.fusion.evidence_features()}


def test_a_measured_position_decides():
    run = stiction.simulate("samples/sticky-flow")
    diagnosis = stiction.diagnose(stiction.recording(run.op, run.pv, run.sp, run.vp, sample_time=1))
    assert diagnosis.verdict.basis == "measured valve position" and diagnosis.verdict.class_ == "sticks"
    assert abs(diagnosis.stiction.S.value - 4) < 0.3 and abs(diagnosis.stiction.J.value - 2) < 1


def test_mistaken_columns_and_silent_pvs_are_named():
    op = 50 + 2 * np.sin(np.arange(1200) / 10)
    copied = stiction.diagnose(stiction.recording(op, op, sample_time=1))
    assert copied.verdict.class_ == "cannot tell" and copied.verdict.probability is None
    assert "same signal" in copied.relation.mismatch and copied.relation.remedy and copied.no_response is None
    ramp = np.linspace(5, 80, 720)
    silent = stiction.diagnose(stiction.recording(ramp, np.zeros(720), np.full(720, 40.0), sample_time=10))
    assert silent.verdict.class_ == "does not respond" and silent.relation is None and silent.few_slips is None
    told = silent.no_response
    assert told.decides and told.silence == "PV at its low end" and told.rest.error == 40
    assert [fault.name for fault in told.faults][1] == "line isolated" and all(fault.told_by for fault in told.faults)


def test_what_cannot_answer_says_so():
    dead = stiction.diagnose(stiction.recording(np.full(500, 50.0), np.full(500, 1.0), sample_time=1))
    assert dead.verdict.class_ == "cannot tell" and dead.fitness.class_ == "unfit"
    gone = stiction.diagnose(stiction.recording(np.full(500, 50.0), np.full(500, np.nan), sample_time=1))
    assert gone.verdict.class_ == "cannot tell"
    alone = stiction.diagnose(stiction.recording(50 + np.sin(np.arange(900) / 7), sample_time=1))
    assert alone.findings["horch"].reason == "needs the PV, which is not recorded"


def test_no_field_of_a_document_is_forgotten():
    found = {"value": 3.0, "low": 2.0, "high": 4.0}
    assert repr(result_of(stiction.diagnosis.Estimate, found)) == "Estimate(value=3, low=2, high=4)"
    with pytest.raises(TypeError, match=r"Estimate has no attribute for \['new'\], and its document lacks \[\]"):
        result_of(stiction.diagnosis.Estimate, {**found, "new": 1})
    with pytest.raises(TypeError, match=r"lacks \['low'\]"):
        result_of(stiction.diagnosis.Estimate, {"value": 3.0, "high": 4.0})


def test_results_show_unpack_and_pickle(sticky):
    assert repr(sticky).startswith("<Diagnosis of FIC101-sticky (flow): sticks (")
    name, loop_type, verdict, *_ = sticky
    assert (name, loop_type, verdict) == (sticky.name, sticky.loop_type, sticky.verdict)
    again = pickle.loads(pickle.dumps(sticky))
    assert repr(again) == repr(sticky)
    assert again.to_dict() == sticky.to_dict() and again.rank == sticky.rank


def test_report_and_table(diagnoses, tmp_path):
    path = tmp_path / "report.html"
    diagnoses[0].save_report(path)
    html = path.read_text(encoding="utf-8")
    assert html == diagnoses[0].to_html() and "Diagnosis of FIC101-sticky" in html
    assert "Diagnosis of 5 control loops" in stiction.diagnosis.report(diagnoses)
    frame = pl.DataFrame(stiction.summary_table(diagnoses))
    assert frame["loop"].to_list() == [diagnosis.name for diagnosis in diagnoses]
    assert frame["probability"].to_list() == [diagnosis.verdict.probability for diagnosis in diagnoses]
    assert frame["S"].to_list() == [d.stiction.S and d.stiction.S.value for d in diagnoses]
    assert stiction.summary_table([])["loop"] == []
    assert frame["override"].to_list() == [None] * len(diagnoses)
    silent = stiction.diagnose(stiction.recording(np.full(500, 50.0), np.full(500, np.nan), sample_time=1))
    assert stiction.summary_table([silent])["samples"] == [silent.judged and silent.judged.samples]


def test_plots(sticky):
    axes = sticky.plot()
    assert [ax.get_xlabel() for ax in axes] == ["time (s)", "time (s)", "OP (% of span)"]
    assert axes[0].get_legend() is not None and axes[0].get_title() == "FIC101-sticky: sticks, 98.8 %"
    _, given = plt.subplots(3)
    assert sticky.plot(given)[0] is given[0]
    with pytest.raises(ValueError, match="ax holds 1 axes, but 3 are needed"):
        sticky.plot(plt.gca())
    plt.close("all")


def test_histories(recordings):
    windows = recordings[0].split(600)
    diagnoses = stiction.diagnose_all(windows, detectors="none")
    together = stiction.diagnosis.combine(diagnoses)
    assert together.class_ == "sticks" and together.observations == len(windows) == 4
    assert diagnoses[1].observation.time_s == 900
    day = 86_400.0

    def seen(k, s, p):
        s = stiction.diagnosis.Estimate(value=s, low=0.9 * s, high=1.1 * s)
        return stiction.diagnosis.Observation(time_s=k * day, class_="sticks" if p > 0.5 else "does not stick", probability=p, S=s)

    drifting = stiction.diagnosis.combine([seen(k, 4 * 1.02**k, 0.95) for k in range(10)])
    assert drifting.drift.significant and abs(drifting.drift.per_day - np.log(1.02)) < 1e-9
    wobble = [1, 1.05, 0.97, 1.02, 0.99, 1.01]
    repaired = [seen(k, 5 * w, 0.97) for k, w in enumerate(wobble)]
    repaired += [seen(10 + k, 0.6 * w, 0.05 * w) for k, w in enumerate(wobble)]
    effect = stiction.diagnosis.repair_effect(repaired, 8 * day)
    assert (effect.outcome, effect.before, effect.after) == ("worked", 6, 6)
    assert effect.S.significant and effect.S.before > effect.S.after
    assert stiction.diagnosis.combine([]).class_ == "cannot tell"
    # A week of many windows counts for more than one of them, also without pools.
    of = [stiction.diagnosis.Observation(time_s=0, class_="cannot tell", probability=p, windows=n) for p, n in ((0.9, 1), (0.6, 100))]
    assert 0.6 < stiction.diagnosis.combine(of).probability < 0.61 and diagnoses[0].observation.windows >= 1
    # The verdict is of the valve as it is now.
    now = stiction.diagnosis.combine(repaired)
    [change] = now.changes
    assert (change.change, change.time_s, now.observations, now.class_) == ("gone", 10 * day, 6, "does not stick")


LOOP = stiction.recording(50 + np.sin(np.arange(300) / 7), np.cos(np.arange(300) / 7), sample_time=1)
BAD = [
    (lambda: stiction.diagnose("FIC101.csv"), TypeError, r"recording must be a Recording or a table, but its type is str"),
    (lambda: stiction.diagnose_all([LOOP, 3]), TypeError, r"recordings\[1\] must be a Recording"),
    (lambda: stiction.diagnose(LOOP, detectors="some"), ValueError, "detectors is 'some', but must be 'all'"),
    (lambda: stiction.diagnose(LOOP, detectors=["x"]), ValueError, 'no detector named "x"'),
    (lambda: stiction.diagnose(LOOP, detectors=[3]), TypeError, "detectors must be a string"),
    (lambda: stiction.diagnose(LOOP, detectors=[len]), TypeError, "stiction.bench.run measures a function"),
    (lambda: stiction.diagnose(LOOP, loop_type="flo"), ValueError, 'no loop type named "flo"'),
    (lambda: stiction.diagnose(LOOP, dead_time=-1), ValueError, "loop loop: the dead time is -1"),
    (lambda: stiction.diagnose(LOOP, sample_time="1"), TypeError, "sample_time must be a number"),
    (lambda: stiction.diagnose(LOOP, sample_time=0), ValueError, "the sample time is 0"),
    (lambda: stiction.diagnosis.document(3), TypeError, "int"),
    (lambda: stiction.diagnosis.document([3]), TypeError, "diagnoses must contain only Diagnosis objects, but one item is a int"),
    (lambda: stiction.diagnosis.combine([3]), TypeError, "observations must contain only Diagnosis or Observation objects"),
    (lambda: stiction.diagnosis.combine(stiction.diagnosis.Observation(time_s=0, class_="sticks")), TypeError, "observations must be a list"),
    (lambda: stiction.diagnosis.combine([stiction.diagnosis.Observation(time_s=0, class_="broken")]), ValueError, "broken"),
    (
        lambda: stiction.diagnosis.combine([stiction.diagnosis.Observation(time_s=0, class_="sticks", probability=2)]),
        ValueError,
        "probability",
    ),
    (lambda: stiction.diagnosis.repair_effect([], float("nan")), ValueError, "time of the repair"),
]


@pytest.mark.parametrize("call, error, words", BAD)
def test_bad_arguments_are_refused_by_name(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_tables_and_arrays_are_diagnosed_as_they_are(sticky):
    frame = pd.read_csv(STICKY)
    signals = [frame[name] for name in ("op", "pv", "sp")]
    untimed = frame.drop(columns="t")
    tables = [frame, pl.from_pandas(frame), pa.Table.from_pandas(frame), frame.to_dict(orient="list")]
    made = [stiction.diagnose(table, loop_type="flow") for table in tables]
    made.append(stiction.diagnose(untimed, sample_time=1, loop_type="flow"))
    made.append(stiction.diagnose(*signals, sample_time=1, loop_type="flow"))
    for diagnosis in made:
        assert _said(diagnosis) == _said(sticky)
    # Of a table with times it is the grid's.
    assert stiction.diagnose(frame, sample_time=2, detectors="none").judged.sample_time_s == 2
    assert stiction.recordings.fitness(frame).class_ == "fit" and len(stiction.recordings.segments(untimed, sample_time=1)) == 1
    assert stiction.diagnose_all([frame], detectors="none")[0].verdict.class_ == "sticks"


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda op, frame: stiction.diagnose(op), TypeError, "Recording or a table, .*stiction.recording one from arrays"),
        (lambda op, frame: stiction.diagnose(str(STICKY)), TypeError, "stiction.read makes recordings from a file"),
        (lambda op, frame: stiction.diagnose(op, op), ValueError, "sample_time must be given with arrays"),
        (lambda op, frame: stiction.diagnose(frame, sp=op), TypeError, "sp is given with a DataFrame"),
        (lambda op, frame: stiction.diagnose(frame.drop(columns="t")), ValueError, "sample_time=1"),
        (lambda op, frame: stiction.diagnose_all(frame), TypeError, "recordings must be a list, but is one table"),
    ],
)
def test_what_is_no_recording_is_refused_with_what_to_call(call, error, words):
    frame = pd.read_csv(STICKY)
    with pytest.raises(error, match=words):
        call(frame["op"].to_numpy(), frame)


def test_where_dates_are_known_plots_have_them():
    frame = pd.read_csv(STICKY)
    loop = stiction.recording(frame["op"], frame["pv"], frame["sp"], sample_time=1, start=1714550400.0)
    found = stiction.diagnose(loop, detectors="none")
    assert loop.start_time == found.start_time == datetime(2024, 5, 1, 8, tzinfo=timezone.utc)
    above, *_ = found.plot()
    assert above.get_xlabel() == "time (UTC)" and above.lines[0].get_xdata()[60] == np.datetime64("2024-05-01T08:01")
    plt.close("all")
    undated = stiction.read(STICKY)[0]
    assert undated.start_time is None and pickle.loads(pickle.dumps(found)).start_time == found.start_time


FORKED = """
import multiprocessing, signal, sys, warnings
import stiction

warnings.simplefilter("ignore")  # Python warns of forks beside threads, which is what is tried here.
paths = sys.argv[1:]
loops = [stiction.read(path)[0] for path in paths]

def verdicts(_):
    signal.alarm(60)  # Who waits for ever is ended.
    return [each.verdict.class_ for each in stiction.diagnose_all(loops, detectors="none")]

expected = verdicts(0)
with multiprocessing.get_context("fork").Pool(2) as pool:
    assert pool.map(verdicts, range(2)) == [expected] * 2
assert verdicts(0) == expected
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork on this system")
def test_a_child_of_fork_diagnoses_too():
    # A pool of threads is not copied by a fork: the workers waited for ever.
    command = [sys.executable, "-c", FORKED, *map(str, SAMPLES[:2])]
    subprocess.run(command, check=True, timeout=120)


def _texts(html):
    """The texts of a card between its tags, without its picture."""
    html = re.sub(r"<svg.*?</svg>", "", html, flags=re.DOTALL)
    return [unescape(text).strip() for text in re.split(r"<[^>]*>", html) if text.strip()]


def _contradictions(diagnosis, rules):
    """What is wrong with a card, by the rules that the pages obey, too."""
    texts = _texts(diagnosis._repr_html_())
    grade = diagnosis.verdict.grade
    wrong = [text for text in texts if any(never in text for never in rules["never"])]
    headline = texts[1]
    if not headline.startswith(grade):
        wrong.append(f"{grade}, and the headline: {headline}")
    if "probability" in headline and grade == "data cannot answer":
        wrong.append(f"a probability that the report hides: {headline}")
    low, high = rules["probability"].get(grade, [0, 100])
    if not all(low <= float(p) <= high for p in re.findall(r"(\d+) %", headline)):
        wrong.append(headline)
    for start, grades in rules["actions"].items():
        wrong += [f"{grade}: {text}" for text in texts if text.startswith(start) and grade not in grades]
    wrong += [text for text in texts if re.search(r"\de[+-]\d|\d\.\d{4}", text)]
    return wrong


def test_no_card_contradicts_itself(diagnoses):
    rules = json.loads((ROOT / "crates/stiction-report/tests/contradictions.json").read_text())
    population = [
        stiction.recording(loop.op, loop.pv, loop.sp, sample_time=loop.sample_time, name=loop.name)
        for loop in stiction.population(40, seed=20_261_227)
    ]
    for diagnosis in [*diagnoses, *stiction.diagnose_all(population)]:
        assert _contradictions(diagnosis, rules) == [], diagnosis.name
