"""Processes of the tests of live data. Every wait has an end."""

import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
import threading
import time
from glob import glob
from pathlib import Path

HERE = Path(__file__).parent


def free_port():
    with socket.socket() as own:
        own.bind(("127.0.0.1", 0))
        return own.getsockname()[1]


BUSY = 5.0
"""How much longer than on an idle machine a test waits, at most, for what is to come."""


def wait_for(condition, seconds=30.0, what="it"):
    seconds *= BUSY
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := condition():
            return found
        time.sleep(0.05)
    raise AssertionError(f"{what} did not come within {seconds} s")


class Process:
    """A process whose lines are read as they come, and which is ended with the test."""

    program = sys.executable

    def __init__(self, *arguments, **more):
        self.process = subprocess.Popen(
            [self.program, *map(str, arguments)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more,
        )  # fmt: skip
        self.out, self.log = [], []
        self.readers = []
        for stream, lines in ((self.process.stdout, self.out), (self.process.stderr, self.log)):
            self.readers.append(threading.Thread(target=self._read, args=(stream, lines), daemon=True))
            self.readers[-1].start()

    def _read(self, stream, lines):
        for line in stream:
            lines.append(line.rstrip("\n"))

    def tell(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def answer(self, key, seconds=60.0):
        def found():
            for line in self.out:
                if line.startswith("{") and key in (answer := json.loads(line)):
                    return answer
            if self.process.poll() is not None:
                raise AssertionError("\n".join(self.log[-20:]))
            return None

        return wait_for(found, seconds, f"{key!r}")

    def says(self, text, seconds=30.0):
        def found():
            hit = next((line for line in self.log if text in line), None)
            if hit is None and self.process.poll() is not None:
                time.sleep(0.2)
                hit = next((line for line in self.log if text in line), None)
                assert hit is not None, f"it ended: {self.log[-20:]}"
            return hit

        try:
            return wait_for(found, seconds, f"{text!r}")
        except AssertionError as error:
            raise AssertionError(f"{error}: {self.log[-20:]}") from None

    def end(self, kill=False, seconds=30.0):
        if self.process.poll() is None:
            (self.process.kill if kill else self.process.terminate)()
        code = self.process.wait(seconds)
        for reader in self.readers:
            reader.join(5.0)
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            with contextlib.suppress(BrokenPipeError):
                stream.close()
        return code


def postgres_programs():
    """The folder of PostgreSQL's programs; empty if it is not installed."""
    return next(iter(sorted(glob("/usr/lib/postgresql/*/bin"), reverse=True)), None) or os.path.dirname(shutil.which("initdb") or "")


def owned(folder, name):
    """How a program is run as the owner of a folder. Databases refuse to run as root."""
    if os.geteuid() != 0:
        return []
    shutil.chown(folder, name)
    for parent in [folder, *folder.parents]:
        if parent.stat().st_uid == 0 and str(parent) != "/":
            parent.chmod(parent.stat().st_mode | 0o011)
    return ["runuser", "-u", name, "--"]


@contextlib.contextmanager
def postgres(folder):
    """A cluster of PostgreSQL of its own, on 127.0.0.1: its address."""
    programs, port, user = postgres_programs(), free_port(), owned(folder, "postgres")
    run = lambda *words: subprocess.run([*user, *map(str, words)], check=True, capture_output=True, timeout=60, cwd="/")  # noqa: E731
    data = folder / "data"
    run(f"{programs}/initdb", "-D", data, "-A", "trust", "-U", "owner", "--no-sync")
    options = f"-p {port} -c listen_addresses=127.0.0.1 -k {folder} -c fsync=off"
    run(f"{programs}/pg_ctl", "-D", data, "-w", "-l", folder / "log", "-o", options, "start")
    try:
        yield f"postgres://owner@127.0.0.1:{port}/postgres"
    finally:
        run(f"{programs}/pg_ctl", "-D", data, "-m", "immediate", "stop")


@contextlib.contextmanager
def mariadb(folder):
    """A server of MariaDB of its own, on 127.0.0.1: its port, and a function that runs orders as its owner."""
    port, user = free_port(), owned(folder, "mysql")
    data, way = folder / "data", folder / "way"
    words = ["mariadb-install-db", "--no-defaults", f"--datadir={data}", "--auth-root-authentication-method=normal", "--skip-test-db"]
    subprocess.run([*user, *words], check=True, capture_output=True, timeout=120, cwd="/")
    words = ["mariadbd", "--no-defaults", f"--datadir={data}", f"--socket={way}", "--bind-address=127.0.0.1", f"--port={port}"]
    server = subprocess.Popen([*user, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/")
    try:
        wait_for(way.exists, 60, "MariaDB")

        def run(orders):
            words = ["mariadb", "--no-defaults", "--local-infile=1", "-uroot", "-S", way]
            return subprocess.run(words, input=orders, text=True, check=True, capture_output=True, timeout=60).stdout

        yield port, run
        run("SHUTDOWN")
        server.wait(60)
    finally:
        server.kill()
        server.wait(60)
