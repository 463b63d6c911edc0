"""The commands: ``python -m stiction.live watch``, ``init``, ``fetch``."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from stiction.live.errors import Refused
from stiction.live.words import counted

__all__: list[str] = []

UNITS = {"s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86_400.0, "w": 604_800.0}
PROGRESS_S = 50.0
"""Seconds between two lines of progress if the output is not a terminal."""
SIZES = {"MB": 1 << 20, "GB": 1 << 30, "TB": 1 << 40}


def duration(text: str) -> float:
    """Return the seconds of a text such as ``7d`` or ``500ms``."""
    match = re.fullmatch(r"([0-9.]+)\s*(ms|s|min|m|h|d|w)", text.strip())
    if match is None:
        raise argparse.ArgumentTypeError(f'"{text}" is not a duration, such as 30s, 2min, 1h or 7d')
    number, unit = match.groups()
    return float(number) * (0.001 if unit == "ms" else UNITS[unit])


def size(text: str) -> float:
    """Return the bytes of a text such as ``20GB``."""
    match = re.fullmatch(r"([0-9.]+)\s*(MB|GB|TB)", text.strip().upper())
    if match is None:
        raise argparse.ArgumentTypeError(f'"{text}" is not a size, such as 500MB or 20GB')
    return float(match[1]) * SIZES[match[2]]


def _secured(parser: argparse.ArgumentParser) -> None:
    own = parser.add_argument_group("security")
    own.add_argument("--security", metavar="POLICY", help="Aes256Sha256RsaPss, Aes128Sha256RsaOaep, Basic256Sha256 or none "
                     "[default: the best of the server, never none]")  # fmt: skip
    own.add_argument("--certificates", metavar="DIR", type=Path, help="the folder of certificates [default: certificates in the plant]")
    own.add_argument("--trust-first", action="store_true", help="trust the first certificate of a server without checking it")
    own.add_argument("--any-name", action="store_true", help="accept a certificate of a different host or application")
    own.add_argument("--user-certificate", metavar="FILE", type=Path, help="log in with this certificate")
    own.add_argument("--user-key", metavar="FILE", type=Path, help="the key of that certificate")


ENVIRONMENT = """\
secrets, from the environment only:
  STICTION_OPCUA_USER, STICTION_OPCUA_PASSWORD  log in with a name and a password
  STICTION_OPCUA_KEY_PASSWORD, STICTION_OPCUA_USER_KEY_PASSWORD  passwords of the encrypted keys
  STICTION_SQL_PASSWORD (or PGPASSWORD)  password for a database
  STICTION_PI_USER, STICTION_PI_PASSWORD  log in to a PI Web API
  STICTION_WEBHOOK  address to which events are sent
  STICTION_WEBHOOK_SECRET  key that signs events"""


def parser(program: str = "python -m stiction.live") -> argparse.ArgumentParser:
    """Return the parser of the arguments of all commands."""
    whole = argparse.ArgumentParser(prog=program, description="Collect live data of a plant. Servers and databases are only read.")
    tasks = whole.add_subparsers(dest="task", required=True, metavar="COMMAND")

    watch = tasks.add_parser(
        "watch",
        help="collect and judge the data of a plant day and night",
        description="Collect the values of a plant from an OPC UA server, and judge them hour by hour. The server is only read. "
        "Events are lines of JSON on standard output, and the log is on standard error.",
        epilog="examples:\n  stiction watch --make-certificate -C north\n  stiction watch opc.tcp://server:4840 -C north --history 7d\n"
        "  stiction watch --status -C north\n\n" + ENVIRONMENT + "\n\nexit codes:\n  0  stopped by a signal; with --status, "
        "connected\n  1  with --status, not running or not connected\n  2  not started; the message states the reason",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    watch.add_argument("url", nargs="?", metavar="URL", help="the server, such as opc.tcp://server:4840")
    watch.add_argument("-C", "--folder", metavar="PLANT", type=Path, default=Path(), help="the folder of the plant [default: .]")
    watch.add_argument("--history", metavar="TIME", type=duration, default=0.0, help="duration to read from the server's history "
                       "at the first start, such as 7d")  # fmt: skip
    watch.add_argument("--sample", metavar="TIME", type=duration, default=1.0, help="requested sample time [default: 1s]")
    watch.add_argument("--publish", metavar="TIME", type=duration, default=1.0, help="time between notifications [default: 1s]")
    watch.add_argument("--grace", metavar="TIME", type=duration, default=120.0, help="time from the end of an hour until the "
                       "hour is written and judged [default: 2min]")  # fmt: skip
    watch.add_argument("--queue", metavar="N", type=int, default=600, help="values of a tag that the server keeps between "
                       "notifications [default: 600]")  # fmt: skip
    watch.add_argument("--timeout", metavar="TIME", type=duration, default=10.0, help="longest wait for an answer [default: 10s]")
    watch.add_argument("--check", metavar="TIME", type=duration, default=60.0, help="time between two checks whether the server "
                       "knows all tags [default: 1min]")  # fmt: skip
    watch.add_argument("--keep", metavar="TIME", type=duration, default=400 * 86_400.0, help="remove files older than this "
                       "time [default: 400d]")  # fmt: skip
    watch.add_argument("--disk", metavar="SIZE", type=size, help="remove the oldest files beyond this size, such as 20GB")
    watch.add_argument("--time-limit", metavar="TIME", type=duration, help="longest time to judge a window; if a window takes "
                       "longer, the row of the window has an error [default: time_limit_s in plant.toml, or 5min]")  # fmt: skip
    watch.add_argument("--webhook", metavar="URL", help="address to which events are sent, or @FILE for a file with the "
                       "address [default: STICTION_WEBHOOK of the environment]")  # fmt: skip
    watch.add_argument("--metrics", metavar="ADDRESS", help="serve Prometheus metrics at this address, such as 127.0.0.1:9464")
    watch.add_argument("--status", action="store_true", help="print the state of the running watch, and end")
    watch.add_argument("--json", action="store_true", help="print the state as JSON")
    watch.add_argument("--make-certificate", action="store_true", help="make the certificate of this client, and end")
    _secured(watch)

    init = tasks.add_parser(
        "init",
        help="propose plant.toml for a server or a database",
        description="Propose plant.toml for an OPC UA server or a database. Doubts are comments in the file.",
        epilog="examples:\n  stiction plant -C north init opc.tcp://server:4840\n"
        "  stiction plant -C north init postgres://reader@host/plant?table=samples\n\n" + ENVIRONMENT,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    init.add_argument("url", metavar="URL", help="the server or the database")
    init.add_argument("-C", "--folder", metavar="PLANT", type=Path, default=Path(), help="the folder of the plant [default: .]")
    init.add_argument("--table", metavar="NAME", help="the table of a database")
    init.add_argument("--force", action="store_true", help="overwrite plant.toml")
    _secured(init)

    fetch = tasks.add_parser(
        "fetch",
        help="copy samples from a database to daily files",
        description="Copy samples from a long or wide table to daily files below data/sql of the plant, in read-only transactions. A "
        "second run reads only what is new.",
        epilog="examples:\n  python -m stiction.live fetch 'postgres://reader@host/plant?table=samples' -C north\n"
        "  stiction plant -C north scan 'postgres://reader@host/plant?table=samples'\n\n" + ENVIRONMENT,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    fetch.add_argument("url", metavar="URL", help="the database: postgres://, odbc://")
    fetch.add_argument("-C", "--folder", metavar="PLANT", type=Path, default=Path(), help="the folder of the plant [default: .]")
    fetch.add_argument("--table", metavar="NAME", help="the table, if the address names no table")
    fetch.add_argument("--since", metavar="DAY", help="first day to read, also if it was read before, such as 2026-03-01")
    fetch.add_argument("--output", metavar="FILE", type=Path, help="write the last day to this file instead, for stiction diagnose")
    return whole


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command, and return its exit code."""
    known = parser().parse_args(arguments)
    try:
        if known.task == "watch":
            return _watch(known)
        if known.task == "init":
            return _init(known)
        if known.task == "fetch":
            return _fetch(known)
    except (Refused, ImportError, OSError) as error:
        print(f"stiction: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 2


def _security(known: argparse.Namespace) -> Any:
    from stiction.live import opcua

    folder = known.certificates or known.folder / "certificates"
    return opcua.Security(known.security, folder, known.trust_first, known.user_certificate, known.user_key, known.any_name)


def _note(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


@contextlib.contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Print notes of a long run: all notes on a terminal, otherwise one per interval. Without a new note, repeat the last note.
    """
    every_s = 0.0 if sys.stderr.isatty() else PROGRESS_S
    shown, last, ended = time.monotonic(), "", threading.Event()

    def say(text: str) -> None:
        nonlocal shown, last
        last = text
        if time.monotonic() - shown >= every_s:
            shown = time.monotonic()
            _note(text)

    def repeat() -> None:
        nonlocal shown
        while not ended.wait(min(1.0, PROGRESS_S / 4)):
            if time.monotonic() - shown >= PROGRESS_S:
                shown = time.monotonic()
                _note(f"still reading, after {last}" if last else "still reading")

    threading.Thread(target=repeat, daemon=True).start()
    try:
        yield say
    finally:
        ended.set()


def _init(known: argparse.Namespace) -> int:
    from stiction.live import first

    if not known.url.startswith("opc.tcp://"):
        from stiction.live import sql

        with _progress():
            made = first.of_samples(known.folder, lambda path: sql.samples(known.url, path, known.table, _note), force=known.force)
        print(f"{counted(made[0], 'loop')}, {counted(made[1], 'doubt')}; see {known.folder / 'plant.toml'}")
        return 0
    print(asyncio.run(first.of_server(known.folder, known.url, _security(known), _note, force=known.force)))
    return 0


def _fetch(known: argparse.Namespace) -> int:
    from stiction.live import sql

    with _progress() as say:
        if known.output is not None:
            sql.samples(known.url, known.output, known.table, _note)
            return 0
        done = sql.fetch(known.url, known.folder, table=known.table, since=known.since, say=say, note=_note)
    rows, loops, days = (counted(done[f"{what}s"], what) for what in ("row", "loop", "day"))
    print(f"{rows} of {loops}, {days}; see {known.folder / 'data' / 'sql'}")
    return 0


def _watch(known: argparse.Namespace) -> int:
    if known.status:
        return _status(known.folder, known.json)
    from stiction.live import opcua
    from stiction.live.watch import Options, Watcher

    if known.make_certificate:
        folder = known.certificates or known.folder / "certificates"
        mark = opcua.make_certificate(folder)
        print(f"{folder / 'client.der'} (SHA-256 {mark}): trust this certificate on the server")
        return 0
    if not known.url:
        raise Refused("no server is given; name one, such as opc.tcp://server:4840")
    options = Options(
        url=known.url,
        plant=known.folder,
        security=_security(known),
        history_s=known.history,
        publish_s=known.publish,
        sample_s=known.sample,
        grace_s=known.grace,
        queue=known.queue,
        keep_s=known.keep,
        most_bytes=known.disk,
        time_limit_s=None if known.time_limit is None else max(1, round(known.time_limit)),
        timeout_s=known.timeout,
        check_s=known.check,
        webhook=_address(known.webhook or os.environ.get("STICTION_WEBHOOK")),
        metrics=known.metrics,
    )

    async def run() -> int:
        return await Watcher(options).run()

    return asyncio.run(run())


def _address(given: str | None) -> str | None:
    """Return the address of a webhook, which may be in a file."""
    return Path(given[1:]).read_text(encoding="utf-8").strip() if given and given.startswith("@") else given or None


def _status(plant: Path, as_json: bool) -> int:
    from stiction.live.watch import read_status, span

    status = read_status(plant)
    if status is None:
        raise Refused(f"{plant}: stiction watch has never run here")
    age = time.time() - status["written"]
    status["running"] = age < 60.0
    code = 0 if status["running"] and status["connected_since"] is not None else 1
    if as_json:
        print(json.dumps(status))
        return code

    def at(seconds: float) -> str:
        return datetime.fromtimestamp(seconds, timezone.utc).strftime("%Y-%m-%d %H:%M:%S UTC")

    if not status["running"]:
        state = f"not running since {at(status['written'])}"
    elif status["connected_since"] is None:
        state = "no connection"
    else:
        state = f"connected since {at(status['connected_since'])}"
    print(f"{status['url']}: {state}")
    bad = status["bad_tags"]
    print(f"{counted(status['tags'], 'tag')}, {len(bad)} of them bad" + (f" ({', '.join(bad[:5])})" if bad else ""))
    connections, gaps = counted(status["connections"], "connection"), counted(status["gaps"], "gap")
    print(f"{counted(status['values'], 'value')}, {status['values_per_s']} a second; {connections}, {gaps}")
    if status["newest_value"] is not None and status["server_clock"] is not None:
        age_us = int(1e6 * max(0.0, status["server_clock"] - status["newest_value"]))
        print(f"newest value: {at(status['newest_value'])}, {span(age_us)} old by the server's clock")
    if status["last_hour"]:
        print(f"last hour: {status['last_hour']}, judged in {status['scan_s']} s")
    for word, count in sorted(status["words"].items()):
        print(f"{count:7} {word}")
    for kind, count in sorted(status.get("unknown", {}).items()):
        if count:
            print(f"{count:7} {kind}")
    if status["disk_full"]:
        print("the disk is full: values are missing")
    return code


if __name__ == "__main__":
    sys.exit(main())
