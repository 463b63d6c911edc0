"""Samples from a PI Web API, for which a server stands that was written from its documentation."""

import http.server
import json
import threading
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
import stiction.live
from server import played
from stiction import _core
from stiction.live import hours, pi, sql
from stiction.live.errors import Refused


class StandIn:
    """Answers as the documentation of a PI Web API shows: data servers, points, recorded values of stream sets.

    A cap on the values of an answer cuts silently, or refuses with a reason.
    """

    def __init__(self, data):
        self.data, self.methods, self.names = data, set(), sorted(data)
        self.cap, self.reason, self.page, self.counts = 1 << 40, None, 1 << 40, []
        own = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                own.methods.add(self.command)
                path, query = urlsplit(self.path).path, parse_qs(urlsplit(self.path).query)
                if self.headers.get("Authorization") != "Basic bWU6UGE1NQ==":
                    self.send_error(401)
                    return
                code, found = own.answer(path.removeprefix("/piwebapi/"), query)
                body = found.encode() if isinstance(found, str) else json.dumps(found).encode()
                self.send_response(code)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"pi://127.0.0.1:{self.server.server_port}/piwebapi/PI1"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def answer(self, path, query):
        if path == "dataservers":
            assert query["path"] == ["\\\\PI1"]
            return 200, {"WebId": "S/1", "Name": "PI1"}
        if path == "dataservers/S%2F1/points":
            first, count = int(query["startIndex"][0]), int(query["maxCount"][0])
            count = min(count, self.page)
            return 200, {"Items": [{"Name": name, "WebId": f"P{k}"} for k, name in enumerate(self.names)][first : first + count]}
        assert path == "streamsets/recorded" and query["boundaryType"] == ["Inside"]
        count = int(query["maxCount"][0])
        self.counts.append(count)
        if count > self.cap and self.reason is not None:
            return 400, self.reason
        count = min(count, self.cap)
        begin, end = (pi.microseconds(query[key][0]) for key in ("startTime", "endTime"))
        found = []
        for web_id in query["webId"]:
            times, values = self.data[self.names[int(web_id[1:])]]
            first, last = np.searchsorted(times, [begin, end + 1])
            chosen = range(first, min(last, first + count))
            items = [{"Timestamp": hours.moment(int(times[k])).strftime("%Y-%m-%dT%H:%M:%S.%f0Z"), "Value": float(values[k]), "Good": True, "Questionable": False} for k in chosen]
            found.append({"WebId": web_id, "Items": items})
        return 200, {"Items": found}


@pytest.fixture
def server(plant, monkeypatch):
    own = StandIn(played(plant, 2))
    monkeypatch.setenv("STICTION_PI_USER", "me")
    monkeypatch.setenv("STICTION_PI_PASSWORD", "Pa55")
    yield own
    own.server.shutdown()
    own.server.server_close()


def stored(folder):
    found = {}
    for path in sorted((folder / "data/sql").rglob("*.parquet")):
        for tag, rows in hours.tables_by_tag(path):
            found.setdefault(tag, []).extend(zip(rows.time.tolist(), rows.value.tolist()))
    return found


REASON = "The parameter 'maxCount' has an invalid value: it exceeds the maximum allowed {}."


@pytest.mark.parametrize("cap", [1000, 37])
@pytest.mark.parametrize(
    "reason",
    [
        None,
        lambda cap: {"Errors": [REASON.format(cap)]},
        lambda cap: {"Message": f"Too many values: the limit is {cap:,}"},
        lambda _: {"Errors": ["The maximum number of items was exceeded."]},
        lambda _: "<html><body>maxCount is too <b>large</b></body></html>",
    ],
    ids=["silent", "stated", "message", "without a number", "no JSON"],
)
def test_a_cap_of_the_server_costs_no_value(server, tmp_path, monkeypatch, cap, reason):
    begin = 1_772_409_600_000_000
    names = ("FIC101.OP", "FIC101.PV", "FIC101.SP")
    # Several values of one time lie where a page ends.
    times = begin + np.arange(5_000 if cap == 1000 else 500) * 1_000_000
    times[cap - 2 : cap + 2] = times[cap]
    server.data = {name: (times, 50.0 + np.arange(len(times)) % 977) for name in names}
    server.names, server.cap, server.reason, server.page = sorted(names), cap, reason and reason(cap), 2
    monkeypatch.setattr(pi.Points, "span", lambda _: (begin, int(times[-1])))
    (tmp_path / "plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    stiction.live.fetch(tmp_path, server.url)
    assert stored(tmp_path) == {tag: list(zip(own.tolist(), values.tolist())) for tag, (own, values) in server.data.items()}
    if reason is not None:
        assert server.counts[0] == pi.MOST and server.counts[-1] <= cap


def test_the_number_of_values_is_an_option_and_a_reason_is_shown(server, tmp_path, monkeypatch):
    times = [int(at) for own, _ in server.data.values() for at in own]
    monkeypatch.setattr(pi.Points, "span", lambda _: (min(times), max(times)))
    (tmp_path / "plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    server.cap, server.reason = 200, {"Errors": ["too many of them"]}
    stiction.live.fetch(tmp_path, f"{server.url}?maxCount=150")
    assert set(server.counts) == {150}
    server.cap, server.reason = 0, {"Errors": ["The archive is offline."]}
    with pytest.raises(Refused, match="streamsets/recorded answered 400: The archive is offline"):
        stiction.live.fetch(tmp_path, server.url)
    server.reason = {"Errors": ["maxCount is beyond its limit."]}
    with pytest.raises(Refused, match=r"maxCount is beyond its limit\.; .*\?maxCount=1000"):
        stiction.live.fetch(tmp_path, server.url)
    for end in ("?maxCount=0", "?maxCount=many", "?count=7"):
        with pytest.raises(Refused, match=r"is given as \?maxCount=1000"):
            stiction.live.fetch(tmp_path, server.url + end)


def test_a_point_without_an_answer_is_named(server, monkeypatch):
    file = _core.Plant('name = "N"', "test")
    points = sql.samples_of(server.url, None, file)
    tags = points.loops[0][1]
    for streams, words in [
        ([{"WebId": points._ids[tags[0]], "Items": []}], f"did not answer about {tags[1]}"),
        ([{"WebId": points._ids[tags[0]], "Errors": ["The point is not archived."]}], f"{tags[0]}: The point is not archived"),
    ]:
        monkeypatch.setattr(pi.Points, "_get", lambda *_, streams=streams: {"Items": streams})
        with pytest.raises(Refused, match=words):
            list(points.rows(tags, 0, 1_000_000))


def test_recorded_values_are_fetched_in_pages(server, plant, tmp_path, monkeypatch):
    monkeypatch.setattr(pi, "MOST", 500)
    monkeypatch.setattr(pi, "POINTS", 4)
    times = [int(at) for own, _ in server.data.values() for at in own]
    monkeypatch.setattr(pi.Points, "span", lambda _: (min(times), max(times)))
    (tmp_path / "plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    done = stiction.live.fetch(tmp_path, server.url)
    assert stored(tmp_path) == {tag: list(zip(own.tolist(), values.tolist())) for tag, (own, values) in server.data.items()}
    assert done["loops"] == 2 and server.methods == {"GET"}


def test_days_of_a_long_pause_are_fetched_however_long_it_was(server, tmp_path, monkeypatch):
    begin, day, asked = 1_772_409_600_000_000, sql.DAY, []
    (tmp_path / "plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    rows = pi.Points.rows
    monkeypatch.setattr(pi.Points, "rows", lambda own, tags, first, end: asked.append((first - begin) // day) or rows(own, tags, first, end))
    for now in (0, 20):
        monkeypatch.setattr(pi.Points, "span", lambda _, now=now: (begin + (now - 7) * day, begin + now * day))
        asked.clear()
        stiction.live.fetch(tmp_path, server.url)
    assert sorted(set(asked)) == list(range(-2, 21))


def test_an_answer_that_drips_or_does_not_end_is_not_waited_for(monkeypatch):
    class Dripping:
        def read1(self, _):
            return b"x" * 1000

    monkeypatch.setattr(pi, "ANSWER_S", 0.05)
    with pytest.raises(OSError, match="and no end"):
        pi._body(Dripping())
    monkeypatch.setattr(pi, "ANSWER_S", 600.0)
    monkeypatch.setattr(pi, "MOST_BYTES", 5000)
    with pytest.raises(OSError, match="and no end"):
        pi._body(Dripping())


def test_faults_are_named_with_the_remedy(server, monkeypatch):
    file = _core.Plant('name = "N"', "test")
    for secret in ("Pa55", "a/Pa55"):
        with pytest.raises(Refused, match="STICTION_PI_PASSWORD") as refused:
            sql.samples_of(server.url.replace("pi://", f"pi://me:{secret}@"), None, file)
        assert "Pa55" not in str(refused.value)
    with pytest.raises(Refused, match="is not the address of a data server"):
        sql.samples_of("pi://127.0.0.1", None, file)
    monkeypatch.delenv("STICTION_PI_USER")
    with pytest.raises(Refused, match="answered 401; give STICTION_PI_USER"):
        sql.samples_of(server.url, None, file)


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        ({"Value": 1.5, "Good": True}, (1.5, 0)),
        ({"Value": 1.5, "Good": True, "Questionable": True}, (1.5, 0x4000_0000)),
        ({"Value": {"Name": "Auto", "Value": 7, "IsSystem": False}, "Good": True}, (1.0, 0)),
        ({"Value": {"Name": "Running", "Value": 7, "IsSystem": False}, "Good": True}, (7.0, 0)),
        ({"Value": {"Name": "I/O Timeout", "Value": 246, "IsSystem": True}, "Good": True}, (None, hours.BAD)),
        ({"Value": 1.5, "Good": False}, (None, hours.BAD)),
    ],
)
def test_values_and_digital_states(item, expected):
    points = pi.Points.__new__(pi.Points)
    points.modes = {}
    value, status = points._value(item)
    assert (None if np.isnan(value) else value, status) == expected
