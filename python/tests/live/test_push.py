"""Events reach a webhook, signed, in order and each once. Metrics are in the format of Prometheus."""

import asyncio
import hmac
import http.server
import json
import re
import socketserver
import threading
import time

import pytest
from stiction.live import __main__, events, push
from stiction.live.__main__ import _address, main
from stiction.live.errors import Refused

SECRET = "a secret of the test"


def signed(at, body):
    """The signature, as docs/live.md describes it."""
    return "sha256=" + hmac.digest(SECRET.encode(), f"{at}.".encode() + body, "sha256").hex()


class Receiver:
    """Takes events, as a user's program would: it checks the signature."""

    def __init__(self):
        self.taken, self.refused, self.failing = [], 0, 0
        receiver = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                if receiver.failing > 0:
                    receiver.failing -= 1
                    code = 503
                elif self.headers["X-Stiction-Signature"] != signed(self.headers["X-Stiction-Time"], body):
                    receiver.refused += 1
                    code = 403
                else:
                    receiver.taken.append((int(self.headers["X-Stiction-Event"]), json.loads(body)["loop"]))
                    code = 204
                self.send_response(code)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_port}/events"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()


@pytest.fixture
def receiver():
    own = Receiver()
    yield own
    own.server.shutdown()
    own.server.server_close()


def happened(plant, *loops):
    (plant / ".stiction/live").mkdir(parents=True, exist_ok=True)
    events.keep(plant, [{"event": "new sticking", "loop": loop} for loop in loops], {})


def pushed(plant, url, until, said, seconds=10.0):
    """Sends until a condition holds."""

    async def send():
        pusher = push.Pusher(plant, url, said.append)
        task = asyncio.create_task(pusher.run())
        end = asyncio.get_running_loop().time() + seconds
        while not until(pusher) and asyncio.get_running_loop().time() < end:
            await asyncio.sleep(0.02)
            pusher.wake()
        task.cancel()
        assert until(pusher)

    asyncio.run(send())


def test_events_arrive_signed_in_order_and_once(tmp_path, receiver, monkeypatch):
    monkeypatch.setenv("STICTION_WEBHOOK_SECRET", SECRET)
    said = []
    happened(tmp_path, "BEFORE")
    pushed(tmp_path, receiver.url, lambda pusher: pusher.sent == 1, said)
    assert receiver.taken == [], "events before the first use are history"
    happened(tmp_path, "A", "B")
    receiver.failing = 2
    pushed(tmp_path, receiver.url, lambda pusher: pusher.sent == 3, said)
    happened(tmp_path, "C")
    pushed(tmp_path, receiver.url, lambda pusher: pusher.sent == 4, said)
    assert receiver.taken == [(2, "A"), (3, "B"), (4, "C")] and receiver.refused == 0
    assert "it answered 503" in said[0] and "accepts events again" in said[1] and SECRET not in "".join(said)


def test_a_wrong_secret_is_refused_by_the_receiver(tmp_path, receiver, monkeypatch):
    monkeypatch.setenv("STICTION_WEBHOOK_SECRET", "another")
    (tmp_path / ".stiction/live").mkdir(parents=True)
    (tmp_path / ".stiction/live/pushed.json").write_text('{"sent": 0}')
    happened(tmp_path, "A")
    said = []
    pushed(tmp_path, receiver.url, lambda pusher: receiver.refused > 0 and bool(said), said)
    assert receiver.taken == [] and "it answered 403" in said[0]


def test_wrong_addresses_are_refused(tmp_path):
    wrong = ["ftp://host/", "https://me:secret@host/", "http://", "http://127.0.0.1:99999/", "http://[::1", "http://host/\r\nX: y", "http://ho st/"]
    for url in wrong:
        with pytest.raises(Refused) as refused:
            push.Pusher(tmp_path, url, print)
        assert "secret" not in str(refused.value)
    with pytest.raises(Refused, match="not an address for metrics"):
        asyncio.run(push.serve("9464", str, print))
    with pytest.raises(Refused, match="not an address for metrics"):
        asyncio.run(push.serve("127.0.0.1:99999", str, print))


ANSWERS = {
    "no HTTP": b"HELLO WORLD\r\n\r\n",
    "no number": b"HTTP/1.1 abc OK\r\n\r\n",
    "a long line": b"HTTP/1.1 200 " + b"x" * 100_000 + b"\r\n\r\n",
    "many headers": b"HTTP/1.1 200 OK\r\n" + b"X: y\r\n" * 300 + b"\r\n",
    "TLS": bytes([21, 3, 1, 0, 2, 2, 40]),
    "nothing": b"",
}


class Raw:
    """Answers with given bytes, or never, and counts the requests."""

    def __init__(self, answer):
        self.answer, self.requests = answer, 0
        own = self

        class Handler(socketserver.BaseRequestHandler):
            def handle(self):
                self.request.recv(65536)
                own.requests += 1
                if own.answer is None:
                    for _ in range(200):
                        try:
                            self.request.sendall(b"H")
                        except OSError:
                            return
                        time.sleep(0.1)
                else:
                    self.request.sendall(own.answer)

        self.server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}/"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()


def waiting(plant):
    (plant / ".stiction/live").mkdir(parents=True)
    (plant / ".stiction/live/pushed.json").write_text('{"sent": 0}')
    happened(plant, "A")


@pytest.mark.parametrize("answer", ANSWERS.values(), ids=ANSWERS.keys())
def test_a_malformed_answer_costs_a_retry_and_not_the_sending(tmp_path, answer, receiver, monkeypatch):
    monkeypatch.setenv("STICTION_WEBHOOK_SECRET", SECRET)
    monkeypatch.setattr(push, "LONGEST_PAUSE", 0.05)
    waiting(tmp_path)
    raw, said = Raw(answer), []
    try:
        pushed(tmp_path, raw.url, lambda _: raw.requests >= 3, said)
    finally:
        raw.server.shutdown()
        raw.server.server_close()
    assert "the webhook did not accept an event" in said[0]
    pushed(tmp_path, receiver.url, lambda pusher: pusher.sent == 1, said)
    assert receiver.taken == [(1, "A")]


def test_a_dripping_answer_ends_and_holds_up_no_end(tmp_path, monkeypatch):
    monkeypatch.setattr(push, "LONGEST_ANSWER", 0.3)
    monkeypatch.setattr(push, "LONGEST_PAUSE", 0.05)
    monkeypatch.setattr(push, "MOST_OPEN", 3)
    waiting(tmp_path)
    raw, said = Raw(None), []
    try:
        begun = time.monotonic()
        pushed(tmp_path, raw.url, lambda _: raw.requests >= 3, said)
        # The loop has ended here, although threads still wait for the receiver.
        assert time.monotonic() - begun < 9.0 and raw.requests == 3
    finally:
        raw.server.shutdown()
        raw.server.server_close()
    assert "did not end within" in said[0]


STATUS = {
    "connected_since": 1.0, "tags": 8, "bad_tags": ["A.PV"], "server_clock": 100.0, "newest_value": 98.5, "values_per_s": 2.5,
    "scan_s": None, "write_s": 0.1, "disk_full": False, "events_unsent": 3, "values": 7, "connections": 1, "gaps": 0, "scans": 0,
    "windows": 0, "words": {"sticks": 2, "not judged": 1}, "unknown": {"file not read": 8},
}  # fmt: skip


def test_metrics_have_the_format_of_prometheus():
    lines = push.metrics(STATUS).splitlines()
    sample = re.compile(r'[a-z_]+(\{(word|kind)="[a-z ]+"\})? [0-9.]+')
    assert all(line.startswith("# ") or sample.fullmatch(line) for line in lines)
    assert {'stiction_loops{word="sticks"} 2', "stiction_data_age_seconds 1.5", "stiction_up 1", "stiction_values_total 7"} <= set(lines)
    assert 'stiction_unknown{kind="file not read"} 8' in lines
    assert not any("scan_seconds" in line for line in lines), "what is not known is left out"


def test_metrics_are_served_and_nothing_else():
    async def whole():
        import socket

        with socket.socket() as own:
            own.bind(("127.0.0.1", 0))
            port = own.getsockname()[1]
        task = await push.serve(f"127.0.0.1:{port}", lambda: push.metrics(STATUS), lambda _: None)
        answers = []
        for request in (b"GET /metrics HTTP/1.1\r\n\r\n", b"GET /etc/passwd HTTP/1.1\r\n\r\n", b"POST /metrics HTTP/1.1\r\n\r\n"):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(request)
            answers.append(await asyncio.wait_for(reader.read(), 5))
            writer.close()
        task.cancel()
        return answers

    good, *others = asyncio.run(whole())
    assert good.startswith(b"HTTP/1.1 200") and b"stiction_up 1" in good
    assert all(answer.startswith(b"HTTP/1.1 404") for answer in others)


def test_the_address_may_come_from_a_file(tmp_path):
    (tmp_path / "address").write_text("https://host/secret\n")
    assert [_address(given) for given in (None, "", "https://host/", f"@{tmp_path / 'address'}")] == [None, None, "https://host/", "https://host/secret"]
    assert main(["watch", "opc.tcp://host", "-C", str(tmp_path), "--webhook", f"@{tmp_path / 'none'}"]) == 2


def test_a_long_run_says_so_once_in_a_while(monkeypatch, capsys):
    monkeypatch.setattr(__main__, "PROGRESS_S", 0.05)
    with __main__._progress() as say:
        say("2026-03-02: 7 rows")
        while "still reading, after 2026-03-02: 7 rows" not in capsys.readouterr().err:
            time.sleep(0.01)
