"""Samples from a PI Web API: ``streamsets/recorded``, written from its documentation and not tried on a real server.

The address is ``pi://HOST/piwebapi/DATA-SERVER``. Only GET is sent. Points are those whose names belong to loops.
"""

from __future__ import annotations

import base64
import json
import os
import re
import urllib.error
import urllib.request
from collections.abc import Iterator, Sequence
from datetime import datetime, timedelta, timezone
from typing import Any
from urllib.parse import quote, urlencode, urlsplit

import numpy as np

from stiction import _core
from stiction.live import hours
from stiction.live.errors import Refused
from stiction.live.tags import mode_words
from stiction.live.words import number_of

__all__: list[str] = []

MOST = 10_000
"""Values of a point in one answer."""
POINTS = 1_000
"""Points in one answer."""
EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
DAYS = 7
"""Days that are read at first."""


def microseconds(text: str) -> int:
    """A time such as ``2026-03-02T05:00:00.1234567Z``."""
    match = re.fullmatch(r"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d)(?:\.(\d+))?Z", text)
    if match is None:
        raise Refused(f'"{text}" is no time of a PI Web API')
    at = datetime.strptime(match[1], "%Y-%m-%dT%H:%M:%S").replace(tzinfo=timezone.utc)
    return int((at - EPOCH) // timedelta(microseconds=1)) + int((match[2] or "0").ljust(6, "0")[:6])


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any, **__: Any) -> None:
        return None


class Points:
    """The points of a data server that belong to loops."""

    def __init__(self, url: str, file: _core.Plant) -> None:
        parts = urlsplit(url)
        if parts.password is not None:
            raise Refused("the address holds a password; give it in the environment as STICTION_PI_PASSWORD")
        base, _, server = parts.path.strip("/").rpartition("/")
        if not (parts.hostname and base and server):
            raise Refused(f"{url} is not the address of a data server, such as pi://host/piwebapi/PISERVER")
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
            asked = {"nameFilter": "*", "startIndex": first, "maxCount": POINTS, "selectedFields": "Items.WebId;Items.Name"}
            items = self._get(f"dataservers/{quote(str(web_id), safe='')}/points", asked).get("Items") or []
            self._ids.update((item["Name"], item["WebId"]) for item in items)
            first += len(items)
            if len(items) < POINTS:
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
                found: dict[str, Any] = json.load(answer)
        except urllib.error.HTTPError as error:
            remedy = "; give STICTION_PI_USER and STICTION_PI_PASSWORD" if error.code == 401 else ""
            raise Refused(f"{self.base}/{path} answered {error.code}{remedy}") from None
        except (OSError, ValueError) as error:
            raise Refused(f"{self.base}/{path}: {getattr(error, 'reason', error)}") from None
        return found

    def span(self) -> tuple[int, int]:
        """The last days."""
        now = int((datetime.now(timezone.utc) - EPOCH) // timedelta(microseconds=1))
        return now - DAYS * 86_400_000_000, now

    def rows(self, tags: Sequence[str], begin: int, end: int) -> Iterator[tuple[str, hours.Rows]]:
        """The rows of tags of a loop from one time up to another."""
        found: dict[str, list[tuple[int, float, int]]] = {tag: [] for tag in tags}
        open_ = {tag: begin for tag in tags}
        names = {self._ids[tag]: tag for tag in tags}
        while open_:
            start = min(open_.values())
            together = [tag for tag, at in open_.items() if at == start]
            query = {
                "webId": [self._ids[tag] for tag in together],
                "startTime": hours.moment(start).isoformat().replace("+00:00", "Z"),
                "endTime": hours.moment(end).isoformat().replace("+00:00", "Z"),
                "boundaryType": "Inside",
                "maxCount": MOST,
            }
            for stream in self._get("streamsets/recorded", query).get("Items") or []:
                tag, items = names[stream["WebId"]], stream.get("Items") or []
                own = found[tag]
                for item in items:
                    at = microseconds(item["Timestamp"])
                    if at < end:
                        own.append((at, *self._value(item)))
                last = microseconds(items[-1]["Timestamp"]) if items else end
                if len(items) >= MOST and last > open_[tag]:
                    open_[tag] = last
                else:
                    open_.pop(tag, None)
            for tag in together:
                if open_.get(tag) == start:
                    del open_[tag]
        for tag, values in found.items():
            if values:
                time, value, status = zip(*values)
                rows = hours.Rows(np.array(time, np.int64), np.array(value, np.float64), np.array(status, np.uint32))
                yield tag, hours.joined([rows])

    def _value(self, item: dict[str, Any]) -> tuple[float, int]:
        """The value and the status code. A digital state has a name, and those of the system are no values."""
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
        """There is no connection to end."""
