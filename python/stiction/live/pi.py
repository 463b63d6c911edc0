"""Samples from a PI Web API, by ``streamsets/recorded``. This module follows the documentation and was not tested on a real
server.

The address is ``pi://HOST/piwebapi/DATA-SERVER``. Only GET is sent. The module reads the points whose names belong to loops. A
server limits the values of an answer. ``?maxCount=N`` at the end of the address requests N values at a time. A limit that the
server states is obeyed, and an answer that is shorter than requested does not count as complete.
"""

from __future__ import annotations

import base64
import http.client
import json
import os
import re
import time
import urllib.error
import urllib.request
from collections.abc import Iterator, Sequence
from datetime import datetime, timedelta, timezone
from typing import Any
from urllib.parse import parse_qsl, quote, urlencode, urlsplit

import numpy as np

from stiction import _core
from stiction.live import history, hours
from stiction.live.errors import Refused, refuse_password
from stiction.live.tags import mode_words
from stiction.live.words import number_of

__all__: list[str] = []

MOST = 10_000
"""Number of values of a point that a request asks for, unless the address states a number."""
POINTS = 1_000
"""Maximum number of points in one answer."""
ANSWER_S = 600.0
"""Time limit for an answer, s."""
MOST_BYTES = 1 << 30
"""Maximum size of an answer, bytes."""
EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
DAYS = 7
"""Days that the first fetch reads."""


def microseconds(text: str) -> int:
    """A time such as ``2026-03-02T05:00:00.1234567Z``."""
    match = re.fullmatch(r"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d)(?:\.(\d+))?Z", text)
    if match is None:
        raise Refused(f'"{text}" is not a time of a PI Web API')
    at = datetime.fromisoformat(match[1]).replace(tzinfo=timezone.utc)
    return int((at - EPOCH) // timedelta(microseconds=1)) + int((match[2] or "0").ljust(6, "0")[:6])


class _TooMany(Refused):
    """Refusal of a request by the server, perhaps because of the number of values."""


def _reason(error: urllib.error.HTTPError) -> str:
    """The server's reason, in one line."""
    try:
        text = error.read(65_536).decode(errors="replace")
    except (OSError, http.client.HTTPException):
        return ""
    try:
        found = json.loads(text)
        errors = found.get("Errors") or found.get("Message") or ""
        text = " ".join(map(str, errors)) if isinstance(errors, list) else str(errors)
    except (ValueError, AttributeError):
        text = re.sub(r"<[^>]*>", " ", text)
    return " ".join(text.split())[:300]


def _body(answer: Any) -> bytes:
    """The body of an answer. A server that sends the body too slowly, or without end, is abandoned."""
    until, body = time.monotonic() + ANSWER_S, bytearray()
    while part := answer.read1(1 << 20):
        body += part
        if time.monotonic() > until or len(body) > MOST_BYTES:
            raise OSError(f"its answer has {len(body)} bytes after {ANSWER_S:.0f} s or less, and no end")
    return bytes(body)


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any, **__: Any) -> None:
        return None


class Points:
    """The points of a data server that belong to loops."""

    def __init__(self, url: str, file: _core.Plant) -> None:
        refuse_password(url, "STICTION_PI_PASSWORD")
        parts = urlsplit(url)
        base, _, server = parts.path.strip("/").rpartition("/")
        if not (parts.hostname and base and server):
            raise Refused(f"{url} is not the address of a data server, such as pi://host/piwebapi/PISERVER")
        query = dict(parse_qsl(parts.query, keep_blank_values=True))
        count = query.pop("maxCount", str(MOST))
        if query or not re.fullmatch(r"[1-9][0-9]{0,8}", count):
            raise Refused(f"{parts.query} after {server} is not known; the number of values in an answer is given as ?maxCount=1000")
        self.most, self.points = int(count), POINTS
        # A stand-in on this machine may do without encryption.
        scheme = "http" if parts.hostname == "127.0.0.1" else "https"
        self.base, self.name = f"{scheme}://{parts.netloc.rpartition('@')[2]}/{base}", server
        self.modes = mode_words(file.text)
        user, password = os.environ.get("STICTION_PI_USER"), os.environ.get("STICTION_PI_PASSWORD", "")
        self._login = None if user is None else "Basic " + base64.b64encode(f"{user}:{password}".encode()).decode()
        self._ids: dict[str, str] = {}
        web_id = self._get("dataservers", {"path": f"\\\\{server}"}).get("WebId")
        first = 0
        while True:
            asked = {"nameFilter": "*", "startIndex": first, "maxCount": self.points, "selectedFields": "Items.WebId;Items.Name"}
            path = f"dataservers/{quote(str(web_id), safe='')}/points"
            try:
                items = self._get(path, asked).get("Items") or []
            except _TooMany as error:
                self.points = self._fewer(self.points, error)
                continue
            known = len(self._ids)
            self._ids.update((item["Name"], item["WebId"]) for item in items)
            first += len(items)
            # A page that is shorter than asked for may be a limit of the server.
            if len(self._ids) == known:
                break
        names = sorted(self._ids)
        loops = file.loops(names, [])
        if not loops:
            raise Refused(f"{server}: no loop is recognised by {', '.join(names[:5]) or 'its points'}; name tags in plant.toml")
        self.loops = [(name, [names[k] for k in own]) for name, own, _ in loops]

    def _get(self, path: str, query: Any) -> dict[str, Any]:
        url = f"{self.base}/{path}?{urlencode(query, doseq=True)}"
        request = urllib.request.Request(url, headers={"Accept": "application/json"}, method="GET")
        if self._login:
            request.add_header("Authorization", self._login)
        try:
            with urllib.request.build_opener(_NoRedirect).open(request, timeout=60.0) as answer:
                found: dict[str, Any] = json.loads(_body(answer))
        except urllib.error.HTTPError as error:
            remedy = "; give STICTION_PI_USER and STICTION_PI_PASSWORD" if error.code == 401 else ""
            reason = _reason(error) if error.code != 401 else ""
            words = f"{self.base}/{path} answered {error.code}{f': {reason}' if reason else ''}{remedy}"
            raise (_TooMany(words) if error.code in (400, 413) else Refused(words)) from None
        except (OSError, ValueError, http.client.HTTPException) as error:
            raise Refused(f"{self.base}/{path}: {getattr(error, 'reason', error)}") from None
        if not isinstance(found, dict):
            raise Refused(f"{self.base}/{path} did not answer with a JSON object; check that the address is that of a PI Web API")
        return found

    @staticmethod
    def _fewer(asked: int, error: _TooMany) -> int:
        """The number of values or points to request after a refused number: the limit that the server states, or half of the
        refused number.
        """
        about = re.search(r"(?i)max|count|exceed|limit|large|many", str(error).partition(" answered ")[2])
        if about is None or asked <= 1:
            raise Refused(f"{error}; if the number of values is too large, give a lower one at the end of the address, as in ?maxCount=1000") from None
        stated = [int(number.replace(",", "")) for number in re.findall(r"(?<![\w.])\d[\d,]*", str(error).partition(": ")[2])]
        return max((number for number in stated if 10 <= number < asked), default=asked // 2)

    def span(self, begin: int | None = None, end: int | None = None) -> tuple[int, int]:
        """The last days. The first time on the server is not requested."""
        now = int((datetime.now(timezone.utc) - EPOCH) // timedelta(microseconds=1))
        return now - DAYS * 86_400_000_000, now

    def rows(self, tags: Sequence[str], begin: int, end: int) -> Iterator[tuple[str, hours.Rows]]:
        """The rows of tags of a loop between two times."""
        found: dict[str, list[tuple[int, float, int]]] = {tag: [] for tag in tags}
        reading = history.Reading(
            range(len(tags)), begin, end, together=len(tags), time_of=lambda item: microseconds(item["Timestamp"]), key_of=repr
        )
        until = time.monotonic() + history.MOST_S
        while spans := reading.next():
            if time.monotonic() > until:
                raise Refused(f"{', '.join(tags[:3])}: a day was not read within {history.MOST_S / 60:.0f} min; samples fetched so far stay")
            streams, count = self._recorded([tags[span.index] for span in spans], *spans[0].asked)
            for span in spans:
                tag = tags[span.index]
                for part in reading.take(span, history.Answer(streams[tag]), count):
                    if isinstance(part, int):
                        continue
                    if isinstance(part, history.Unread):
                        raise Refused(
                            f"{tag}: its values from {hours.shown(part.begin)} to {hours.shown(part.end)} cannot be read to their end "
                            f"({part.why}); give a number of values at the end of the address, as in ?maxCount={10 * count}"
                        )
                    for item in part:
                        at = microseconds(item["Timestamp"])
                        if begin <= at < end:
                            found[tag].append((at, *self._value(item)))
        for tag, values in found.items():
            if values:
                times, value, status = zip(*values)
                rows = hours.Rows(np.array(times, np.int64), np.array(value, np.float64), np.array(status, np.uint32))
                yield tag, hours.joined([rows])

    def _recorded(self, tags: Sequence[str], begin: int, end: int) -> tuple[dict[str, list[Any]], int]:
        """The answer about points, by tag, and the requested number of values."""
        names = {self._ids[tag]: tag for tag in tags}
        while True:
            query = {
                "webId": list(names),
                "startTime": hours.moment(begin).isoformat().replace("+00:00", "Z"),
                "endTime": hours.moment(end).isoformat().replace("+00:00", "Z"),
                "boundaryType": "Inside",
                "maxCount": self.most,
            }
            try:
                streams = self._get("streamsets/recorded", query).get("Items") or []
            except _TooMany as error:
                self.most = self._fewer(self.most, error)
                continue
            found: dict[str, list[Any]] = {}
            for stream in streams:
                tag = names.get(stream.get("WebId"), "a point")
                if errors := stream.get("Errors"):
                    raise Refused(f"{tag}: {' '.join(map(str, errors))[:300]}")
                found[tag] = stream.get("Items") or []
            if missing := [tag for tag in tags if tag not in found]:
                raise Refused(f"{self.base}/streamsets/recorded did not answer about {', '.join(missing[:5])}; check these points on the server")
            return found, self.most

    def _value(self, item: dict[str, Any]) -> tuple[float, int]:
        """The value and the status code. A digital state has a name, and system states are no values."""
        value = item.get("Value")
        is_good = item.get("Good", True)
        if isinstance(value, dict):
            is_good = is_good and not value.get("IsSystem", False)
            number = number_of(value.get("Name"), self.modes)
            value = value.get("Value") if np.isnan(number) else number
        number = number_of(value, self.modes) if is_good else float("nan")
        if np.isnan(number):
            return number, hours.BAD
        return number, 0x4000_0000 if item.get("Questionable") else hours.GOOD

    def close(self) -> None:
        """Do nothing, because there is no connection to end."""
