"""Days that were fetched are only added to, whatever the source forgets, corrects or spoils, and whenever a run is killed."""

import random

import numpy as np
import pytest

pytest.importorskip("pyarrow")

from stiction.live import fetched, hours, sql
from stiction.live.errors import Refused

START = 1_772_409_600_000_000
SECOND = 1_000_000


def rows(values):
    """Rows of (time, value or None)."""
    own = sorted(values)
    number = [np.nan if value is None else value for _, value in own]
    status = [hours.BAD if value is None else 0 for _, value in own]
    return hours.Rows(np.array([time for time, _ in own], np.int64), np.array(number, np.float64), np.array(status, np.uint32))


def stored(folder):
    found = {}
    for path in sorted(folder.rglob("*.parquet")):
        for tag, own in hours.tables_by_tag(path):
            for time, value, status in zip(own.time.tolist(), own.value.tolist(), own.status.tolist()):
                if status < hours.BAD:
                    assert (tag, time) not in found, "a time has one value"
                    found[tag, time] = value
    return found


@pytest.mark.parametrize("seed", range(40))
def test_any_sequence_of_fetches_keeps_all_that_was_stored(tmp_path, seed, monkeypatch):
    own = random.Random(seed)
    sources = {name: {} for name in ("samples", "other table", "OTHER.table")}
    expected, notes, corrected = {}, [], 0
    for _ in range(25):
        name = own.choice(list(sources))
        source = sources[name]
        change = own.choice(["new", "new", "purge", "correct", "spoil", "kill"])
        if change == "new":
            for _ in range(own.randrange(1, 30)):
                tag = f"{name}.{own.choice(['OP', 'PV'])}"
                source[tag, START + own.randrange(0, 86_400) * SECOND] = round(own.uniform(0, 100), 3)
        elif change == "purge":
            limit = START + own.randrange(0, 86_400) * SECOND
            for key in [key for key in source if key[1] < limit]:
                del source[key]
        elif source and change in ("correct", "spoil"):
            source[own.choice(list(source))] = round(own.uniform(200, 300), 3) if change == "correct" else None
        path = fetched.folder_of(tmp_path, name) / "2026-03-02.parquet"
        fetched.begin(path.parent, {tag for tag, _ in source})

        def series(source=source):
            for tag in sorted({tag for tag, _ in source}):
                yield tag, rows([(time, value) for (each, time), value in source.items() if each == tag])

        before = stored(tmp_path / "data")
        if change == "kill":
            with monkeypatch.context() as patched:
                patched.setattr(hours.os, "replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt()))
                try:
                    fetched.add(path, series(), lambda _: None)
                except KeyboardInterrupt:
                    pass
            assert stored(tmp_path / "data") == before
            continue
        said = len(notes)
        fetched.add(path, series(), notes.append)
        news = {key: value for key, value in source.items() if value is not None}
        differ = [key for key, value in news.items() if expected.get(key, value) != value]
        corrected += len(differ)
        assert (len(notes) > said) == bool(differ), "what differs is reported"
        expected |= news
        assert stored(tmp_path / "data") == expected
    assert len({fetched.folder_of(tmp_path, name) for name in sources}) == 3 and not list(tmp_path.rglob("*.part"))


def test_a_killed_run_leaves_its_unfinished_file_for_the_next_to_remove(tmp_path):
    folder, other = (fetched.folder_of(tmp_path, name) for name in ("samples", "other"))
    parts = [each / ".2026-03-02.parquet.part" for each in (folder, other, folder.parent)]
    for part in parts:
        part.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(b"half")
    fetched.begin(folder, [])
    # Another source may be writing its own.
    assert [part.exists() for part in parts] == [False, True, False]


class Historian(sql.Table):
    """A table that gains, loses and corrects rows, as `sql.fetch` reads it."""

    def __init__(self, name):
        self.name, self.rows_of, self.broken = f"table {name}", {}, 0

    @property
    def loops(self):
        return [("A", sorted({tag for tag, _ in self.rows_of}))]

    def span(self, begin=None, end=None):
        times = [time for _, time in self.rows_of if (begin is None or time >= begin) and (end is None or time < end)]
        return (min(times), max(times)) if times else None

    def rows(self, tags, begin, end):
        for tag in tags:
            if self.broken and self.broken < end:
                raise Refused("the connection was lost")
            own = [(time, value) for (each, time), value in self.rows_of.items() if each == tag and begin <= time < end]
            if own:
                yield tag, rows(own)

    def close(self):
        pass


@pytest.mark.parametrize("seed", range(6))
def test_fetches_keep_all_that_was_offered_through_jumps_outages_purges_and_kills(tmp_path, seed, monkeypatch):
    own, day = random.Random(seed), sql.DAY
    (tmp_path / "plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    # Two tables of one server, and one of the same name on another server.
    sources = {"a": Historian("samples"), "b": Historian("other"), "c": Historian("samples")}
    monkeypatch.setattr(sql, "samples_of", lambda url, *_: sources[url])
    now, clock, expected, notes, days = START, 0, {}, [], 0
    monkeypatch.setattr(sql, "time_ns", lambda: 1000 * (now + clock))
    for turn in range(20):
        name = own.choice(list(sources))
        now += own.choice([0, 3600 * SECOND, day, 3 * day if turn % 7 == 0 else day // 2])
        for each, source in sources.items():
            # The plant goes on, whether or not it is fetched.
            for _ in range(3):
                source.rows_of[f"{each}.PV", max(START, now - own.randrange(0, day // 2)) // SECOND * SECOND] = float(own.randrange(10**6))
        source = sources[name]
        event = own.choice(["none", "none", "jump", "outage", "purge", "kill", "stray"])
        clock = own.choice([-1, 1]) * 300 * day if event == "jump" else 0
        source.broken = now - own.randrange(0, 2 * day) if event == "outage" else 0
        if event == "stray":
            source.rows_of[f"{name}.PV", now + 280 * day] = 1.0
        before = stored(tmp_path / "data")
        with monkeypatch.context() as patched:
            if event == "kill":
                patched.setattr(hours.os, "replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt()))
            try:
                sql.fetch(name, tmp_path, note=notes.append)
            except (Refused, KeyboardInterrupt):
                assert before.items() <= stored(tmp_path / "data").items()
                continue
        offered = {key: value for key, value in source.rows_of.items() if key[1] <= min(now, now + clock) + day}
        if clock >= 0:
            expected |= offered
        found = stored(tmp_path / "data")
        assert expected.items() <= found.items(), (turn, event)
        assert before.keys() <= found.keys()
        if own.random() < 0.3:
            limit = now - own.randrange(0, 3 * day)
            for key in [key for key in source.rows_of if key[1] < limit and key in found]:
                del source.rows_of[key]
    assert not list(tmp_path.rglob("*.part"))


def test_one_table_is_fetched_by_one_run_at_a_time(tmp_path, monkeypatch):
    (tmp_path / "plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    source = Historian("samples")
    source.rows_of["A.PV", START] = 1.0
    monkeypatch.setattr(sql, "samples_of", lambda *_: source)
    with hours.alone(tmp_path, "samples.lock", ""), pytest.raises(Refused, match="another fetch of table samples is running; wait for its end"):
        sql.fetch("a", tmp_path)
    sql.fetch("a", tmp_path)
    assert stored(tmp_path / "data") == {("A.PV", START): 1.0}
