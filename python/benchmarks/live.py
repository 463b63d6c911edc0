"""Measures the collector of live data, on a server that plays a demo plant on 127.0.0.1.

    python python/benchmarks/live.py soak --loops 50 --minutes 120
    python python/benchmarks/live.py cpu --loops 1000 --minutes 2
    python python/benchmarks/live.py flood --rate 10000 --seconds 30

`soak` plays at a hundred times the speed, and prints the memory of the collector every minute. It fails if the memory grew by more
than 5 % after the first quarter. It also fails if a service was requested that is not listed, or if a value is missing or wrong.
`cpu` writes a value per second to each tag of 1,000 loops. `flood` writes values at any rate.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "live"))

import stiction.plant
from processes import Process, free_port
from server import played
from stiction.live import hours, opcua

SERVER = Path(__file__).resolve().parents[1] / "tests" / "live" / "server.py"


def memory(pid: int) -> float:
    """Memory of a process, MB."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0.0


def cpu(pid: int) -> float:
    """CPU time of a process, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def begun(folder: Path, loops: int, days: int, *arguments: object) -> tuple[Process, Process, Path]:
    plant, watched = folder / "played", folder / "watched"
    stiction.plant.demo(plant, loops=loops, days=days)
    watched.mkdir()
    (watched / "plant.toml").write_text((plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
    port = free_port()
    server = Process(SERVER, "--plant", plant, "--port", port, *arguments)
    print(server.answer("listening", 600), flush=True)
    url = f"opc.tcp://127.0.0.1:{port}"
    watch = Process(
        "-m", "stiction.live", "watch", url, "-C", watched, "--security", "none", "--publish", "500ms", "--sample", "0s", "--queue", "10000"
    )
    watch.says("connected to", 120)
    return server, watch, watched


def soak(folder: Path, loops: int, minutes: float) -> int:
    days = 2 + int(minutes * 100 / 1440)
    server, watch, watched = begun(folder, loops, days, "--speed", 100)
    server.tell("play")
    end, series = time.monotonic() + 60 * minutes, []
    while time.monotonic() < end and watch.process.poll() is None:
        time.sleep(min(60.0, max(1.0, end - time.monotonic())))
        state = json.loads((watched / ".stiction/live/status.json").read_text())
        series.append(memory(watch.process.pid))
        print(
            f"{len(series)} min: {series[-1]:.1f} MB, {cpu(watch.process.pid):.0f} s of CPU, {state['values']} values, last hour "
            f"{state['last_hour']}, scan {state['scan_s']} s",
            flush=True,
        )
    server.tell("requests")
    asked = server.answer("requests")["requests"]
    print(json.dumps(asked))
    code = watch.end()
    server.end(kill=True)
    quarter = series[len(series) // 4 :]
    growth = 100 * (max(quarter) / quarter[0] - 1)
    wrong = missing = count = 0
    data = played(folder / "played", None)
    for path in sorted((watched / "data").glob("*/*.parquet")):
        begin = hours._journal_hour(Path(f"{path.parent.name}T{path.stem}.0.values"))
        for tag, rows in hours.tables_by_tag(path):
            times, values = data[tag]
            own = (times >= begin) & (times < begin + hours.HOUR)
            known = set(zip(times[own].tolist(), values[own].tolist()))
            found = {(t, v) for t, v, s in zip(rows.time.tolist(), rows.value.tolist(), rows.status.tolist()) if s == 0}
            wrong, missing, count = wrong + len(found - known), missing + len(known - found), count + len(found)
    services = {kind.__name__ for kind in opcua.SERVICES}
    print(f"{count} values, {missing} missing, {wrong} wrong; memory grew by {growth:.1f} % after the first quarter; exit code {code}")
    print(f"services that are not listed: {sorted(set(asked) - services) or 'none'}")
    return int(bool(wrong or missing or set(asked) - services or growth > 5 or code))


def flood(folder: Path, rate: int, seconds: float) -> int:
    server, watch, watched = begun(folder, 20, 1, "--speed", 1)
    before = cpu(watch.process.pid)
    server.tell(f"flood {rate} {seconds}")
    sent = server.answer("flooded", 20 * seconds + 60)
    time.sleep(3)
    state = json.loads((watched / ".stiction/live/status.json").read_text())
    used = cpu(watch.process.pid) - before
    print(f"{sent['flooded']} values in {sent['seconds']} s: {state['values']} stored, {used:.1f} s of CPU, {memory(watch.process.pid):.0f} MB")
    watch.end()
    server.end(kill=True)
    return int(state["values"] < sent["flooded"])


def load(folder: Path, loops: int, minutes: float) -> int:
    server, watch, watched = begun(folder, loops, 1, "--speed", 0.001, "--last", 60)
    tags = server.answer("listening")["tags"]
    before, begin = cpu(watch.process.pid), time.monotonic()
    server.tell(f"flood {tags} {60 * minutes}")
    sent = server.answer("flooded", 60 * minutes * 3 + 60)
    passed = time.monotonic() - begin
    used = cpu(watch.process.pid) - before
    print(f"{loops} loops, {tags} tags at 1 s: {100 * used / passed:.0f} % of a core, {memory(watch.process.pid):.0f} MB, {sent}")
    watch.end()
    server.end(kill=True)
    return 0


def main() -> int:
    whole = argparse.ArgumentParser()
    whole.add_argument("what", choices=["soak", "cpu", "flood"])
    whole.add_argument("--loops", type=int, default=50)
    whole.add_argument("--minutes", type=float, default=120)
    whole.add_argument("--rate", type=int, default=10_000)
    whole.add_argument("--seconds", type=float, default=30)
    known = whole.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="stiction-live-"))
    try:
        if known.what == "soak":
            return soak(folder, known.loops, known.minutes)
        if known.what == "flood":
            return flood(folder, known.rate, known.seconds)
        return load(folder, known.loops, known.minutes)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
