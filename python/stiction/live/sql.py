"""Tables of samples in SQL databases: PostgreSQL (also TimescaleDB), and any database with an ODBC driver.

A table is long (times, tags, values, perhaps qualities) or wide (times, and a column per tag), as docs/recordings.md describes. The
module reads in a read-only transaction, one loop and one day at a time, so memory contains one day of one loop. Each day is added
to a file, which ``stiction plant scan`` reads.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime, timedelta, timezone
from pathlib import Path
from time import time_ns
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit, urlunsplit

import numpy as np

from stiction import _core
from stiction.live import fetched, hours
from stiction.live.errors import Refused, redacted, refuse_password
from stiction.live.tags import mode_words
from stiction.live.words import number_of

__all__: list[str] = []

DAY = 86_400_000_000
ROWS = 20_000
"""Rows of one transfer from the database."""
AGAIN = 2
"""Days before the last known day that are read again, because late values may have arrived."""
QUALITIES = {"good": hours.GOOD, "uncertain": 0x4000_0000, "bad": hours.BAD}
EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
FIRST = 315_532_800_000_000
"""1980-01-01 in microseconds. Rows with an earlier time have a wrong time."""
AHEAD = DAY
"""Microseconds. Rows that are further ahead of this computer's clock have a wrong time."""
CONNECT_S = 10
"""Time limit for a server to accept a connection, s."""
LOCK_S = 30
"""Longest wait, s, of a query for a table that another connection has locked."""
STATEMENT_S = 600
"""Time limit for the next rows from the database, s."""
LATER = "; samples fetched so far stay, and the next fetch reads the rest"


class Source:
    """A table of a database. Subclasses send the queries."""

    name: str
    columns: list[str]
    mark: str
    """The placeholder in a query for a value that is sent separately."""

    def select(self, columns: Sequence[str], where: str, values: Sequence[Any], order: str = "") -> Iterator[Sequence[Any]]:
        """The rows of a query, transferred in batches."""
        raise NotImplementedError

    def quoted(self, column: str) -> str:
        """A column name, quoted for a query."""
        return '"' + column.replace('"', '""') + '"'

    def close(self) -> None:
        """End the connection."""
        raise NotImplementedError

    def time(self, at: datetime, column: str) -> str:
        """A time in the form in which a query compares times."""
        raise NotImplementedError

    def within(self, time: str, column: str) -> str:
        """The SQL of a time in a column, such as the latest time, limited to times that Python can represent. PostgreSQL has
        infinite times and years BC.
        """
        return time


class Postgres(Source):
    """A table of PostgreSQL."""

    mark = "%s"

    def __init__(self, url: str, table: str) -> None:
        try:
            import psycopg
            from psycopg import sql
        except ImportError as error:
            raise ImportError(f'PostgreSQL needs psycopg ({error}): pip install "stiction[live]"') from None
        self._sql, self._error = sql, psycopg.Error
        # The client's encoding also gives text of a database without an encoding as text.
        own: dict[str, Any] = {"application_name": "stiction", "client_encoding": "utf8", "connect_timeout": CONNECT_S}
        # A network that was cut is noticed in 90 s.
        own |= {"keepalives_idle": 30, "keepalives_interval": 10, "keepalives_count": 6}
        if password := os.environ.get("STICTION_SQL_PASSWORD"):
            own["password"] = password
        try:
            self.connection = psycopg.connect(url, autocommit=True, **own)
            self.connection.execute(f"SET lock_timeout = '{LOCK_S}s'")
            self.connection.execute(f"SET statement_timeout = '{STATEMENT_S}s'")
            self.connection.autocommit = False
        except psycopg.Error as error:
            raise Refused(f"{redacted(url)}: {' '.join(str(error).split())}") from None
        self.connection.read_only = True
        self.connection.isolation_level = psycopg.IsolationLevel.REPEATABLE_READ
        self.name = table
        self._table = sql.Identifier(*table.split("."))
        try:
            with self.connection.cursor() as cursor:
                cursor.execute(sql.SQL("SELECT * FROM {} LIMIT 0").format(self._table))
                described = cursor.description or []
        except psycopg.Error as error:
            self.connection.close()
            raise Refused(f"table {table}: {str(error).strip().splitlines()[0]}") from None
        self.columns = [column.name for column in described]
        self.zoned = {column.name: column.type_code == 1184 for column in described if column.type_code in (1114, 1184)}

    def quoted(self, column: str) -> str:
        # A single % would mark a value.
        return super().quoted(column).replace("%", "%%")

    def time(self, at: datetime, column: str) -> str:
        return f"timestamptz '{at}'" if self.zoned.get(column, True) else f"timestamp '{at.replace(tzinfo=None)}'"

    def within(self, time: str, column: str) -> str:
        if column not in self.zoned:
            return time
        low, high = (self.time(datetime(*day, tzinfo=timezone.utc), column) for day in ((1, 1, 3), (9999, 12, 29)))
        return f"CASE WHEN {time} IS NOT NULL THEN least(greatest({time}, {low}), {high}) END"

    def select(self, columns: Sequence[str], where: str, values: Sequence[Any], order: str = "") -> Iterator[Sequence[Any]]:
        # The names of columns are quoted, and values are sent apart from the query.
        text = self._sql.SQL
        query = text("SELECT " + ", ".join(columns) + " FROM ") + self._table + text(f" {where} {order}")
        try:
            with self.connection.cursor(name="stiction") as cursor:
                cursor.itersize = ROWS
                cursor.execute(query, list(values))
                yield from cursor
        except self._error as error:
            raise Refused(f"table {self.name}: {' '.join(str(error).split())}{LATER}") from None
        except UnicodeDecodeError:
            raise Refused(f"table {self.name}: holds text that is not UTF-8; make a view that converts the text, as in convert_from(tag, 'LATIN1')") from None

    def close(self) -> None:
        # The transaction only read, so nothing is lost without its end.
        self.connection.close()


class Odbc(Source):
    """A table of a database with an ODBC driver, through Arrow. The transaction is never committed."""

    mark = "?"

    def __init__(self, url: str, table: str) -> None:
        known = url.partition("://")[2]
        try:
            import arrow_odbc
        except (ImportError, OSError) as error:
            needed = 'pip install "stiction[odbc]", and the system\'s ODBC driver manager, such as unixodbc on Debian'
            raise ImportError(f"ODBC needs arrow-odbc ({error}): {needed}") from None
        self._error: type[Exception] = arrow_odbc.Error
        self._password = os.environ.get("STICTION_SQL_PASSWORD")
        self.name = table
        try:
            # The password is appended to it.
            self._connection = arrow_odbc.connect(known.rstrip(";") + ";", password=self._password, login_timeout_sec=CONNECT_S, autocommit=False)
        except self._error as error:
            raise Refused(f"{redacted(url)}: {self._without_password(error)}") from None
        for self._quote in ('"', "`"):
            self._table = ".".join(self.quoted(part) for part in table.split("."))
            try:
                self.columns = [field.name for field in self._batches(f"SELECT * FROM {self._table} WHERE 1 = 0", []).schema]
                return
            except Refused as error:
                # MySQL and MariaDB quote names in their own way. The state is that of an error of syntax.
                if self._quote == "`" or "State: 42000" not in str(error):
                    raise
                self._connection.rollback()

    def quoted(self, column: str) -> str:
        return self._quote + column.replace(self._quote, 2 * self._quote) + self._quote

    def _without_password(self, error: Exception) -> str:
        """The message of a driver in one line, without the password."""
        text = " ".join(str(error).split())
        return text.replace(self._password, "...") if self._password else text

    def _batches(self, query: str, values: Sequence[Any]) -> Any:
        try:
            # Drivers state the longest text that a column may hold, and a batch has room for it in every row.
            return self._connection.read_arrow_batches(
                query, batch_size=ROWS, max_bytes_per_batch=1 << 24, max_text_size=4096, parameters=list(values), map_schema=_in_full,
                query_timeout_sec=STATEMENT_S,
            )  # fmt: skip
        except self._error as error:
            raise Refused(f"table {self.name}: {self._without_password(error)}") from None

    def time(self, at: datetime, column: str) -> str:
        # The driver turns this into what its database understands. Some databases know no parts of a second.
        return f"{{ts '{at:%Y-%m-%d %H:%M:%S}'}}"

    def select(self, columns: Sequence[str], where: str, values: Sequence[Any], order: str = "") -> Iterator[Sequence[Any]]:
        batches = self._batches(f"SELECT {', '.join(columns)} FROM {self._table} {where} {order}", values)
        try:
            for batch in batches:
                yield from zip(*(column.to_pylist() for column in batch.columns))
        except self._error as error:
            raise Refused(f"table {self.name}: {self._without_password(error)}{LATER}") from None

    def close(self) -> None:
        # Without a reference to it, the connection is closed.
        del self._connection


def _in_full(schema: Any) -> Any:
    """The columns that Arrow reads, but with all digits of numbers, because drivers state the digits in two ways."""
    import pyarrow as pa

    return pa.schema([each.with_type(pa.float64()) if pa.types.is_floating(each.type) else each for each in schema])


def samples_of(url: str, table: str | None, file: _core.Plant) -> Any:
    """The samples at an address."""
    if url.startswith("pi://"):
        from stiction.live.pi import Points

        return Points(url, file)
    source = opened(url, table)
    try:
        return Table(source, file)
    except BaseException:
        source.close()
        raise


def opened(url: str, table: str | None = None) -> Source:
    """The table that an address names, such as ``postgres://reader@host/plant?table=samples``."""
    refuse_password(url, "STICTION_SQL_PASSWORD")
    parts = urlsplit(url)
    query = dict(parse_qsl(parts.query))
    table = table or query.pop("table", None)
    query.pop("table", None)
    if not table:
        raise Refused(f"{redacted(url)} names no table; add one, as in ?table=samples")
    if parts.scheme in ("postgres", "postgresql"):
        return Postgres(urlunsplit(parts._replace(query=urlencode(query))), table)
    if parts.scheme == "odbc":
        return Odbc(url.partition("?table=")[0], table)
    raise Refused(f"{parts.scheme}:// is not supported; use postgres://, odbc:// or pi://")


class Table:
    """The layout and the loops of a table of samples."""

    def __init__(self, source: Source, file: _core.Plant) -> None:
        self.source, self.file = source, file
        self.name = f"table {source.name}"
        shape = file.shape(source.columns)
        if shape is None:
            raise Refused(
                f"table {source.name}: its columns {', '.join(source.columns[:8])} include no column of times; make a view with columns such as "
                "time, tag, value and quality"
            )
        self.time = source.columns[shape[0]]
        self.modes = mode_words(file.text)
        if shape[1] is not None:
            self.tag: str | None = source.columns[shape[1][0]]
            self.value = source.columns[shape[1][1]]
            about = [source.columns[k] for k in shape[2] if source.columns[k] not in (self.time, self.tag, self.value)]
            known = {"quality", "status", "statuscode", "qualitycode", "opcquality", "qualitystatus"}
            self.quality = next((name for name in about if re.sub(r"[^a-z]", "", name.lower()) in known), None)
            names = sorted({str(tag) for [tag] in self._distinct()})
            loops = file.loops(names, [])
        else:
            self.tag = self.quality = None
            names = source.columns
            loops = file.loops(names, shape[2])
        if not loops:
            raise Refused(f"table {source.name}: no loop is recognised by {', '.join(names[:5])}; name tags in plant.toml")
        self.loops = [(name, [names[k] for k in own if names[k] != self.time]) for name, own, _ in loops]

    def _distinct(self) -> Iterator[Sequence[Any]]:
        tag = self.source.quoted(self.tag or "")
        return self.source.select([f"DISTINCT {tag}"], f"WHERE {tag} IS NOT NULL", [])

    def close(self) -> None:
        """End the connection."""
        self.source.close()

    def span(self, begin: int | None = None, end: int | None = None) -> tuple[int, int] | None:
        """The first and last time within a span; None without rows."""
        time = self.source.quoted(self.time)
        limits = [f"{time} {sign} {self.source.time(self._at(at), self.time)}" for sign, at in ((">=", begin), ("<", end)) if at is not None]
        where = f"WHERE {' AND '.join(limits)}" if limits else ""
        both = [self.source.within(f"{of}({time})", self.time) for of in ("min", "max")]
        [[first, last]] = self.source.select(both, where, [])
        return None if first is None else (self._us(first), self._us(last))

    def _us(self, at: Any) -> int:
        """A time in microseconds. A time without a zone is in the zone of the plant."""
        if not isinstance(at, datetime):
            raise Refused(f"table {self.source.name}, column {self.time}: holds {type(at).__name__}; cast it to timestamp in a view")
        if at.tzinfo is None:
            from zoneinfo import ZoneInfo

            at = at.replace(tzinfo=ZoneInfo(self.file.zone) if self.file.zone != "UTC" else timezone.utc)
        return int((at - EPOCH) // timedelta(microseconds=1))

    def _status(self, quality: Any) -> int:
        """The status code of a quality: words, codes of OPC DA (192 good), or codes of OPC UA."""
        if quality is None:
            return hours.GOOD
        if isinstance(quality, bool):
            return hours.GOOD if quality else hours.BAD
        if isinstance(quality, str):
            word = quality.strip().lower()
            for begin, status in QUALITIES.items():
                if word.startswith(begin):
                    return status
            raise Refused(f'table {self.source.name}, column {self.quality}: "{quality}" is not a known quality; use good, uncertain or bad')
        try:
            code = int(quality) & 0xFFFF_FFFF
        except (TypeError, ValueError, OverflowError):
            raise Refused(
                f'table {self.source.name}, column {self.quality}: "{str(quality)[:40]}" is not a known quality; make a view with words (good, '
                "uncertain, bad), truth values or codes"
            ) from None
        if self.quality is not None and "statuscode" in self.quality.lower().replace("_", "") or code >= 0x4000_0000:
            return code
        return {3: hours.GOOD, 1: 0x4000_0000}.get(code >> 6 & 3, hours.BAD)

    def rows(self, tags: Sequence[str], begin: int, end: int) -> Iterator[tuple[str, hours.Rows]]:
        """The rows of tags of a loop between two times."""
        source, quoted = self.source, self.source.quoted
        time = quoted(self.time)
        first, last = (source.time(self._at(at), self.time) for at in (begin, end))
        within = f"{time} >= {first} AND {time} < {last}"
        found: dict[str, list[tuple[int, float, int]]] = {tag: [] for tag in tags}
        if self.tag is not None:
            columns = [time, quoted(self.tag), quoted(self.value)] + ([quoted(self.quality)] if self.quality else [])
            marks = ", ".join([source.mark] * len(tags))
            where = f"WHERE {quoted(self.tag)} IN ({marks}) AND {within}"
            # Some databases do not distinguish the case of letters.
            spelled = {tag.lower(): tag for tag in tags} | {tag: tag for tag in tags}
            for at, tag, value, *quality in source.select(columns, where, tags):
                name = spelled.get(tag) or spelled.get(str(tag).lower())
                if name is None:
                    raise Refused(f'table {source.name}, column {self.tag}: "{tag}" came for {", ".join(tags[:3])}; make a view with one spelling')
                self._add(found[name], at, value, self._status(quality[0]) if quality else hours.GOOD)
        else:
            for at, *values in source.select([time, *map(quoted, tags)], f"WHERE {within}", []):
                for tag, value in zip(tags, values):
                    self._add(found[tag], at, value, hours.GOOD)
        for tag, own in found.items():
            if own:
                time_, value_, status_ = zip(*own)
                rows = hours.Rows(np.array(time_, np.int64), np.array(value_, np.float64), np.array(status_, np.uint32))
                yield tag, hours.joined([rows])

    def _at(self, us: int) -> datetime:
        """A time in the form of the database: with a time zone, or by the clock of the plant."""
        at = EPOCH + timedelta(microseconds=us)
        if self.file.zone != "UTC":
            from zoneinfo import ZoneInfo

            return at.astimezone(ZoneInfo(self.file.zone))
        return at

    def _add(self, rows: list[tuple[int, float, int]], at: Any, value: Any, status: int) -> None:
        if at is None:
            return
        number = math.nan if value is None else number_of(value, self.modes)
        if math.isnan(number) and status < hours.BAD:
            status = hours.NONE
        rows.append((self._us(at), number, status))


def fetch(
    url: str,
    plant: Path,
    *,
    table: str | None = None,
    since: str | None = None,
    say: Callable[[str], None] = lambda _: None,
    note: Callable[[str], None] = lambda _: None,
) -> dict[str, int]:
    """Add the rows of a table to daily files below ``data/sql`` of a plant.

    The function reads new days, and again the two days before the new days. `say` is called for each day, and `note` with
    warnings for the user.
    """
    path = plant / "plant.toml"
    try:
        file = _core.Plant(path.read_text(encoding="utf-8"), str(path))
    except OSError as error:
        raise Refused(f"{path}: {error.strerror}; write it, or have it proposed: stiction plant -C {plant} init {redacted(url)}") from None
    except ValueError as error:
        raise Refused(str(error)) from None
    from stiction.live.watch import matches

    if not any(matches(pattern, "data/sql/samples/2026-03-02.parquet") for pattern in file.data):
        raise Refused(
            f'{path}, data: does not name the fetched files, such as data/sql/samples/2026-03-02.parquet; add "data/**/*.parquet"'
        )
    stored = hours.live_folder(plant) / "fetched.json"
    key = f"{redacted(url).partition('?maxCount=')[0]} {table or ''}"
    of = samples_of(url, table, file)
    folder = fetched.folder_of(plant, of.name.removeprefix("table "))
    try:
        with hours.alone(plant, f"{folder.name}.lock", f"another fetch of {of.name} is running; wait for its end"):
            known = _known(stored).get(key)
            span = believed(of, note)
            first, last = span[0] - span[0] % DAY, span[1]
            asked = None
            if since is not None:
                try:
                    asked = int(datetime.strptime(since, "%Y-%m-%d").replace(tzinfo=timezone.utc).timestamp()) * 1_000_000
                except ValueError:
                    raise Refused(f'"{since}" is not a day, such as 2026-03-01') from None
            elif isinstance(known, int) and known <= last:
                # A clock that was ahead may have given a later day, and then all is read again.
                asked = known - AGAIN * DAY
            if asked is not None:
                # A table has nothing before its first row.
                first = max(first, asked) if isinstance(of, Table) else asked
            counts = {"days": 0, "rows": 0, "loops": len(of.loops)}
            fetched.begin(folder, [tag for _, tags in of.loops for tag in tags])
            day = first
            while day <= last:
                name = f"{hours.moment(day):%Y-%m-%d}"
                rows = fetched.add(folder / f"{name}.parquet", _rows(of, day, day + DAY), note)
                if rows:
                    counts["days"] += 1
                    counts["rows"] += rows
                    say(f"{name}: {rows} rows")
                day += DAY
                if rows == 0 and isinstance(of, Table) and day <= last:
                    # Years may be empty.
                    later = of.span(day, last + 1_000_000)
                    day = last + 1 if later is None else max(day, later[0] - later[0] % DAY)
            part = stored.with_name(f"{folder.name}.part")
            part.write_text(json.dumps(_known(stored) | {key: last - last % DAY}), encoding="utf-8")
            part.replace(stored)
            return counts
    finally:
        of.close()


def _known(stored: Path) -> dict[str, Any]:
    """The last day that was fetched from each address."""
    try:
        found = json.loads(stored.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def believed(of: Any, note: Callable[[str], None]) -> tuple[int, int]:
    """The first and the last time of the samples. Impossible times are excluded and reported."""
    span: tuple[int, int] | None = of.span()
    if span is None:
        raise Refused(f"{of.name} has no rows")
    limit = time_ns() // 1000 + AHEAD
    for stray, where in ((span[0], "before 1980") if span[0] < FIRST else (0, ""), (span[1], "in the future") if span[1] > limit else (0, "")):
        if where:
            note(f"{of.name} has rows {where}, such as of {hours.shown(stray)}, which are not read; correct their times in the database")
    if span[0] < FIRST or span[1] > limit:
        span = of.span(FIRST, limit)
        if span is None:
            raise Refused(f"{of.name} has no rows between 1980 and now; correct their times in the database, or the clock of this computer")
    return span


def _rows(of: Any, begin: int, end: int) -> Iterator[tuple[str, hours.Rows]]:
    done: set[str] = set()
    for _, tags in of.loops:
        # A tag may belong to two loops, as in a cascade.
        own = [tag for tag in tags if tag not in done]
        done.update(own)
        if own:
            yield from of.rows(own, begin, end)


def samples(url: str, path: Path, table: str | None = None, note: Callable[[str], None] = lambda _: None) -> None:
    """Write the last day of a table to a file, for a proposal."""
    of = samples_of(url, table, _core.Plant('name = "new"', "the database"))
    try:
        _, last = believed(of, note)
        hours.written(path, (hours.table_of(tag, rows) for tag, rows in _rows(of, last - DAY, last + 1_000_000)))
    finally:
        of.close()
