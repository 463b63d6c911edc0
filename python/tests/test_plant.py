"""Plants from Python: the scan of a folder, and tables judged as engines do, by the same rows."""

import random
import threading

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
import stiction.plant



@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("north")
    stiction.plant.demo(folder, loops=4, days=2)
    stiction.plant.scan(folder, threads=2)
    return folder


@pytest.fixture(scope="module")
def samples(folder):
    return pq.read_table(folder / "data")


def rows(table, apart=("input_fingerprint",)):
    table = pa.table(table)
    table = table.drop_columns([name for name in apart if name in table.column_names])
    return table.sort_by([("loop", "ascending"), ("window_start", "ascending")]).to_pylist()


def test_a_scan_judges_what_is_new_and_tells(tmp_path):
    stiction.plant.demo(tmp_path, loops=3, days=2, seed=4)
    found = stiction.plant.check(tmp_path)
    assert (found.files, len(found.loops), found.loops[0].days, found.problems) == (2, 3, 2, [])
    heard = []
    first = found.loops[0]
    done = stiction.plant.scan(str(tmp_path), loops=first.loop.lower(), threads=1, progress=heard.append)
    assert (done.plant, done.run, done.errors) == ("Demo", "0001", 0) and heard == sorted(heard) and heard
    assert set(stiction.plant.windows(tmp_path)["loop"]) == {first.loop}
    assert stiction.plant.scan(tmp_path, since=first.last_day, loops=first.loop).windows == 0
    assert stiction.plant.scan(tmp_path, again=True).windows > done.windows
    status = stiction.plant.status(tmp_path)
    assert (status.loops, status.days, status.runs) == (3, 2, 2)
    assert sum(each.windows for each in status.grades) == status.windows
    last = stiction.plant.windows(tmp_path, since=status.last_day)
    assert 0 < len(last) < status.windows


def test_what_cannot_be_is_refused(tmp_path):
    with pytest.raises(OSError, match="plant.toml"):
        stiction.plant.scan(tmp_path)
    stiction.plant.demo(tmp_path, loops=1, days=1)
    with pytest.raises(ValueError, match="\"soon\" is not a day"):
        stiction.plant.scan(tmp_path, since="soon")
    with pytest.raises(ValueError, match="threads is 0"):
        stiction.plant.scan(tmp_path, threads=0)
    (tmp_path / "plant.toml").write_text('name = "N"\nzone = "Nowhere"\n')
    with pytest.raises(ValueError, match="line 2, zone"):
        stiction.plant.status(tmp_path)


def test_the_schema_is_declared_once(folder):
    schema, table = stiction.plant.schema(), pa.table(stiction.plant.windows(folder))
    assert schema.equals(table.schema, check_metadata=True)
    assert schema.field("period_s").metadata[b"unit"] == b"s"
    columns = [part.split()[0].strip("`") for part in stiction.plant.ddl().split(", ")]
    assert columns == schema.names
    assert "`samples` BIGINT" in stiction.plant.ddl() and "`oscillates` BOOLEAN" in stiction.plant.ddl()


def test_a_table_gives_the_rows_of_the_scan(folder, samples):
    expected = rows(stiction.plant.windows(folder))
    assert len(expected) > 4 and all(row["samples_fingerprint"] for row in expected)
    found = stiction.plant.diagnose_table(samples, folder, threads=1)
    assert rows(found) == expected and set(found["input_fingerprint"]) == {""}
    order = list(range(len(samples)))
    random.Random(1).shuffle(order)
    shuffled = samples.take(order)
    shuffled = shuffled.set_column(1, "tag", shuffled["tag"].dictionary_encode())
    settings = (folder / "plant.toml").read_text()
    assert rows(stiction.plant.diagnose_table(shuffled, settings, threads=2)) == expected
    # Without the plant's file nothing is known of areas.
    bare = stiction.plant.diagnose_table(samples.to_batches()[0])
    assert set(bare["area"]) == {None}


def test_a_window_is_that_of_the_scan_from_its_samples_and_the_last_before(folder, samples):
    expected = rows(stiction.plant.windows(folder))
    day = 86_400
    for row in expected:
        start = row["window_start"]
        own = samples.filter(pc.starts_with(samples["tag"], row["loop"] + "."))
        seconds = pc.cast(own["time"], pa.int64())
        within = own.filter(
            pc.and_(pc.greater_equal(seconds, start * 1000), pc.less(seconds, (start + row["window_s"]) * 1000))
        )
        before = own.filter(pc.and_(pc.greater_equal(seconds, (start - day) * 1000), pc.less(seconds, start * 1000)))
        last = before.group_by("tag").aggregate([("time", "max")]).rename_columns(["tag", "time"])
        held = before.join(last, ["tag", "time"], join_type="inner").select(own.column_names)
        table = pa.concat_tables([within, held.cast(within.schema)])
        judged, _, _ = stiction.plant.diagnose_window(table, folder, row["loop"], start // day, row["window_s"] // day)
        assert rows(judged) == [{key: value for key, value in row.items() if key != "input_fingerprint"}]
        _, _, days = stiction.plant.diagnose_window(table, folder, row["loop"], start // day)
        # The data end after two days.
        assert min(days, 2) >= row["window_s"] // day


def test_a_wide_table_gives_the_same(folder, samples):
    expected = [row for row in rows(stiction.plant.windows(folder)) if row["loop"] == "FIC1001"]
    own = samples.filter(pc.starts_with(samples["tag"], "FIC1001."))
    columns = {}
    for tag in pc.unique(own["tag"]).to_pylist():
        one = own.filter(pc.equal(own["tag"], tag))
        columns.setdefault("time", one["time"])
        columns[tag] = one["value"]
    found = rows(stiction.plant.diagnose_table(pa.table(columns), folder))
    assert found == [{key: value for key, value in row.items() if key != "input_fingerprint"} for row in expected]


def test_data_that_cannot_be_judged_are_rows(samples):
    few = samples.filter(pc.equal(samples["tag"], "FIC1001.OP")).slice(0, 1)
    [row] = rows(stiction.plant.diagnose_table(few))
    assert row["loop"] == "FIC1001" and row["error"] and row["window_s"] == 86_400 and row["verdict"] is None
    nothing = samples.filter(pc.equal(samples["tag"], "FIC1001.PV"))
    [row] = rows(stiction.plant.diagnose_table(nothing))
    assert (row["loop"], row["window_s"]) == ("", 0) and "no column known as the controller output" in row["error"]
    undated = pa.table({"time": [0.0, 1.0, 2.0], "FIC1.OP": [1.0, 2.0, 3.0], "FIC1.PV": [1.0, 2.0, 3.0]})
    [row] = rows(stiction.plant.diagnose_table(undated))
    assert row["loop"] == "FIC1" and "has no dates" in row["error"]


def test_misuse_raises(samples):
    with pytest.raises(ValueError, match="__arrow_c_"):
        stiction.plant.diagnose_table([1, 2, 3])
    with pytest.raises(TypeError, match="must hold numbers, text or times"):
        stiction.plant.diagnose_table(pa.table({"time": [[1]]}))
    with pytest.raises(ValueError, match="settings, line 1"):
        stiction.plant.diagnose_table(samples, "nonsense")
    with pytest.raises(ValueError, match="threads"):
        stiction.plant.diagnose_table(samples, threads=0)


def test_rows_from_elsewhere_are_taken(folder, samples, tmp_path):
    (tmp_path / "plant.toml").write_text((folder / "plant.toml").read_text())
    found = stiction.plant.diagnose_table(samples, folder)
    done = stiction.plant.take(tmp_path, found)
    assert (done.run, done.windows) == ("0001", len(found))
    assert rows(stiction.plant.windows(tmp_path)) == rows(stiction.plant.windows(folder))
    with pytest.raises(ValueError, match='it has no column "loop"'):
        stiction.plant.take(tmp_path, samples)


def test_the_lock_is_free_while_a_table_is_judged(samples):
    beat, stopped = [0], threading.Event()

    def count():
        while not stopped.wait(0.001):
            beat[0] += 1

    counting = threading.Thread(target=count)
    counting.start()
    try:
        stiction.plant.diagnose_table(samples, threads=1)
    finally:
        stopped.set()
        counting.join()
    assert beat[0] > 5
