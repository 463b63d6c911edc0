"""Files of hours: whole or not at all, equal to what was recorded, with gaps as gaps."""

import errno
import math
import os
import random
from pathlib import Path

import numpy as np
import pytest

pq = pytest.importorskip("pyarrow.parquet")

import stiction.plant
from stiction.live import hours

START = 1_772_409_600_000_000
SECOND = 1_000_000
HOUR = hours.HOUR


def recorded(plant, values, tags=("A.OP", "A.PV")):
    """Records (tag, time, value, status) and hands all hours over."""
    recorder = hours.Recorder(plant, tags)
    for tag, time, value, status in values:
        recorder.add(tag, time, value, status)
    recorder.flush()
    recorder.release(1 << 62)
    recorder.close()


def rows(plant, hour=START):
    return {tag: own for tag, own in hours.tables_by_tag(hours.hour_file(plant / "data", hour))}


def listed(own):
    return [(int(t) - START, None if math.isnan(v) else float(v), int(s)) for t, v, s in zip(own.time, own.value, own.status)]


def test_a_file_has_what_was_recorded_in_order_and_equal_values_once(tmp_path):
    values = [(0, START + 5 * SECOND, 2.0, 0), (1, START, 7.0, 0x4000_0000), (0, START, 1.0, 0), (0, START + 5 * SECOND, 2.0, 0), (1, START + 1, math.nan, 0x8000_0000), (1, START, math.nan, 0x8000_0000)]
    recorded(tmp_path, values)
    [folded] = hours.fold(tmp_path, tmp_path / "data")
    assert (folded.rows, folded.problems) == (4, [])
    found = rows(tmp_path)
    assert listed(found["A.OP"]) == [(0, 1.0, 0), (5 * SECOND, 2.0, 0)]
    assert listed(found["A.PV"]) == [(0, 7.0, 0x4000_0000), (1, None, 0x8000_0000)]
    with pq.ParquetFile(hours.hour_file(tmp_path / "data", START)) as file:
        assert file.num_row_groups == 2 and file.schema_arrow.names == ["time", "tag", "value", "status_code"]
    assert not any((tmp_path / ".stiction/live/ready").iterdir())


def test_writing_again_changes_no_byte(tmp_path):
    values = [(0, START + k * SECOND, float(k), 0) for k in range(100)]
    recorded(tmp_path, values)
    hours.fold(tmp_path, tmp_path / "data")
    path = hours.hour_file(tmp_path / "data", START)
    before = path.read_bytes()
    # As after a kill between the file and the end of its journal.
    recorded(tmp_path, values)
    hours.fold(tmp_path, tmp_path / "data")
    assert path.read_bytes() == before


def test_a_file_is_whole_or_not_at_all(tmp_path, monkeypatch):
    recorded(tmp_path, [(0, START, 1.0, 0)])
    hours.fold(tmp_path, tmp_path / "data")
    path = hours.hour_file(tmp_path / "data", START)
    before = path.read_bytes()
    recorded(tmp_path, [(0, START + k, float(k), 0) for k in range(1000)])

    with monkeypatch.context() as patched:
        patched.setattr(os, "replace", broken)
        with pytest.raises(OSError, match="No space"):
            hours.fold(tmp_path, tmp_path / "data")
    assert path.read_bytes() == before and [each.name for each in path.parent.iterdir()] == ["00.parquet"]
    # The journal stays, and the next attempt has all values.
    [folded] = hours.fold(tmp_path, tmp_path / "data")
    assert folded.rows == 1001 + 1


def test_a_kill_in_the_middle_of_a_record_loses_only_that_record(tmp_path):
    recorded(tmp_path, [(0, START + k * SECOND, float(k), 0) for k in range(10)])
    [journal] = (tmp_path / ".stiction/live/ready").iterdir()
    journal.write_bytes(journal.read_bytes()[:-5])
    [folded] = hours.fold(tmp_path, tmp_path / "data")
    assert len(rows(tmp_path)["A.OP"]) == 9 and "ends within a record" in folded.problems[0]


@pytest.mark.parametrize("length", range(0, 60, 7))
def test_a_journal_cut_anywhere_is_read(tmp_path, length):
    recorded(tmp_path, [(0, START, 1.0, 0)])
    [journal] = (tmp_path / ".stiction/live/ready").iterdir()
    journal.write_bytes(journal.read_bytes()[:length])
    hours.known(tmp_path)
    hours.fold(tmp_path, tmp_path / "data")
    assert not any((tmp_path / ".stiction/live/ready").iterdir())
    if hours.hour_file(tmp_path / "data", START).exists():
        # The tags were still known.
        assert [listed(own) for own in rows(tmp_path).values()] == [[(0, None, hours.NONE)]] * 2


def test_records_of_other_hours_in_a_damaged_journal_are_left_out_and_counted(tmp_path):
    recorded(tmp_path, [(0, START + k * SECOND, float(k), 0) for k in range(10)])
    [journal] = (tmp_path / ".stiction/live/ready").iterdir()
    strange = [(0, 0, 10**18, 1.0), (1, 0, 0, 1.0), (hours.MARK, 0, 1 << 62, 99.0), (hours.MARK, 0, -(1 << 62), 1e9)]
    journal.write_bytes(journal.read_bytes() + b"".join(hours.PACK(*each) for each in strange))
    # A day that no month has is no journal.
    journal.with_name("2026-02-31T04.000099.values").write_bytes(journal.read_bytes())
    known = hours.known(tmp_path)
    assert (known.until, known.sequence, known.last) == (None, 0, {"A.OP": START + 9 * SECOND})
    [folded] = hours.fold(tmp_path, tmp_path / "data")
    assert folded.problems == [f"the journal {journal.name} is damaged: records with times of other hours were left out (4)"]
    assert listed(rows(tmp_path)["A.OP"]) == [(k * SECOND, float(k), 0) for k in range(10)]
    assert sorted(path.name for path in (tmp_path / "data").iterdir()) == ["2026-03-02"]


def test_a_tag_without_values_holds_its_last_one_but_not_across_a_gap(tmp_path):
    recorded(
        tmp_path,
        [
            (0, START, 1.0, 0),
            (1, START, 50.0, 0x4000_0000),
            (0, START + HOUR + 1, 2.0, 0),
            (1, START + 2 * HOUR - 1, math.nan, hours.LOST),
            (0, START + 2 * HOUR, 3.0, 0),
            (0, START + 3 * HOUR, 4.0, 0),
        ],
    )
    hours.fold(tmp_path, tmp_path / "data")
    # No value in the second hour but the gap at its end.
    assert listed(rows(tmp_path, START + HOUR)["A.PV"]) == [(2 * HOUR - 1, None, hours.LOST)]
    assert listed(rows(tmp_path, START + 2 * HOUR)["A.PV"]) == [(2 * HOUR, None, hours.NONE)]
    recorded(tmp_path, [(0, START + 4 * HOUR, 5.0, 0), (1, START + 3 * HOUR + 7, 60.0, 0)])
    hours.fold(tmp_path, tmp_path / "data")
    assert listed(rows(tmp_path, START + 3 * HOUR)["A.PV"]) == [(3 * HOUR + 7, 60.0, 0)]
    assert listed(rows(tmp_path, START + 4 * HOUR)["A.PV"]) == [(4 * HOUR, 60.0, hours.HELD)]


def test_late_values_change_what_later_hours_hold(tmp_path):
    recorded(tmp_path, [(0, START, 1.0, 0), (1, START, 50.0, 0), (0, START + HOUR, 2.0, 0), (0, START + 2 * HOUR, 3.0, 0)])
    hours.fold(tmp_path, tmp_path / "data")
    assert listed(rows(tmp_path, START + 2 * HOUR)["A.PV"]) == [(2 * HOUR, 50.0, hours.HELD)]
    recorded(tmp_path, [(1, START + 30, 55.0, 0)])
    hours.fold(tmp_path, tmp_path / "data")
    assert listed(rows(tmp_path)["A.PV"]) == [(0, 50.0, 0), (30, 55.0, 0)]
    assert listed(rows(tmp_path, START + 2 * HOUR)["A.PV"]) == [(2 * HOUR, 55.0, hours.HELD)]


def test_memory_is_bounded_by_batches_of_tags(tmp_path, monkeypatch):
    values = [(tag, START + k * SECOND, float(k), 0) for k in range(50) for tag in range(7)]
    tags = [f"L{k}.OP" for k in range(7)]
    recorded(tmp_path / "a", values, tags)
    hours.fold(tmp_path / "a", tmp_path / "a" / "data")
    monkeypatch.setattr(hours, "MOST_ROWS", 60)
    recorded(tmp_path / "b", values, tags)
    hours.fold(tmp_path / "b", tmp_path / "b" / "data")
    a, b = (hours.hour_file(tmp_path / each / "data", START).read_bytes() for each in "ab")
    assert a == b


def broken(*_):
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("stuck", [False, True])
def test_a_full_disk_leaves_whole_records(tmp_path, monkeypatch, stuck):
    recorder = hours.Recorder(tmp_path, ["A.OP"])
    recorder.add(0, START, 1.0, 0)
    recorder.flush()

    class Full:
        def __init__(self, file):
            self.file = file

        def write(self, data):
            if len(data) < 100:
                raise OSError(errno.ENOSPC, "No space left on device")
            # As a disk does that becomes full.
            return self.file.write(data[: len(data) // 2 - 5])

        def __getattr__(self, name):
            return getattr(self.file, name)

    [hour] = recorder._files
    recorder._files[hour] = Full(recorder._files[hour])
    if stuck:
        monkeypatch.setattr(Full, "truncate", broken, raising=False)
    for k in range(10):
        recorder.add(0, START + 1 + k, 2.0, 0)
    with pytest.raises(OSError, match="No space"):
        recorder.flush()
    recorder.add(0, START + 100, 3.0, 0)
    recorder.flush()
    recorder.release(1 << 62)
    [folded] = hours.fold(tmp_path, tmp_path / "data")
    found = listed(rows(tmp_path)["A.OP"])
    whole = found if not stuck else [row for row in found if row[1] != 2.0]
    assert whole == [(0, 1.0, 0), (100, 3.0, 0)] and len(folded.problems) == int(stuck)


def test_what_is_known_comes_from_the_journals(tmp_path):
    assert hours.known(tmp_path) == hours.Known()
    recorder = hours.Recorder(tmp_path, ["A.OP", "A.PV"])
    recorder.add(0, START + 7, 1.0, 0)
    recorder.mark(START + 5)
    recorder.flush()
    assert hours.known(tmp_path) == hours.Known(START + 5, {"A.OP": START + 7}, 1)
    recorder.close()


def test_old_files_go_by_age_and_by_size(tmp_path):
    recorded(tmp_path, [(0, START + k * HOUR, float(k), 0) for k in range(30)])
    hours.fold(tmp_path, tmp_path / "data")
    now = START + 30 * HOUR
    gone = hours.retain(tmp_path / "data", keep_s=20 * 3600.0, most_bytes=None, now=now)
    assert len(gone) == 9 and not hours.hour_file(tmp_path / "data", START).exists()
    sizes = sum(path.stat().st_size for path in (tmp_path / "data").rglob("*.parquet"))
    gone = hours.retain(tmp_path / "data", keep_s=None, most_bytes=sizes / 5, now=now)
    assert 15 <= len(gone) <= 18 and not (tmp_path / "data/2026-03-02").exists()
    (tmp_path / "data" / "export.parquet").write_bytes(b"not ours")
    hours.retain(tmp_path / "data", keep_s=0.0, most_bytes=0.0, now=now + HOUR)
    assert [path.name for path in (tmp_path / "data").iterdir()] == ["export.parquet"]


def test_verdicts_are_those_of_the_same_data_in_other_files(tmp_path):
    from server import played

    plant, live = tmp_path / "plant", tmp_path / "live"
    stiction.plant.demo(plant, loops=3, days=1)
    live.mkdir()
    (live / "plant.toml").write_text((plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
    data = played(plant, None)
    names = sorted(data)
    recorder = hours.Recorder(live, names)
    for k, name in enumerate(names):
        for time, value in zip(*data[name]):
            recorder.add(k, int(time), float(value), 0)
    recorder.flush()
    recorder.release(1 << 62)
    assert len(hours.fold(live, live / "data")) == 24
    for folder in (plant, live):
        stiction.plant.scan(folder)
    expected, found = (stiction.plant.windows(folder).to_dict() for folder in (plant, live))
    for column in expected:
        if not column.endswith("_fingerprint"):
            assert np.array_equal(found[column], expected[column]), column
    assert stiction.plant.check(live).problems == []


def test_the_file_of_an_hour_is_named_by_its_time():
    assert hours.hour_file(Path("data"), START + 5 * HOUR) == Path("data/2026-03-02/05.parquet")


def test_a_mark_after_a_clock_that_went_back_counts_and_later_ones_do_not(tmp_path):
    recorder = hours.Recorder(tmp_path, ["A.OP"])
    recorder.add(0, START, 1.0, 0)
    recorder.mark(START + 5 * SECOND)
    recorder.add(0, START + 4 * HOUR, 2.0, 0)
    recorder.mark(START + 4 * HOUR)
    recorder.flush()
    assert hours.known(tmp_path).until == START + 4 * HOUR
    # A collector that starts when the clock is right again.
    assert hours.known(tmp_path, START + HOUR) == hours.Known(START + 5 * SECOND, {"A.OP": START}, 2)
    recorder.mark(START + 9 * SECOND)
    recorder.flush()
    found = hours.known(tmp_path, START + 9 * HOUR)
    assert found.until == START + 9 * SECOND and found.sequence == 3 and found.last["A.OP"] <= found.until + hours.LEAD
    recorder.close()


def test_what_a_wrong_clock_dated_is_taken_back_and_nothing_else(tmp_path):
    recorder = hours.Recorder(tmp_path, ["A.OP"])
    for second in range(10):
        recorder.add(0, START + second * SECOND, float(second), 0)
    # A jump within the hour, and one into another hour.
    for late in (1800 * SECOND, 4 * HOUR):
        recorder.add(0, START + late, 99.0, 0)
    recorder.flush()
    recorder.void(START + 900 * SECOND)
    # The same times come again when the clock is right.
    for late in (1800 * SECOND, 4 * HOUR + SECOND):
        recorder.add(0, START + late, 7.0, 0)
    recorder.flush()
    recorder.release(1 << 62)
    recorder.close()
    hours.fold(tmp_path, tmp_path / "data")
    assert listed(rows(tmp_path)["A.OP"]) == [(second * SECOND, float(second), 0) for second in range(10)] + [(1800 * SECOND, 7.0, 0)]
    assert listed(rows(tmp_path, START + 4 * HOUR)["A.OP"]) == [(4 * HOUR + SECOND, 7.0, 0)]


DAY = 24 * HOUR


def aged(plant, server, computer, keep_s=100 * 86_400.0):
    now = hours.steady(plant, server, computer)
    return hours.retain(plant / "data", keep_s=keep_s, most_bytes=None, now=now)


def test_a_clock_that_jumps_removes_no_file(tmp_path):
    recorded(tmp_path, [(0, START + k * HOUR, float(k), 0) for k in range(30)])
    hours.fold(tmp_path, tmp_path / "data")
    computer = START + 30 * HOUR
    assert aged(tmp_path, START + 30 * HOUR, computer) == []
    # The server's clock is 500 days ahead for an hour, and data of that time come, too.
    recorded(tmp_path, [(0, START + 500 * DAY, 1.0, 0)])
    hours.fold(tmp_path, tmp_path / "data")
    for k in range(1, 5):
        assert aged(tmp_path, START + 500 * DAY + k * HOUR, computer + k * HOUR // 4) == []
    # This computer's clock is ahead, or both are.
    assert aged(tmp_path, START + 31 * HOUR, START + 900 * DAY) == []
    assert aged(tmp_path, START + 31 * HOUR, START) == [] and aged(tmp_path, 0, START) == []
    # After a plant was watched for 101 days, the first day has gone.
    for day in range(2, 104):
        gone = aged(tmp_path, START + day * DAY, START + day * DAY)
        if gone:
            break
    assert day >= 100 and not hours.hour_file(tmp_path / "data", START).exists()


def test_a_new_plant_and_one_with_a_jumped_clock_at_the_first_start_remove_nothing(tmp_path):
    recorded(tmp_path, [(0, START + k * HOUR, float(k), 0) for k in range(3)])
    hours.fold(tmp_path, tmp_path / "data")
    # Files of an earlier version, and a jump at the very start.
    assert aged(tmp_path, START + 500 * DAY, START + 2 * HOUR) == []
    assert aged(tmp_path / "none", START + 500 * DAY, START) == []


def test_foreign_files_in_the_folders_are_left_alone(tmp_path):
    recorded(tmp_path, [(0, START, 1.0, 0)])
    for name in ("x.values", "2026-99-02T05.000001.values", "2026-03-02T05.x.values"):
        (tmp_path / ".stiction/live/ready" / name).write_bytes(b"junk")
        (tmp_path / ".stiction/live/open" / name).write_bytes(b"junk")
    (tmp_path / "data/2026-99-99").mkdir(parents=True)
    (tmp_path / "data/2026-99-99/05.parquet").write_bytes(b"junk")
    (tmp_path / "data/2026-03-02").mkdir()
    (tmp_path / "data/2026-03-02/.00.parquet.part").write_bytes(b"of a run that was killed")
    hours.Recorder(tmp_path, ["A.OP"]).close()
    hours.known(tmp_path)
    hours.fold(tmp_path, tmp_path / "data")
    assert len(rows(tmp_path)) == 2 and not (tmp_path / "data/2026-03-02/.00.parquet.part").exists()
    hours.retain(tmp_path / "data", keep_s=0.0, most_bytes=0.0, now=START + 9 * HOUR)
    assert (tmp_path / "data/2026-99-99/05.parquet").exists() and (tmp_path / ".stiction/live/ready/x.values").exists()


def test_a_later_run_takes_back_what_an_earlier_one_recorded_and_a_cut_record_moves_none(tmp_path):
    recorder = hours.Recorder(tmp_path, ["A.OP"])
    for second in (0, 1, 4000):
        recorder.add(0, START + second * SECOND, float(second), 0)
    recorder.close()
    [journal] = (tmp_path / ".stiction/live/open").glob("*T01*")
    journal.write_bytes(journal.read_bytes() + b"half a record")
    again = hours.Recorder(tmp_path, ["A.OP"])
    again.void(START + HOUR)
    again.add(0, START + 4001 * SECOND, 7.0, 0)
    again.flush()
    again.release(1 << 62)
    again.close()
    assert [folded.problems for folded in hours.fold(tmp_path, tmp_path / "data")] == [[], []]
    assert listed(rows(tmp_path)["A.OP"]) == [(0, 0.0, 0), (SECOND, 1.0, 0)]
    assert listed(rows(tmp_path, START + HOUR)["A.OP"]) == [(4001 * SECOND, 7.0, 0)]


def test_later_values_that_disagree_are_kept_and_reported(tmp_path):
    recorded(tmp_path, [(0, START, 1.0, 0), (0, START + 1, 2.0, 0), (1, START, 3.0, 0)])
    hours.fold(tmp_path, tmp_path / "data")
    recorded(tmp_path, [(0, START + 1, 2.0, 0), (0, START, 9.0, 0), (1, START + 1, 4.0, 0)])
    [folded] = hours.fold(tmp_path, tmp_path / "data")
    assert listed(rows(tmp_path)["A.OP"]) == [(0, 1.0, 0), (0, 9.0, 0), (1, 2.0, 0)]
    [problem] = folded.problems
    assert problem.endswith("differ from stored values of the same times; both are kept (A.OP)") and "2026-03-02 00:00:00" in problem


def hostile(count):
    """Names of tags with letters that formats treat in their own way."""
    own = random.Random(1)
    letters = [chr(k) for k in range(1, 0x20)] + list("{}\"'%=#[]\\/.;,: \x7f\x85\u2028\u2029\ufeff\u00e4\u0130\U0001f600aA") + ["\0", "\r\n", "../", "%s", "{0}"]
    names = {"".join(own.choices(letters, k=own.randrange(1, 12))) for _ in range(count)} | {"x" * 70_000, "\u00e4" * 5_000}
    # The long ones are among them.
    return sorted(sorted(names, key=len)[-count:])


def test_hostile_names_are_recorded_and_read_and_recorded_again(tmp_path):
    # With 10,000 names it takes 20 s.
    for count, times in ((1_000, 1), (200, 2)):
        names, plant = hostile(count), tmp_path / str(count)
        for again in range(times):
            recorded(plant, [(k, START + again, float(k), 0) for k in range(count)], names)
            [folded] = hours.fold(plant, plant / "data")
            assert folded.problems == []
        found = rows(plant)
        assert list(found) == names
        assert all(listed(own) == [(again, float(k), 0) for again in range(times)] for k, own in enumerate(found.values()))
