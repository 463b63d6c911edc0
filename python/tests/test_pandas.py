"""Data frames in and out, and what they are told by ``frame.stiction``."""

import sys

import numpy as np
import pandas as pd
import pytest
import stiction
import stiction.pandas

RUN = stiction.simulate("samples/sticky-flow")


@pytest.fixture
def frame():
    return pd.read_csv(stiction.datasets.path("FIC101-sticky"))


def test_a_frame_has_a_recording_and_a_diagnosis(frame):
    assert frame.stiction.recording(name="FIC101").name == "FIC101"
    assert frame.stiction.diagnose(detectors="none").verdict.class_ == "sticks"
    timed = frame.drop(columns="t").set_index(pd.date_range("2024-05-01", periods=len(frame), freq="1s", tz="UTC"))
    assert str(timed.stiction.diagnose(detectors="none").start_time) == "2024-05-01 00:00:00+00:00"
    with pytest.raises(TypeError, match="no_such"):
        frame.stiction.diagnose(no_such=1)


def test_runs_become_frames():
    frame = RUN.to_pandas()
    assert frame.columns.tolist() == ["sp", "pv", "op", "vp"] and frame.index.name == "time_s"
    assert np.array_equal(frame["vp"], RUN.vp) and np.array_equal(frame.index, RUN.time_s)
    cascade = stiction.closed_loop.simulate_cascade("paper/flow-cascade")
    assert cascade.to_pandas().columns.tolist() == ["sp", "pv", "op", "vp", "master_sp", "master_pv"]
    assert stiction.closed_loop.simulate_open_loop("paper/open-loop-high").to_pandas().columns.tolist() == ["op", "vp"]
    # And back.
    assert np.array_equal(stiction.recording_from(frame).op, RUN.op)


def test_tables_become_frames():
    table = stiction.summary_table([stiction.diagnose(stiction.datasets.load("FIC101-sticky"), detectors="none")])
    frame = table.to_pandas()
    assert frame.columns.tolist() == table.column_names and frame.loc[0, "verdict"] == "sticks"
    assert frame["samples"].dtype == np.int64 and frame["S"].dtype == np.float64
    assert pd.DataFrame(table).to_dict() == frame.to_dict()
    assert [row["loop"] for row in table] == ["FIC101-sticky"]
    empty = stiction.summary_table([]).to_pandas()
    assert len(empty) == 0 and empty.columns.tolist() == table.column_names


def test_without_pandas_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    for made in (RUN.to_pandas, stiction.valves.valve_table().to_pandas):
        with pytest.raises(ImportError, match=r"pip install stiction\[pandas\]"):
            made()
