"""Recordings: the same from files, tables and arrays; malformed ones are refused by name."""

import datetime
import pickle
import sys
from decimal import Decimal
from pathlib import Path

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.csv
import pytest
import stiction

ROOT = Path(__file__).parents[2]
STICKY = ROOT / "samples" / "FIC101-sticky.csv"
FIXTURES = ROOT / "crates" / "stiction-io" / "tests" / "fixtures"
OP, PV = np.linspace(40, 60, 50), np.linspace(1, 2, 50)


def _same_signals(a, b):
    for signal in ("op", "pv", "sp", "vp", "time_s"):
        x, y = getattr(a, signal), getattr(b, signal)
        assert (x is None) == (y is None), signal
        assert x is None or np.array_equal(x, y, equal_nan=True), signal


@pytest.fixture(scope="module")
def sticky():
    [recording] = stiction.read(STICKY)
    return recording


def test_a_file_is_read(sticky):
    assert (sticky.name, sticky.loop_type, sticky.start) == ("FIC101-sticky", "flow", None)
    assert len(sticky.op) == len(sticky.pv) == len(sticky.sp) == 2400 and sticky.vp is None
    assert sticky.file == str(STICKY) and len(sticky.sha256) == 64
    assert repr(sticky) == '<Recording "FIC101-sticky" (flow) of 2400 samples: OP, PV, SP>'
    assert np.array_equal(sticky.times("pv"), np.arange(2400.0)) and sticky.times("vp") is None


@pytest.mark.parametrize("name", ["loop_zstd.parquet", "isdb_v73.mat", "vectors.mat"])
def test_every_format_is_read(name):
    for recording in stiction.read(FIXTURES / name, sample_time=1.0 if name.endswith("mat") else None):
        assert len(recording.op) > 0


TABLES = {
    "pandas": lambda: pd.read_csv(STICKY),
    "polars": lambda: pl.read_csv(STICKY),
    "pyarrow": lambda: pyarrow.csv.read_csv(STICKY),
    "record batches": lambda: pa.Table.from_batches(pyarrow.csv.read_csv(STICKY).to_batches(max_chunksize=700)),
    "float32 and null": lambda: pl.read_csv(STICKY).with_columns(empty=pl.lit(None)),
    "mapping": lambda: pd.read_csv(STICKY).to_dict(orient="list"),
    "arrays": lambda: {name: column.to_numpy() for name, column in pd.read_csv(STICKY).items()},
}


@pytest.mark.parametrize("make", TABLES.values(), ids=TABLES)
def test_tables_are_as_the_file(make, sticky):
    _same_signals(stiction.recording_from(make(), name="FIC101-sticky"), sticky)
    given = stiction.recording_from(make(), time="t", op="op", pv="pv", sp="sp", name="FIC101-sticky")
    _same_signals(given, sticky)
    assert given.loop_type == "flow" and given.sha256 == ""


def test_arrays_are_as_the_file(sticky):
    for time in ({"sample_time": 1}, {"time": np.arange(2400)}):
        _same_signals(stiction.recording(sticky.op, sticky.pv, sticky.sp, name="FIC101", **time), sticky)


def test_old_pandas_without_the_capsule_is_read_column_by_column(sticky, monkeypatch):
    class Old:
        def __init__(self, frame):
            self.columns, self._frame = frame.columns, frame

        def __getitem__(self, name):
            return self._frame[name].to_numpy()

    _same_signals(stiction.recording_from(Old(pd.read_csv(STICKY))), sticky)


STAMPS = pd.date_range("2026-03-01T08:00:00", periods=50, freq="2s")


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_timestamps_of_any_unit_become_seconds(unit):
    frame = pd.DataFrame({"op": OP, "pv": PV, "Timestamp": STAMPS.astype(f"datetime64[{unit}]")})
    start = datetime.datetime(2026, 3, 1, 8, tzinfo=datetime.timezone.utc).timestamp()
    made = [
        stiction.recording_from(frame),
        stiction.recording_from(frame.assign(Timestamp=frame["Timestamp"].dt.tz_localize("UTC"))),
        stiction.recording_from(pa.table({"op": OP, "pv": PV, "time": pa.array(frame["Timestamp"])})),
        stiction.recording_from(frame.set_index("Timestamp")),
        stiction.recording_from(frame.set_index("Timestamp").rename_axis(None)),
        stiction.recording_from({"op": OP, "pv": PV, "time": frame["Timestamp"].to_numpy()}),
        stiction.recording_from({"op": OP, "pv": PV, "time": STAMPS.strftime("%Y-%m-%d %H:%M:%S").tolist()}),
        stiction.recording(OP, PV, time=frame["Timestamp"].to_numpy()),
        stiction.recording(OP, PV, sample_time=2, start=start),
    ]
    for recording in made:
        assert recording.start == start
        assert np.array_equal(recording.time_s, 2.0 * np.arange(50))


def test_local_times_have_a_zone():
    frame = pd.DataFrame({"op": OP, "time": STAMPS})
    berlin = stiction.recording_from(frame, zone="Europe/Berlin")
    assert stiction.recording_from(frame).start - berlin.start == 3600


def test_a_wide_table_holds_several_loops():
    frame = pl.DataFrame({"t": np.arange(50.0), "FIC1.OP": OP, "FIC1.PV": PV, "LIC2.OP": OP, "LIC2.PV": PV})
    assert [(r.name, r.loop_type) for r in stiction.recordings.recordings_from(frame)] == [("FIC1", "flow"), ("LIC2", "level")]
    with pytest.raises(ValueError, match="table holds the loops FIC1, LIC2"):
        stiction.recording_from(frame)


def test_a_long_table_has_tags_in_rows():
    frame = pd.DataFrame(
        {
            "time": np.repeat(np.arange(50.0), 2),
            "tag": pd.Categorical(["FIC1.OP", "FIC1.PV"] * 50),
            "value": np.column_stack([OP, PV]).ravel(),
        }
    )
    [recording] = stiction.recordings.recordings_from(frame)
    assert recording.name == "FIC1" and np.array_equal(recording.pv, PV)


def test_missing_samples_are_nan_and_bridged():
    pv = PV.copy()
    pv[[10, 11]] = np.nan
    made = [
        stiction.recording(OP, pv, sample_time=1),
        stiction.recording_from(pl.DataFrame({"op": OP, "pv": pl.Series(pv).fill_nan(None)}), sample_time=1),
    ]
    for recording in made:
        assert np.isnan(recording.pv).sum() == 2
        [segment] = stiction.recordings.segments(recording)
        assert segment.bridged == 2 and np.allclose(segment.pv, PV)
    pv[20:30] = np.nan
    assert [len(each.op) for each in stiction.recordings.segments(stiction.recording(OP, pv, sample_time=1))] == [20, 20]


def test_ranges_make_percent():
    recording = stiction.recording(4 + 16 * OP / 100, PV, sample_time=1, op_range=(4, 20))
    assert np.allclose(stiction.recordings.segments(recording)[0].op, OP)


def test_fitness_says_why():
    short = stiction.recordings.fitness(stiction.recording(OP, 0 * PV, sample_time=1))
    assert short.class_ == "unfit" and short.reasons
    assert {"name", "value", "reason"} <= set(short.measures[0].to_dict())
    class_, reasons, measures = short
    assert class_ == short.class_


def test_recordings_split_compare_and_pickle(sticky):
    again = pickle.loads(pickle.dumps(sticky))
    assert again == sticky and again is not sticky
    parts = sticky.split(600)
    assert [len(part.op) for part in parts] == [600] * 4 and parts[1].time_s[0] == 600
    odd = stiction.recording(OP, np.where(PV > 1.5, np.nan, PV), sample_time=3, op_range=(0, 50), start=5)
    kept = pickle.loads(pickle.dumps(odd))
    _same_signals(kept, odd)
    assert np.array_equal(stiction.recordings.segments(kept)[0].op, stiction.recordings.segments(odd)[0].op) and kept.start == 5


def test_nothing_is_imported_for_tables():
    import subprocess

    code = "import stiction, sys; print([m for m in ('pandas', 'polars', 'pyarrow', 'matplotlib', 'sklearn') if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


FRAME = pd.DataFrame({"t": np.arange(50.0), "op": OP, "pv": PV})
BAD = [
    (lambda: stiction.read("nothing.csv"), FileNotFoundError, "nothing.csv"),
    (lambda: stiction.read(ROOT), OSError, "irectory|enied"),
    (lambda: stiction.read(3), TypeError, "path must be a path"),
    (lambda: stiction.read(STICKY, columns={"op": "OUT"}), ValueError, 'no column "OUT"'),
    (lambda: stiction.read(STICKY, columns={"valve": "op"}), ValueError, '"valve" is not a role'),
    (lambda: stiction.read(STICKY, columns={"op": 3}), TypeError, r"columns\['op'\] must be a string"),
    (lambda: stiction.read(STICKY, columns=["op"]), TypeError, "columns must be a mapping"),
    (lambda: stiction.read(STICKY, mapping="nothing.toml"), FileNotFoundError, "nothing.toml"),
    (lambda: stiction.read(STICKY, zone="Atlantis"), ValueError, 'zone: "Atlantis" is not a time zone'),
    (lambda: stiction.read(STICKY, time_format="iso"), ValueError, 'time_format: "iso" is not a time format'),
    (lambda: stiction.read(STICKY, sample_time=0), ValueError, "sample_time is 0, but must be"),
    (lambda: stiction.read(STICKY, loop_type="flo"), ValueError, "flow, level"),
    (lambda: stiction.read(STICKY, op_range=(100, 0)), ValueError, r"op_range is \(100, 0\)"),
    (lambda: stiction.read(STICKY, op_range=5), TypeError, "op_range must be a pair"),
    (lambda: stiction.read(STICKY, pv_range=("a", 1)), TypeError, "pv_range must be a number"),
    (lambda: stiction.recording(OP), ValueError, "either sample_time or time"),
    (lambda: stiction.recording(OP, sample_time=1, time=PV), ValueError, "either sample_time or time"),
    (lambda: stiction.recording([], sample_time=1), ValueError, "op is empty"),
    (lambda: stiction.recording(np.empty(0), sample_time=1), ValueError, "op is empty"),
    (lambda: stiction.recording(OP, PV[:9], sample_time=1), ValueError, "pv has 9 values, but op has 50"),
    (lambda: stiction.recording(OP, PV, time=PV[:9]), ValueError, "op has 50 values, but time has 9"),
    (lambda: stiction.recording(OP, ["a"] * 50, sample_time=1), TypeError, "pv must hold real numbers"),
    (lambda: stiction.recording(OP, np.full(50, np.inf), sample_time=1), ValueError, '"pv": inf is not a finite'),
    (lambda: stiction.recording(OP, time=np.full(50, np.nan)), ValueError, '"time": is not a time'),
    (lambda: stiction.recording(OP, time=np.full(50, "NaT", "M8[s]")), ValueError, '"time": is not a time'),
    (lambda: stiction.recording(OP, sample_time=1, name=3), TypeError, "name must be a string"),
    (lambda: stiction.recording(OP, sample_time=1, start="now"), TypeError, "start must be a number"),
    (lambda: stiction.recording(OP.reshape(5, 10), sample_time=1), ValueError, "op has the shape"),
    (lambda: stiction.recording_from(3), TypeError, "table must be a table"),
    (lambda: stiction.recording_from({}), ValueError, "table has no columns"),
    (lambda: stiction.recording_from({"op": OP, "t": PV[:5]}), ValueError, "t has 5 values, but op has 50"),
    (lambda: stiction.recording_from(FRAME, op="OUT"), ValueError, 'no column "OUT"'),
    (lambda: stiction.recording_from(FRAME, op=3), TypeError, "op must be a string"),
    (lambda: stiction.recording_from(FRAME[["t", "pv"]]), ValueError, "no column known as the controller output"),
    (lambda: stiction.recording_from(FRAME[["op", "pv"]]), ValueError, "no column of times"),
    (lambda: stiction.recording_from(FRAME.assign(pv="x")), ValueError, 'column "pv"'),
    (lambda: stiction.recording_from(pl.DataFrame({"t": [1.0], "op": [[1.0]]})), TypeError, 'column "op" holds'),
    (lambda: stiction.recording_from(pl.DataFrame({"t": [], "op": []})), ValueError, "OP|rows|empty|sample"),
    (lambda: stiction.recordings.recordings_from(FRAME, time_format="day-first"), ValueError, "leave time_format out"),
    (lambda: stiction.recordings.fitness(FRAME["op"]), TypeError, "recording must be a Recording or a table, but its type is Series"),
    (lambda: stiction.recordings.fitness(stiction.recording([1.0], sample_time=1)), ValueError, "OP"),
    (lambda: stiction.recordings.segments(stiction.recording(OP, sample_time=1), sample_time=-1), ValueError, "sample time"),
    (lambda: stiction.recording(OP, sample_time=1).split(0), ValueError, "window"),
    (lambda: stiction.recording(OP, sample_time=1).split("day"), TypeError, "window_s must be a number"),
    (lambda: stiction.recording(OP, sample_time=1).times("mv"), ValueError, 'signal is "mv"'),
]


@pytest.mark.parametrize("call, error, words", BAD)
def test_malformed_input_is_refused_by_name(call, error, words):
    with pytest.raises(error, match=words) as refused:
        call()
    assert " --" not in str(refused.value)


TIMES = "2024-03-31 {:02}:00:00"
ASKED = [
    ("t,pv\n0,1\n1,2\n", {}, 'as in columns={"op": "COLUMN"}'),
    ("op,pv\n1,2\n3,4\n", {}, 'as in columns={"time": "COLUMN"}, or give the time between rows, as in sample_time=1'),
    ("t,op,out\n0,1,2\n1,2,3\n", {}, 'choose one, as in columns={"op": "op"}'),
    ("t,op\n01/02/2024,1\n02/02/2024,2\n", {}, "give time_format "),
    ("t,op\nfoo,1\nbar,2\n", {}, "foo"),
    ("t,op\n2024-01-01,1\n", {"time_format": "%H:%M"}, 'is not a time in the format time_format="%H:%M"'),
    ("t,op\n0,1\n1,weg\n", {}, 'give bad_text=["weg"]'),
    ("t,op,mode\n0,1,odd\n1,2,odd\n", {}, 'as in columns={"ignore": "mode"}'),
    ("t,op\n" + "".join(f"{TIMES.format(h)},1\n" for h in range(4)), {"zone": "Europe/Berlin"}, 'as in zone="+01"'),
]


@pytest.mark.parametrize("text, told, words", ASKED)
def test_refusals_and_notes_name_keywords_not_options_of_the_command(tmp_path, text, told, words):
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(ValueError) as refused:
        stiction.read(path, **told)
    assert words in str(refused.value) and " --" not in str(refused.value)


def test_notes_name_keywords(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("time,mv\n2024-01-01 00:00:00,1\n2024-01-01 00:00:01,2\n")
    [made] = stiction.read(path)
    said = " ".join(made.notes)
    assert "if this is wrong, give zone" in said and 'give columns={"vp": "mv"}' in said and " --" not in said


def test_what_is_masked_is_missing_where_samples_may_be_missing():
    mask = np.arange(50) == 7
    op = np.ma.array(np.where(mask, 1e6, OP), mask=mask)
    whole = np.ma.array(np.arange(50), mask=mask)
    made = stiction.recording(op, whole, sample_time=1)
    assert np.array_equal(np.isnan(made.op), mask) and np.array_equal(np.isnan(made.pv), mask)
    assert np.array_equal(made.op[~mask], OP[~mask])
    [table] = stiction.recordings.recordings_from({"op": op, "pv": np.ma.array(PV)}, sample_time=1)
    assert np.array_equal(table.op, made.op, equal_nan=True) and np.array_equal(table.pv, PV)


def test_what_is_masked_is_refused_where_no_sample_may_be_missing():
    times = np.ma.array(np.arange(50.0), mask=np.arange(50) == 7)
    with pytest.raises(ValueError, match='row 8, column "time": is not a time'):
        stiction.recording(OP, time=times)
    moments = np.ma.array(np.arange(50).astype("datetime64[s]"), mask=np.arange(50) == 7)
    with pytest.raises(ValueError, match='row 8, column "time": is not a time'):
        stiction.recording(OP, time=moments)
    with pytest.raises(ValueError, match="1"):
        stiction.valve(np.ma.array([50.0, 1e6, 50.0], mask=[False, True, False]), S=5, J=2)


def test_days_in_a_column_called_t_are_requested_about():
    table = {"t": 45000 + np.arange(50) / 86400, "op": OP, "pv": PV}
    words = "as spreadsheet days since 1900 the sample time would be 1 s, as seconds 12 µs"
    with pytest.raises(ValueError, match=words) as refused:
        stiction.recording_from(table)
    assert 'time_format "excel" or "seconds"' in str(refused.value) and "sample_time=1" in str(refused.value)
    told = stiction.recording_from(table, time_format="excel")
    assert np.allclose(np.diff(told.time_s), 1, atol=0.01)
    assert stiction.recording_from(table, sample_time=1).time_s[-1] == 49


def _frame():
    times = pd.date_range("2025-03-14 06:00", periods=50, freq="s", tz="UTC")
    return pd.DataFrame({"sp": np.full(50, 1.5), "pv": PV, "op": OP}, index=times)


def _with_bad():
    frame = _frame().astype(object)
    frame.iloc[7, 1] = "Bad"
    frame.iloc[8, 1] = None
    return frame


def _as_decimals():
    return _frame().assign(pv=[Decimal(repr(float(value))) for value in PV])


OBJECTS = {
    "one word among numbers": _with_bad,
    "decimals": _as_decimals,
    "index of differences": lambda: _frame().set_axis(pd.to_timedelta(np.arange(50), unit="s")),
    "reset index": lambda: _frame().reset_index(),
    "nullable numbers": lambda: _frame().convert_dtypes(),
    "periods": lambda: _frame().tz_localize(None).to_period("s"),
    "text as index": lambda: _frame().set_axis([str(time) for time in _frame().index]),
    "two levels of names": lambda: _frame().set_axis(pd.MultiIndex.from_product([["FIC1"], ["sp", "pv", "op"]]), axis=1),
    "lazy": lambda: pl.LazyFrame({"t": np.arange(50.0), "sp": np.full(50, 1.5), "pv": PV, "op": OP}),
}


@pytest.mark.parametrize("name", OBJECTS)
def test_objects_of_data_bases_are_read(name):
    table = OBJECTS[name]()
    [made] = stiction.recordings.recordings_from(table)
    assert np.array_equal(made.op, OP) and np.array_equal(made.time_s, np.arange(50.0))
    missing = [7, 8] if name == "one word among numbers" else []
    assert np.flatnonzero(np.isnan(made.pv)).tolist() == missing
    assert np.array_equal(np.delete(made.pv, missing), np.delete(PV, missing))


def test_decimals_of_arrow_are_numbers():
    columns = {"t": list(range(50)), "op": [Decimal(f"{value:.3f}") for value in OP]}
    [made] = stiction.recordings.recordings_from(pa.table(columns))
    assert np.array_equal(made.op, [float(f"{value:.3f}") for value in OP])


def test_frames_that_cannot_be_read_are_refused_in_words():
    with pytest.raises(ValueError, match="2 columns named 'pv'; rename them"):
        stiction.recordings.recordings_from(pd.concat([_frame(), _frame()[["pv"]]], axis=1))
    with pytest.raises(ValueError, match="a column and an index named 'time'; rename one"):
        stiction.recordings.recordings_from(_frame().assign(time=1.0))
    frame = _with_bad()
    frame.iloc[7, 1] = "Kaputt"
    with pytest.raises(ValueError, match="Kaputt"):
        stiction.recordings.recordings_from(frame)
    [made] = stiction.recordings.recordings_from(frame, bad_text=["Kaputt"])
    assert np.isnan(made.pv[7])
    assert frame.iloc[7, 1] == "Kaputt"


def test_a_sheet_of_a_workbook_is_chosen():
    both = stiction.read(FIXTURES / "days.xlsx")
    assert [each.name for each in both] == ["Monday.FIC101", "Tuesday.FIC101"]
    [one] = stiction.read(FIXTURES / "days.xlsx", part="Tuesday")
    assert one.name == "FIC101" and one.start == both[1].start
