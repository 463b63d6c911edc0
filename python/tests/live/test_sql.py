"""Samples from PostgreSQL: the rows are those of the table, in memory for a day of a loop, in transactions that cannot write."""

import json
import os
import shutil
import subprocess
import sys
from glob import glob

import pytest

psycopg = pytest.importorskip("psycopg")

import stiction.plant
from processes import free_port
from server import at, played
from stiction.live import first, hours, sql
from stiction.live.errors import Refused

BIN = next(iter(sorted(glob("/usr/lib/postgresql/*/bin"), reverse=True)), None) or os.path.dirname(shutil.which("initdb") or "")


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    """A cluster of its own, on 127.0.0.1."""
    if not BIN:
        pytest.skip("PostgreSQL is not installed")
    folder, port = tmp_path_factory.mktemp("cluster"), free_port()
    user = []
    if os.geteuid() == 0:
        # PostgreSQL refuses to run as root.
        user = ["runuser", "-u", "postgres", "--"]
        shutil.chown(folder, "postgres")
        for parent in [folder, *folder.parents]:
            if parent.stat().st_uid == 0 and str(parent) != "/":
                parent.chmod(parent.stat().st_mode | 0o011)
    run = lambda *words: subprocess.run([*user, *map(str, words)], check=True, capture_output=True, timeout=60, cwd="/")  # noqa: E731
    data = folder / "data"
    run(f"{BIN}/initdb", "-D", data, "-A", "trust", "-U", "owner", "--no-sync")
    options = f"-p {port} -c listen_addresses=127.0.0.1 -k {folder} -c fsync=off"
    run(f"{BIN}/pg_ctl", "-D", data, "-w", "-l", folder / "log", "-o", options, "start")
    try:
        yield f"postgres://owner@127.0.0.1:{port}/postgres"
    finally:
        run(f"{BIN}/pg_ctl", "-D", data, "-m", "immediate", "stop")


@pytest.fixture(scope="module")
def filled(database, plant):
    """The plant as tables: long, and wide for one loop."""
    data = played(plant, None)
    with psycopg.connect(database) as connection, connection.cursor() as cursor:
        cursor.execute("CREATE TABLE samples (tag text, time timestamptz, value double precision, quality text)")
        with cursor.copy("COPY samples FROM STDIN") as copy:
            for tag, (times, values) in data.items():
                for time, value in zip(times, values):
                    copy.write_row((tag, at(time), float(value), "Good"))
            copy.write_row(("FIC1002.OP", at(data["FIC1002.OP"][0][-1] + 1_000_000), None, "Bad"))
        cursor.execute("CREATE INDEX ON samples (tag, time)")
        cursor.execute(
            'CREATE TABLE wide AS SELECT a.time, a.value AS "FIC1002.OP", b.value AS "FIC1002.PV" FROM samples a JOIN samples b USING (time) '
            "WHERE a.tag = 'FIC1002.OP' AND b.tag = 'FIC1002.PV' AND a.value IS NOT NULL"
        )
    return database


@pytest.fixture
def fetched(plant, tmp_path):
    folder = tmp_path / "fetched"
    folder.mkdir()
    (folder / "plant.toml").write_text((plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
    return folder


def stored(folder):
    found = {}
    for path in sorted((folder / "data" / "sql").glob("*.parquet")):
        for tag, rows in hours.tables_by_tag(path):
            own = rows.status < hours.BAD
            found.setdefault(tag, []).extend(zip(rows.time[own].tolist(), rows.value[own].tolist()))
    return found


def test_rows_and_verdicts_are_those_of_the_table(filled, plant, fetched):
    done = sql.fetch(f"{filled}?table=samples", fetched)
    expected = {tag: list(zip(times.tolist(), values.tolist())) for tag, (times, values) in played(plant, None).items()}
    assert stored(fetched) == expected and done["loops"] == 6
    for folder in (plant, fetched):
        stiction.plant.scan(folder)
    wanted, found = (stiction.plant.windows(folder).to_dict() for folder in (plant, fetched))
    assert found["verdict"] == wanted["verdict"] and found["samples"] == wanted["samples"]
    # Only the end is read again, and nothing is judged again.
    again = sql.fetch(f"{filled}?table=samples", fetched)
    assert again["rows"] > 0 and stored(fetched) == expected
    assert stiction.plant.scan(fetched).windows == 0


def test_a_wide_table_is_read(filled, plant, fetched):
    sql.fetch(filled, fetched, table="wide")
    data = played(plant, None)
    assert stored(fetched) == {tag: list(zip(*(each.tolist() for each in data[tag]))) for tag in ("FIC1002.OP", "FIC1002.PV")}


def test_a_plant_is_proposed_from_a_table(filled, tmp_path):
    loops, _ = first.of_samples(tmp_path, lambda path: sql.samples(filled, path, "samples"))
    text = (tmp_path / "plant.toml").read_text()
    assert loops == 6 and '[loop."FIC1002"]' in text and 'data = ["data/**/*.parquet"]' in text


@pytest.mark.skipif("STICTION_PROGRAM" not in os.environ, reason="STICTION_PROGRAM does not name the command stiction")
def test_the_command_reads_a_table_like_its_file(filled, tmp_path):
    def diagnosed(source):
        words = [os.environ["STICTION_PROGRAM"], "--no-config", "diagnose", source, "--json"]
        environment = dict(os.environ, STICTION_PYTHON=sys.executable)
        done = subprocess.run(words, env=environment, cwd=tmp_path, check=True, capture_output=True, timeout=120)
        assert done.stderr == b""
        return [loop["verdict"] for loop in json.loads(done.stdout)["loops"]]

    sql.samples(filled, tmp_path / "day.parquet", "samples")
    found = diagnosed(f"{filled}?table=samples")
    assert len(found) == 6 and found == diagnosed("day.parquet")


def test_the_connection_cannot_write(filled):
    source = sql.opened(filled, "samples")
    for order in ("DELETE FROM samples", "CREATE TABLE other (a int)", "INSERT INTO samples VALUES ('A', now(), 1, 'Good')"):
        with pytest.raises(psycopg.errors.ReadOnlySqlTransaction):
            source.connection.execute(order)
        source.connection.rollback()
    source.close()


def test_names_of_tables_and_columns_are_no_orders(filled, fetched):
    with psycopg.connect(filled) as connection:
        connection.execute('CREATE TABLE "odd; DROP TABLE samples" ("time" timestamptz, "A.OP%s"" --" double precision, "A.OP" float8, "A.PV" float8)')
        connection.execute('INSERT INTO "odd; DROP TABLE samples" SELECT time, 1, value, value FROM samples LIMIT 10')
    sql.fetch(filled, fetched, table="odd; DROP TABLE samples")
    assert len(stored(fetched)["A.OP"]) == 10
    with psycopg.connect(filled) as connection:
        assert connection.execute("SELECT count(*) FROM samples").fetchone()[0] > 1000


def test_faults_are_named_with_the_remedy(filled, fetched):
    for url, words in [
        (filled, "names no table"),
        (f"{filled}?table=none_such", 'table none_such: relation "none_such" does not exist'),
        (filled.replace("owner@", "owner:Pa55@") + "?table=samples", "STICTION_SQL_PASSWORD"),
        (f"{filled}?table=samples&password=Pa55", "STICTION_SQL_PASSWORD"),
        ("mysql://host/db?table=a", "is no known address"),
        ("postgres://owner@127.0.0.1:1/postgres?table=samples", "postgres://owner@127.0.0.1:1/postgres"),
    ]:
        with pytest.raises(Refused) as refused:
            sql.fetch(url, fetched)
        assert words in str(refused.value) and "Pa55" not in str(refused.value)
    with psycopg.connect(filled) as connection:
        connection.execute("CREATE TABLE timeless (tag text, value float8)")
        connection.execute("CREATE TABLE doubtful AS SELECT tag, time, value, 'purple' AS quality FROM samples LIMIT 10")
    for table, words in [("timeless", "include no times"), ("doubtful", '"purple" is no known quality')]:
        with pytest.raises(Refused, match=words):
            sql.fetch(filled, fetched, table=table)


def test_a_lost_connection_is_named(filled, fetched):
    source = sql.opened(filled, "samples")
    with psycopg.connect(filled, autocommit=True) as other:
        other.execute("SELECT pg_terminate_backend(%s)", [source.connection.info.backend_pid])
    with pytest.raises(Refused, match="table samples: "):
        list(source.select(["time"], "", []))
    source.close()


def test_a_failed_fetch_leaves_the_files_as_they_were(filled, fetched, monkeypatch):
    sql.fetch(f"{filled}?table=samples", fetched)
    [path] = list((fetched / "data/sql").glob("2026-03-02.parquet"))
    before = path.read_bytes()
    rows, count = sql.Table.rows, [0]

    def broken(*arguments):
        count[0] += 1
        if count[0] == 3:
            raise psycopg.OperationalError("the connection was lost")
        return rows(*arguments)

    monkeypatch.setattr(sql.Table, "rows", broken)
    with pytest.raises(psycopg.OperationalError):
        sql.fetch(f"{filled}?table=samples", fetched)
    assert path.read_bytes() == before and [each.name for each in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize(
    ("quality", "status"),
    [(None, 0), ("Good", 0), ("BAD, device failure", hours.BAD), ("uncertain", 0x4000_0000), (192, 0), (64, 0x4000_0000), (0, hours.BAD), (-2147483648, hours.BAD)],
)
def test_qualities_are_status_codes(quality, status):
    table = sql.Table.__new__(sql.Table)
    table.quality = "quality"
    assert table._status(quality) == status


def test_a_table_of_any_size_takes_memory_for_a_day_of_a_loop(filled, fetched, tmp_path):
    # Fifty more loops make the table larger, and not the process.
    with psycopg.connect(filled) as connection:
        connection.execute(
            "CREATE TABLE many AS SELECT replace(tag, '.', '-' || k || '.') AS tag, time, value FROM samples, generate_series(1, 8) k WHERE tag LIKE 'FIC1002.%' OR tag LIKE 'FIC1005.%'"
        )
        connection.execute("CREATE INDEX ON many (tag, time)")
    most = []
    for table in ("wide", "many"):
        code = (
            "import resource, sys; from pathlib import Path; from stiction.live import sql; "
            f"sql.fetch({filled!r}, Path({str(fetched)!r}), table={table!r}); print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
        most.append(int(done.stdout))
    assert most[1] < most[0] + 60_000, f"{most} kB"
