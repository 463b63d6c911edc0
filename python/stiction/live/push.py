"""Events to a webhook, and the state of a watch as Prometheus metrics.

Each event is one POST of JSON. With a secret in the environment variable ``STICTION_WEBHOOK_SECRET``, the header
``X-Stiction-Signature`` is ``sha256=`` followed by an HMAC-SHA256. The signed text is ``TIME.BODY``, where TIME is the header
``X-Stiction-Time`` (s since 1970). An event is sent again until the receiver answers with a 2xx code. The header
``X-Stiction-Event`` is the number of the event, by which a receiver recognises a repeated event.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import hmac
import http.client
import json
import os
import random
import re
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from stiction.live import events, hours
from stiction.live.errors import Refused

__all__: list[str] = []

LONGEST_PAUSE = 300.0
"""Longest time between two attempts to send an event, s."""
LONGEST_ANSWER = 30.0
"""Time limit for the complete answer of a receiver, s."""
MOST_OPEN = 10
"""Maximum number of answers that have not ended."""


def signature(secret: str, at: str, body: bytes) -> str:
    """The signature of an event."""
    return "sha256=" + hmac.new(secret.encode(), at.encode() + b"." + body, hashlib.sha256).hexdigest()


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any, **__: Any) -> None:
        return None


class Pusher:
    """Sends the events of a plant in order, and stores the number of the last sent event."""

    def __init__(self, plant: Path, url: str | None, say: Callable[[str], None]) -> None:
        if url is not None and not _is_address(url):
            raise Refused("a webhook is an address that begins with https:// or http:// and a host, without a password")
        self.url, self.say = url, say
        self.path = events.path_of(plant)
        self.stored = hours.live_folder(plant) / "pushed.json"
        self.secret = os.environ.get("STICTION_WEBHOOK_SECRET", "")
        self._wake = asyncio.Event()
        self._open: list[threading.Thread] = []
        self.sent: int | None = None

    def wake(self) -> None:
        """Look for new events now."""
        self._wake.set()

    def _lines(self) -> list[bytes]:
        try:
            return [line for line in self.path.read_bytes().split(b"\n") if line]
        except OSError:
            return []

    def unsent(self) -> int:
        """The number of events that wait."""
        return 0 if self.url is None or self.sent is None else max(0, len(self._lines()) - self.sent)

    async def run(self) -> None:
        """Send events until the task is cancelled."""
        if self.url is None:
            return
        try:
            self.sent = int(json.loads(self.stored.read_text())["sent"])
        except (OSError, ValueError, KeyError, TypeError):
            # Events before the first use are history.
            self.sent = len(self._lines())
            self._store()
        pause, told = 1.0, ""
        while True:
            for line in self._lines()[self.sent :]:
                problem = await self._sent(line, self.sent + 1)
                if problem:
                    break
                self.sent += 1
                self._store()
            else:
                problem = ""
            if problem and problem != told:
                self.say(f"the webhook did not accept an event ({problem}); it is sent again")
            elif told and not problem:
                self.say("the webhook accepts events again")
            told, pause = problem, min(2.0 * pause, LONGEST_PAUSE) if problem else 1.0
            self._wake.clear()
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._wake.wait(), pause * random.uniform(0.8, 1.2) if problem else 60.0)

    def _store(self) -> None:
        with contextlib.suppress(OSError):
            self.stored.parent.mkdir(parents=True, exist_ok=True)
            part = self.stored.with_suffix(".part")
            part.write_text(json.dumps({"sent": self.sent}))
            part.replace(self.stored)

    async def _sent(self, body: bytes, number: int) -> str:
        """Sends an event in a thread that does not delay the end of the program, and returns the problem, if any."""
        self._open = [each for each in self._open if each.is_alive()]
        if len(self._open) >= MOST_OPEN:
            return f"{MOST_OPEN} of its answers are still incomplete"
        loop = asyncio.get_running_loop()
        done: asyncio.Future[str] = loop.create_future()

        def end(problem: str) -> None:
            if not done.done():
                done.set_result(problem)

        def send() -> None:
            try:
                problem = self._post(body, number)
            except Exception as error:
                problem = f"{type(error).__name__}: {error}"
            # The loop may have ended before.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(end, problem)

        thread = threading.Thread(target=send, daemon=True)
        self._open.append(thread)
        thread.start()
        try:
            return await asyncio.wait_for(done, LONGEST_ANSWER)
        except asyncio.TimeoutError:
            return f"its answer did not end within {LONGEST_ANSWER:.0f} s"

    def _post(self, body: bytes, number: int) -> str:
        """Sends an event, and returns the problem, if any."""
        at = str(int(time.time()))
        headers = {"Content-Type": "application/json", "X-Stiction-Time": at, "X-Stiction-Event": str(number)}
        if self.secret:
            headers["X-Stiction-Signature"] = signature(self.secret, at, body)
        request = urllib.request.Request(self.url or "", body, headers, method="POST")
        try:
            with urllib.request.build_opener(_NoRedirect).open(request, timeout=10.0):
                return ""
        except urllib.error.HTTPError as error:
            return f"it answered {error.code}"
        except http.client.HTTPException as error:
            return f"its answer is not HTTP ({type(error).__name__})"
        except (OSError, ValueError) as error:
            return str(getattr(error, "reason", error)) or type(error).__name__


def _is_address(url: str) -> bool:
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError:
        return False
    is_plain = not any(character.isspace() or ord(character) < 32 for character in url)
    return is_plain and parts.scheme in ("http", "https") and bool(parts.hostname) and parts.password is None and port != 0


GAUGES = (
    ("stiction_up", "Whether the watch is connected to the server.", lambda s: int(s["connected_since"] is not None)),
    ("stiction_tags", "Tags that are collected.", lambda s: s["tags"]),
    ("stiction_tags_bad", "Tags without a good value.", lambda s: len(s["bad_tags"])),
    ("stiction_data_age_seconds", "Age of the newest value, by the server's clock.", lambda s: _age(s)),
    ("stiction_values_per_second", "Values that arrive per second.", lambda s: s["values_per_s"]),
    ("stiction_scan_seconds", "Duration of the last judgement.", lambda s: s["scan_s"]),
    ("stiction_write_seconds", "Duration of the last write of finished hours.", lambda s: s["write_s"]),
    ("stiction_disk_full", "Whether values cannot be stored.", lambda s: int(s["disk_full"])),
    ("stiction_events_unsent", "Events that wait for the webhook.", lambda s: s["events_unsent"]),
)
COUNTERS = (
    ("stiction_values_total", "Values that were stored.", lambda s: s["values"]),
    ("stiction_connections_total", "Connections to the server.", lambda s: s["connections"]),
    ("stiction_gaps_total", "Gaps between connections.", lambda s: s["gaps"]),
    ("stiction_scans_total", "Judgements.", lambda s: s["scans"]),
    ("stiction_windows_total", "Windows that were judged.", lambda s: s["windows"]),
)


def _age(status: Mapping[str, Any]) -> float | None:
    if status["server_clock"] is None or status["newest_value"] is None:
        return None
    return float(max(0.0, status["server_clock"] - status["newest_value"]))


def metrics(status: Mapping[str, Any]) -> str:
    """The state of a watch in the text format of Prometheus."""
    lines = []
    for kind, all_ in (("gauge", GAUGES), ("counter", COUNTERS)):
        for name, meaning, of in all_:
            value = of(status)
            if value is not None:
                lines += [f"# HELP {name} {meaning}", f"# TYPE {name} {kind}", f"{name} {value}"]
    lines += ["# HELP stiction_unknown Files, loops and tags that were not read, and windows of the week that were not judged."]
    lines += ["# TYPE stiction_unknown gauge"]
    for kind, count in sorted(status.get("unknown", {}).items()):
        lines.append(f'stiction_unknown{{kind="{kind}"}} {count}')
    lines += ["# HELP stiction_loops Loops by the grade of their verdict.", "# TYPE stiction_loops gauge"]
    for word, count in sorted(status["words"].items()):
        lines.append(f'stiction_loops{{word="{word}"}} {count}')
    return "\n".join(lines) + "\n"


async def serve(address: str, text: Callable[[], str], say: Callable[[str], None]) -> asyncio.Task[None]:
    """Serve metrics at an address such as ``127.0.0.1:9464``."""
    host, _, port = address.rpartition(":")
    if not host or not re.fullmatch(r"[0-9]{1,5}", port) or int(port) > 65535:
        raise Refused(f'"{address}" is not an address for metrics, such as 127.0.0.1:9464')

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError, asyncio.TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            head = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), 5.0)
            is_it = head.startswith((b"GET /metrics ", b"GET /metrics?"))
            body = text().encode() if is_it else b"see /metrics\n"
            code = "200 OK" if is_it else "404 Not Found"
            writer.write(
                f"HTTP/1.1 {code}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"
                f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n".encode()
                + body
            )
            await asyncio.wait_for(writer.drain(), 5.0)
        writer.close()

    try:
        server = await asyncio.start_server(answer, host.strip("[]"), int(port), limit=8192)
    except (OSError, UnicodeError) as error:
        raise Refused(f"metrics cannot be served at {address}: {getattr(error, 'strerror', None) or error}") from None
    say(f"metrics at http://{address}/metrics")
    return asyncio.create_task(server.serve_forever())
