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
    """Answers as the documentation of a PI Web API shows: data servers, points, recorded values of stream sets."""

    def __init__(self, data):
        self.data, self.methods, self.names = data, set(), sorted(data)
        own = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                own.methods.add(self.command)
                path, query = urlsplit(self.path).path, parse_qs(urlsplit(self.path).query)
                if self.headers.get("Authorization") != "Basic bWU6UGE1NQ==":
                    self.send_error(401)
                    return
                body = json.dumps(own.answer(path.removeprefix("/piwebapi/"), query)).encode()
                self.send_response(200)
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
            return {"WebId": "S/1", "Name": "PI1"}
        if path == "dataservers/S%2F1/points":
            first, count = int(query["startIndex"][0]), int(query["maxCount"][0])
            return {"Items": [{"Name": name, "WebId": f"P{k}"} for k, name in enumerate(self.names)][first : first + count]}
        assert path == "streamsets/recorded" and query["boundaryType"] == ["Inside"]
        begin, end = (pi.microseconds(query[key][0]) for key in ("startTime", "endTime"))
        found = []
        for web_id in query["webId"]:
            times, values = self.data[self.names[int(web_id[1:])]]
            first, last = np.searchsorted(times, [begin, end + 1])
            chosen = range(first, min(last, first + int(query["maxCount"][0])))
            items = [{"Timestamp": hours.moment(int(times[k])).strftime("%Y-%m-%dT%H:%M:%S.%f0Z"), "Value": float(values[k]), "Good": True, "Questionable": False} for k in chosen]
            found.append({"WebId": web_id, "Items": items})
        return {"Items": found}


@pytest.fixture
def server(plant, monkeypatch):
    own = StandIn(played(plant, 2))
    monkeypatch.setenv("STICTION_PI_USER", "me")
    monkeypatch.setenv("STICTION_PI_PASSWORD", "Pa55")
    yield own
    own.server.shutdown()
    own.server.server_close()


def test_recorded_values_are_fetched_in_pages(server, plant, tmp_path, monkeypatch):
    monkeypatch.setattr(pi, "MOST", 500)
    monkeypatch.setattr(pi, "POINTS", 4)
    times = [int(at) for own, _ in server.data.values() for at in own]
    monkeypatch.setattr(pi.Points, "span", lambda _: (min(times), max(times)))
    (tmp_path / "plant.toml").write_text('name = "N"\ndata = ["data/**/*.parquet"]\n')
    done = stiction.live.fetch(tmp_path, server.url)
    found = {}
    for path in sorted((tmp_path / "data/sql").glob("*.parquet")):
        for tag, rows in hours.tables_by_tag(path):
            found.setdefault(tag, []).extend(zip(rows.time.tolist(), rows.value.tolist()))
    assert found == {tag: list(zip(own.tolist(), values.tolist())) for tag, (own, values) in server.data.items()}
    assert done["loops"] == 2 and server.methods == {"GET"}


def test_faults_are_named_with_the_remedy(server, monkeypatch):
    file = _core.Plant('name = "N"', "test")
    with pytest.raises(Refused, match="STICTION_PI_PASSWORD"):
        sql.samples_of(server.url.replace("pi://", "pi://me:Pa55@"), None, file)
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
