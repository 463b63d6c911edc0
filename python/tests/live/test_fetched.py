"""Days that were fetched are only added to, whatever the source forgets, corrects or spoils, and whenever a run is killed."""

import random

import numpy as np
import pytest

pytest.importorskip("pyarrow")

from stiction.live import fetched, hours

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


def test_a_killed_run_leaves_its_unfinished_file_for_the_next_to_remove(tmp_path, monkeypatch):
    folder = fetched.folder_of(tmp_path, "samples")
    folder.mkdir(parents=True)
    part = folder / ".2026-03-02.parquet.part"
    part.write_bytes(b"half")
    fetched.begin(folder, [])
    assert part.exists(), "another run may be writing it"
    monkeypatch.setattr(fetched, "STALE_S", -1.0)
    fetched.begin(folder, [])
    assert not part.exists()
