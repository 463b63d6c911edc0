"""Samples from PostgreSQL, with its own client and with an ODBC driver: the rows are those of the table, in memory for a day of a loop,
in transactions that cannot write."""

import json
import os
import shutil
import subprocess
import sys
from glob import glob
from urllib.parse import urlsplit

import numpy as np
import pytest

psycopg = pytest.importorskip("psycopg")

import stiction.plant
from processes import HERE, mariadb, postgres, postgres_programs
from server import at, played
from stiction.live import first, hours, sql
from stiction.live.errors import Refused

@pytest.fixture(scope="module")
def database(tmp_path_factory):
    if not postgres_programs():
        pytest.skip("PostgreSQL is not installed")
    with postgres(tmp_path_factory.mktemp("cluster")) as url:
        yield url


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
    for path in sorted((folder / "data" / "sql").rglob("*.parquet")):
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


def test_days_without_rows_have_no_files(filled, fetched):
    done = sql.fetch(filled, fetched, table="wide", since="2026-01-01")
    assert done["days"] == 1 and [path.name for path in (fetched / "data/sql").rglob("*.parquet")] == ["2026-03-02.parquet"]
    # A table whose first days were removed: a day that is asked for again has no rows, and no file.
    with psycopg.connect(filled) as connection:
        connection.execute("CREATE TABLE apart AS SELECT time, \"FIC1002.OP\", \"FIC1002.PV\" FROM wide LIMIT 10")
        connection.execute("INSERT INTO apart SELECT time + interval '3 days', 1, 2 FROM apart")
    done = sql.fetch(filled, fetched, table="apart")
    assert done == {"days": 2, "rows": 40, "loops": 1}
    assert sorted(path.name for path in (fetched / "data/sql/apart").iterdir()) == ["2026-03-02.parquet", "2026-03-05.parquet"]
    with pytest.raises(Refused, match='"yesterday" is not a day'):
        sql.fetch(filled, fetched, table="apart", since="yesterday")


def test_the_trial_of_many_loops_and_days_compares_every_row():
    # With --loops 200 --days 7 it gives the figures of docs/live.md.
    if not postgres_programs():
        pytest.skip("PostgreSQL is not installed")
    words = [sys.executable, HERE.parents[1] / "benchmarks/live.py", "sql", "--loops", "3", "--days", "3"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "and 3 days" in done.stdout and "rows compared, other rows on no day" in done.stdout


def made(url, table, orders):
    with psycopg.connect(url, autocommit=True) as connection:
        for order in orders:
            connection.execute(order.replace("TABLE_", table))


LONG = "CREATE TABLE TABLE_ AS SELECT tag, time, value, quality FROM samples WHERE tag LIKE 'FIC1002.%'"


def test_tables_of_a_plant_do_not_overwrite_each_other(filled, fetched):
    made(filled, "one_of_two", [LONG])
    made(filled, "two_of_two", [LONG, "UPDATE TABLE_ SET tag = replace(tag, '1002', '2002')", "DELETE FROM TABLE_ WHERE value IS NULL"])
    sql.fetch(filled, fetched, table="one_of_two")
    before = stored(fetched)
    sql.fetch(filled, fetched, table="two_of_two")
    after = stored(fetched)
    assert {tag: after[tag] for tag in before} == before
    assert {tag: after[tag.replace("1002", "2002")] for tag in before} == before and len(after) == 2 * len(before)
    # An empty day of one takes nothing from the other.
    made(filled, "two_of_two", ["DELETE FROM TABLE_", "INSERT INTO TABLE_ SELECT replace(tag, '1002', '2002'), time + interval '3 days', value, quality FROM one_of_two WHERE time < '2026-03-02 00:01+00'"])
    sql.fetch(filled, fetched, table="two_of_two", since="2026-03-01")
    assert {tag: own for tag, own in stored(fetched).items() if tag in before} == before


def test_a_table_that_forgets_old_rows_takes_none_away_and_corrections_are_reported(filled, fetched):
    made(filled, "rolling", [LONG])
    notes = []
    sql.fetch(filled, fetched, table="rolling", note=notes.append)
    before = stored(fetched)
    made(filled, "rolling", ["DELETE FROM TABLE_ WHERE time < timestamptz '2026-03-02 12:00+00'"])
    [path] = (fetched / "data/sql/rolling").iterdir()
    age = path.stat().st_mtime_ns
    done = sql.fetch(filled, fetched, table="rolling", note=notes.append)
    assert stored(fetched) == before and notes == [] and done["rows"] > 0
    assert path.stat().st_mtime_ns == age, "a day without news is not written again"
    # A correction, a new row, a value that became bad.
    times = [time for time, _ in before["FIC1002.PV"] if time >= 1_772_452_800_000_000]
    at_ = [f"timestamptz 'epoch' + interval '{time} microseconds'" for time in times[:3]]
    made(filled, "rolling", [
        f"UPDATE TABLE_ SET value = 7.5 WHERE tag = 'FIC1002.PV' AND time = {at_[0]}",
        f"UPDATE TABLE_ SET value = NULL, quality = 'Bad' WHERE tag = 'FIC1002.PV' AND time = {at_[1]}",
        f"INSERT INTO TABLE_ SELECT tag, {at_[2]} + interval '1 ms', 8.5, 'Good' FROM samples WHERE tag = 'FIC1002.PV' LIMIT 1",
    ])  # fmt: skip
    sql.fetch(filled, fetched, table="rolling", note=notes.append)
    expected = dict(before["FIC1002.PV"]) | {times[0]: 7.5, times[2] + 1000: 8.5}
    assert stored(fetched)["FIC1002.PV"] == sorted(expected.items())
    assert notes == ["rolling 2026-03-02: 1 value differs from those fetched before for FIC1002.PV; the new ones are stored"]


def test_days_of_an_earlier_version_come_to_the_folder_of_their_table(filled, fetched):
    made(filled, "moved", [LONG])
    sql.fetch(filled, fetched, table="moved")
    [path] = (fetched / "data/sql/moved").iterdir()
    before = stored(fetched)
    path.rename(fetched / "data/sql" / path.name)
    (fetched / "data/sql/2026-03-01.parquet").write_bytes(b"a file of someone else")
    sql.fetch(filled, fetched, table="moved")
    (fetched / "data/sql/2026-03-01.parquet").unlink()
    assert stored(fetched) == before and path.exists()


def test_stray_times_cost_a_line_and_no_query_a_day(filled, fetched, monkeypatch):
    strays = ["1970-01-01", "0001-01-01", "2999-01-01"]
    made(filled, "stray", [LONG, *(f"INSERT INTO TABLE_ VALUES ('FIC1002.PV', '{at}', 1, 'Good')" for at in strays)])
    made(filled, "stray", ["INSERT INTO TABLE_ VALUES ('FIC1002.PV', '1990-01-01', 1, 'Good')"])
    asked, select = [], sql.Postgres.select
    monkeypatch.setattr(sql.Postgres, "select", lambda own, *more, **named: asked.append(1) or select(own, *more, **named))
    notes = []
    for _ in range(2):
        sql.fetch(filled, fetched, table="stray", note=notes.append)
    assert len(asked) < 30 and "before 1980, such as of 1" in notes[0] and "in the future, such as of 2999-01-01" in notes[1]
    assert sorted(path.stem for path in (fetched / "data/sql/stray").iterdir()) == ["1990-01-01", "2026-03-02"]
    made(filled, "infinite", [LONG, *(f"INSERT INTO TABLE_ VALUES ('FIC1002.PV', '{at}', 1, 'Good')" for at in ("infinity", "-infinity", "0044-03-15 BC"))])
    notes.clear()
    sql.fetch(filled, fetched, table="infinite", note=notes.append)
    assert ["before 1980" in notes[0], "in the future" in notes[1]] == [True, True] and len(notes) == 2
    wanted = {path.name: path.read_bytes() for path in (fetched / "data/sql/stray").iterdir()}
    assert (fetched / "data/sql/infinite/2026-03-02.parquet").read_bytes() == wanted["2026-03-02.parquet"]
    made(filled, "only_stray", [LONG, "UPDATE TABLE_ SET time = '1970-01-01'"])
    with pytest.raises(Refused, match="no rows between 1980 and now"):
        sql.fetch(filled, fetched, table="only_stray")


def test_odd_names_types_and_qualities_are_read_or_refused_by_name(filled, fetched):
    made(filled, "truth", [LONG, "ALTER TABLE TABLE_ ALTER quality TYPE boolean USING quality = 'Good'"])
    made(filled, "braces", ['CREATE TABLE TABLE_ AS SELECT time, "FIC1002.OP" AS "FIC1{}.OP", "FIC1002.PV" AS "FIC1{}.PV", 1 AS "FIC2{0}.OP" FROM wide'])
    made(filled, "percent", ['CREATE TABLE TABLE_ AS SELECT time AS "time %s", "FIC1002.OP" AS "F%(a)s.OP", "FIC1002.PV" AS "F%(a)s.PV" FROM wide'])
    sql.fetch(filled, fetched, table="truth")
    wanted = stored(fetched)
    with psycopg.connect(filled) as connection:
        rows = connection.execute("SELECT count(*) FROM samples WHERE tag LIKE 'FIC1002.%' AND value IS NOT NULL").fetchone()[0]
    assert sum(map(len, wanted.values())) == rows
    sql.fetch(filled, fetched, table="braces")
    assert stored(fetched)["FIC1{}.PV"] == wanted["FIC1002.PV"][: len(stored(fetched)["FIC1{}.PV"])]
    for change, words in [
        ("double precision USING 'NaN'::float8", '"nan" is not a known quality'),
        ("jsonb USING '{\"good\": 1}'::jsonb", "column quality: .* is not a known quality"),
    ]:
        made(filled, "odd_quality", ["DROP TABLE IF EXISTS TABLE_", LONG, f"ALTER TABLE TABLE_ ALTER quality TYPE {change}"])
        with pytest.raises(Refused, match=words):
            sql.fetch(filled, fetched, table="odd_quality")


def test_tags_in_two_spellings_are_read(filled, fetched):
    with psycopg.connect(filled, autocommit=True) as connection:
        if not connection.execute("SELECT 1 FROM pg_available_extensions WHERE name = 'citext'").fetchone():
            pytest.skip("the extension citext is not installed")
        connection.execute("CREATE EXTENSION IF NOT EXISTS citext")
    made(filled, "spelled", [LONG, "ALTER TABLE TABLE_ ALTER tag TYPE citext", "UPDATE TABLE_ SET tag = lower(tag) WHERE extract(minute FROM time) < 30"])
    done = sql.fetch(filled, fetched, table="spelled")
    found = stored(fetched)
    assert done["rows"] == sum(map(len, found.values())) + 1 and len(found) == 3


def test_locked_tables_and_silent_ports_end(filled, fetched, monkeypatch):
    import socket

    monkeypatch.setattr(sql, "LOCK_S", 1)
    made(filled, "locked", [LONG])
    with psycopg.connect(filled) as other:
        other.execute("LOCK TABLE locked IN ACCESS EXCLUSIVE MODE")
        with pytest.raises(Refused, match="table locked: canceling statement due to lock timeout"):
            sql.fetch(filled, fetched, table="locked")
    monkeypatch.setattr(sql, "CONNECT_S", 2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        with pytest.raises(Refused, match="timeout expired"):
            sql.fetch(f"postgres://owner@127.0.0.1:{silent.getsockname()[1]}/postgres?table=a", fetched)


def test_no_secret_of_an_address_is_printed(tmp_path):
    for url in (
        "postgres://reader:a/SECRET@host/db?table=t",
        "postgres://reader:a@SECRET@host/db?table=t",
        "postgres://reader@host/db?table=t&sslpassword=SECRET",
        "odbc://DSN=x;PWD=SECRET?table=t",
    ):
        for attempt in (lambda url=url: sql.opened(url), lambda url=url: sql.fetch(url, tmp_path / "no plant")):
            with pytest.raises(Refused) as refused:
                attempt()
            assert "SECRET" not in str(refused.value), url


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
        ("mysql://host/db?table=a", "is not supported"),
        ("postgres://owner@127.0.0.1:1/postgres?table=samples", "postgres://owner@127.0.0.1:1/postgres"),
    ]:
        with pytest.raises(Refused) as refused:
            sql.fetch(url, fetched)
        assert words in str(refused.value) and "Pa55" not in str(refused.value)
    with psycopg.connect(filled) as connection:
        connection.execute("CREATE TABLE timeless (tag text, value float8)")
        connection.execute("CREATE TABLE doubtful AS SELECT tag, time, value, 'purple' AS quality FROM samples LIMIT 10")
    for table, words in [("timeless", "include no column of times"), ("doubtful", '"purple" is not a known quality')]:
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
    [path] = list((fetched / "data/sql").rglob("2026-03-02.parquet"))
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


@pytest.fixture
def odbc(filled):
    """The address of the same database through Debian's ODBC driver."""
    driver = next(iter(glob("/usr/lib/*/odbc/psqlodbcw.so")), None)
    if driver is None:
        pytest.skip("the ODBC driver of PostgreSQL (odbc-postgresql) is not installed")
    pytest.importorskip("arrow_odbc")
    parts = urlsplit(filled)
    return f"odbc://Driver={driver};Server={parts.hostname};Port={parts.port};Database=postgres;UID={parts.username}"


def test_an_odbc_driver_gives_the_rows_of_the_table(odbc, filled, plant, fetched):
    done = sql.fetch(f"{odbc}?table=samples", fetched)
    expected = {tag: list(zip(times.tolist(), values.tolist())) for tag, (times, values) in played(plant, None).items()}
    assert stored(fetched) == expected and done["loops"] == 6
    # Row by row as with PostgreSQL's own client, and the bad value as well.
    one, *more = [path.read_bytes() for path in (fetched / "data/sql").rglob("*.parquet")]
    sql.fetch(f"{filled}?table=samples", fetched)
    assert not more and [one] == [path.read_bytes() for path in (fetched / "data/sql").rglob("*.parquet")]


def test_an_odbc_driver_gives_a_wide_table_and_single_precision(odbc, filled, plant, fetched):
    with psycopg.connect(filled) as connection:
        connection.execute(
            'CREATE TABLE mixed AS SELECT time, a.value AS "FIC1002.OP", b.value::real AS "FIC1002.PV", round(c.value)::numeric(9, 2) AS "FIC1002.SP" '
            "FROM samples a JOIN samples b USING (time) JOIN samples c USING (time) "
            "WHERE a.tag = 'FIC1002.OP' AND b.tag = 'FIC1002.PV' AND c.tag = 'FIC1002.SP' AND a.value IS NOT NULL"
        )
    sql.fetch(odbc, fetched, table="mixed")
    found = stored(fetched)
    data = played(plant, None)
    for name, of in [("OP", np.float64), ("PV", np.float32), ("SP", np.round)]:
        assert np.array_equal(of([value for _, value in found[f"FIC1002.{name}"]]), of(data[f"FIC1002.{name}"][1]))
    sql.fetch(filled, fetched, table="mixed")
    assert stored(fetched) == found


def test_the_last_day_of_an_odbc_table_has_its_last_row(odbc, filled, plant, tmp_path):
    found = []
    for url in (odbc, filled):
        sql.samples(url, tmp_path / "day.parquet", "samples")
        found.append({tag: rows.time.tolist() for tag, rows in hours.tables_by_tag(tmp_path / "day.parquet")})
    # The last row is among them.
    last = max(times[-1] for times, _ in played(plant, None).values())
    assert found[0] == found[1] and max(times[-1] for times in found[0].values()) == last


def test_times_of_an_odbc_session_are_those_of_the_plant(odbc, filled, fetched):
    with psycopg.connect(filled, autocommit=True) as connection:
        connection.execute("ALTER ROLE owner SET TimeZone = 'America/New_York'")
    try:
        sql.fetch(f"{odbc};ConnSettings=SET TimeZone='UTC'?table=wide", fetched)
        wanted = stored(fetched)
        path = fetched / "plant.toml"
        path.write_text(path.read_text().replace('zone = "UTC"', 'zone = "America/New_York"'))
        sql.fetch(f"{odbc}?table=wide", fetched)
        assert stored(fetched) == wanted
    finally:
        with psycopg.connect(filled, autocommit=True) as connection:
            connection.execute("ALTER ROLE owner RESET TimeZone")


@pytest.mark.skipif(shutil.which("mariadbd") is None, reason="MariaDB is not installed")
def test_another_database_quotes_names_in_its_own_way(plant, fetched, tmp_path, tmp_path_factory, monkeypatch):
    driver = next(iter(glob("/usr/lib/*/odbc/libmaodbc.so")), None)
    if driver is None:
        pytest.skip("the ODBC driver of MariaDB (odbc-mariadb) is not installed")
    pytest.importorskip("arrow_odbc")
    data = played(plant, None)
    with open(tmp_path / "rows", "w") as file:
        for tag, (times, values) in data.items():
            file.writelines(f"{at(time):%Y-%m-%d %H:%M:%S.%f}\t{tag}\t{float(value)!r}\n" for time, value in zip(times, values))
    with mariadb(tmp_path_factory.mktemp("mariadb")) as (port, run):
        run(
            "CREATE DATABASE plant; USE plant; CREATE TABLE `two words` (`time` datetime(6), `tag` varchar(60), `value` double); "
            f"LOAD DATA LOCAL INFILE '{tmp_path / 'rows'}' INTO TABLE `two words`; CREATE INDEX one ON `two words` (tag, time); "
            "CREATE USER reader IDENTIFIED BY 'Pa55'; GRANT SELECT ON plant.* TO reader"
        )
        monkeypatch.setenv("STICTION_SQL_PASSWORD", "Pa55")
        url = f"odbc://Driver={driver};Server=127.0.0.1;Port={port};Database=plant;UID=reader"
        sql.fetch(f"{url}?table=two words", fetched)
        assert stored(fetched) == {tag: list(zip(times.tolist(), values.tolist())) for tag, (times, values) in data.items()}
        with pytest.raises(Refused, match="Table 'plant.none_such' doesn't exist"):
            sql.fetch(f"{url}?table=none_such", fetched)
        monkeypatch.setenv("STICTION_SQL_PASSWORD", "wr0ng")
        with pytest.raises(Refused, match="Access denied for user 'reader'") as refused:
            sql.fetch(f"{url}?table=two words", fetched)
        assert "wr0ng" not in str(refused.value)


def test_nothing_sent_to_an_odbc_driver_is_committed(odbc, filled):
    source = sql.opened(odbc, "samples")
    # What an account that may write could do at worst.
    list(source._batches("WITH gone AS (DELETE FROM samples RETURNING tag) SELECT count(*) FROM gone", []))
    source.close()
    with psycopg.connect(filled) as connection:
        assert connection.execute("SELECT count(*) FROM samples").fetchone()[0] > 1000


def test_faults_of_an_odbc_driver_are_named(odbc, fetched, monkeypatch):
    monkeypatch.setenv("STICTION_SQL_PASSWORD", "Pa55")
    for url, words in [
        (odbc, "names no table"),
        (f"{odbc}?table=none_such", 'relation "none_such" does not exist'),
        (f"{odbc};Port=1?table=samples", "port 1 failed: Connection refused"),
        ("odbc://DSN=none_such?table=samples", "Data source name not found"),
        (f"{odbc};PWD=Pa55?table=samples", "STICTION_SQL_PASSWORD"),
    ]:
        with pytest.raises(Refused) as refused:
            sql.fetch(url, fetched)
        assert words in str(refused.value) and "Pa55" not in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("quality", "status"),
    [(None, 0), ("Good", 0), ("BAD, device failure", hours.BAD), ("uncertain", 0x4000_0000), (192, 0), (64, 0x4000_0000), (0, hours.BAD), (-2147483648, hours.BAD)],
)
def test_qualities_are_status_codes(quality, status):
    table = sql.Table.__new__(sql.Table)
    table.quality = "quality"
    assert table._status(quality) == status


@pytest.mark.parametrize("through", ["filled", "odbc"])
def test_a_table_of_any_size_takes_memory_for_a_day_of_a_loop(through, request, filled, fetched):
    url = request.getfixturevalue(through)
    # Fifty more loops make the table larger, and not the process.
    with psycopg.connect(filled) as connection:
        connection.execute(
            "CREATE TABLE IF NOT EXISTS many AS SELECT replace(tag, '.', '-' || k || '.') AS tag, time, value FROM samples, generate_series(1, 8) k WHERE tag LIKE 'FIC1002.%' OR tag LIKE 'FIC1005.%'"
        )
        connection.execute("CREATE INDEX IF NOT EXISTS many_tag ON many (tag, time)")
    most = []
    for table in ("wide", "many"):
        # Not with `resource`, whose figure begins with that of the process that started this one.
        code = (
            "from pathlib import Path; from stiction.live import sql; "
            f"sql.fetch({url!r}, Path({str(fetched)!r}), table={table!r}); "
            "print(Path('/proc/self/status').read_text().split('VmHWM:')[1].split()[0])"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
        most.append(int(done.stdout))
    assert most[1] < most[0] + 60_000, f"{most} kB"
