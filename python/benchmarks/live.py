"""Measures the collector of live data, on a server that plays a demo plant on 127.0.0.1.

    python python/benchmarks/live.py soak --loops 50 --minutes 120
    python python/benchmarks/live.py faults --loops 30 --minutes 120
    python python/benchmarks/live.py cpu --loops 1000 --minutes 2
    python python/benchmarks/live.py play --loops 200 --speed 100 --minutes 120
    python python/benchmarks/live.py sql --loops 200 --days 7

`soak` plays at a hundred times the speed, and prints the memory of the collector every minute. The command fails if the memory grew
by more than 5 % after the first quarter. The command also fails if a service was requested that is not listed, or if a value is
missing or wrong. `cpu` writes a value per second to each tag of 1,000 loops. `play` has the server of node-opcua, which is faster,
play minutes of loops with four tags at any speed. The command compares all values with the played values, and all windows with the
windows of `plant scan`. `sql` fetches a plant from a table of PostgreSQL, and compares every time and value of all days with the
plant.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psycopg
import pyarrow as pa
import pyarrow.parquet as pq
from pyarrow import csv

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "live"))

import stiction.plant
from processes import Process, free_port, postgres, wait_for
from server import played
from stiction.live import hours, opcua
from trial import judged_otherwise, node_modules, node_server, of_plant, unequal

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


def begun(folder: Path, loops: int, days: int, *arguments: object) -> tuple[Process, list[object], Process, Path]:
    plant, watched = folder / "played", folder / "watched"
    stiction.plant.demo(plant, loops=loops, days=days)
    watched.mkdir()
    (watched / "plant.toml").write_text((plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
    port = free_port()
    server = Process(SERVER, "--plant", plant, "--port", port, *arguments)
    print(server.answer("listening", 600), flush=True)
    words = ["-m", "stiction.live", "watch", f"opc.tcp://127.0.0.1:{port}", "-C", watched, "--security", "none", "--publish", "500ms"]
    words += ["--sample", "0s", "--queue", "10000"]
    watch = Process(*words)
    watch.says("connected to", 120)
    return server, words, watch, watched


def disturb(minute: int, server: Process, words: list[object], watch: Process) -> Process:
    """What happens in this minute of ten, and the collector that runs afterwards."""
    match minute % 10:
        case 2:
            server.process.send_signal(signal.SIGSTOP)
            time.sleep(45)
            server.process.send_signal(signal.SIGCONT)
        case 5:
            server.tell("jump 14400")
            time.sleep(3)
            server.tell("jump -14400")
        case 8:
            watch.end(kill=True)
            time.sleep(20)
            watch = Process(*words)
            watch.says("connected to", 120)
        case _:
            return watch
    print(f"minute {minute}: {watch.log[-3:]}", flush=True)
    return watch


def soak(folder: Path, loops: int, minutes: float, faults: bool) -> int:
    days = 2 + int(minutes * 100 / 1440)
    server, words, watch, watched = begun(folder, loops, days, "--speed", 100)
    server.tell("play")
    begin, series = time.monotonic(), []
    while (left := begin + 60 * minutes - time.monotonic()) > 0 and watch.process.poll() is None:
        time.sleep(min(60.0, max(1.0, left)))
        state = json.loads((watched / ".stiction/live/status.json").read_text())
        series.append(memory(watch.process.pid))
        print(
            f"{len(series)} min: {series[-1]:.1f} MB, {cpu(watch.process.pid):.0f} s of CPU, {state['values']} values, last hour "
            f"{state['last_hour']}, scan {state['scan_s']} s",
            flush=True,
        )
        if faults:
            watch = disturb(len(series), server, words, watch)
    server.tell("requests")
    asked = server.answer("requests")["requests"]
    print(json.dumps(asked))
    code = watch.end()
    server.end(kill=True)
    quarter = series[len(series) // 4 :]
    growth = 100 * (max(quarter) / quarter[0] - 1)
    wrong = missing = marked = count = 0
    data = played(folder / "played", None)
    for path in sorted((watched / "data").glob("*/*.parquet")):
        begin = hours._journal_hour(Path(f"{path.parent.name}T{path.stem}.0.values"))
        for tag, rows in hours.tables_by_tag(path):
            times, values = data[tag]
            own = (times >= begin) & (times < begin + hours.HOUR)
            known = set(zip(times[own].tolist(), values[own].tolist()))
            found = {(t, v) for t, v, s in zip(rows.time.tolist(), rows.value.tolist(), rows.status.tolist()) if s == 0}
            behind = rows.status[np.searchsorted(rows.time, [t for t, _ in known - found]) - 1] == hours.LOST
            wrong, marked, count = wrong + len(found - known), marked + int(behind.sum()), count + len(found)
            missing += len(known - found) - int(behind.sum())
    services = {kind.__name__ for kind in opcua.SERVICES}
    print(f"{count} values, {missing} missing without a mark, {marked} marked as lost, {wrong} wrong; ", end="")
    print(f"memory grew by {growth:.1f} % after the first quarter; exit code {code}")
    print(f"services that are not listed: {sorted(set(asked) - services) or 'none'}")
    return int(bool(wrong or missing or (marked and not faults) or set(asked) - services or growth > 5 or code))


def play(folder: Path, loops: int, speed: float, minutes: float, encrypted: bool) -> int:
    modules, why = node_modules(folder)
    if modules is None:
        raise SystemExit(why)
    plant, watched, port = folder / "played", folder / "watched", free_port()
    stiction.plant.demo(plant, loops=loops, days=1 + int(minutes / 1440))
    watched.mkdir()
    (watched / "plant.toml").write_text((plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
    data = of_plant(plant, 60 * minutes, modes=True)
    server = node_server(modules, port, folder, data, speed)
    end = server.answer("listening", 120)["end"]
    watch = ["-m", "stiction.live", "watch", "-C", watched]
    if encrypted:
        Process(*watch, "--make-certificate").process.wait(60)
    security = ["--trust-first"] if encrypted else ["--security", "none"]
    watch = Process(*watch, f"opc.tcp://127.0.0.1:{port}", *security, "--publish", "100ms", "--sample", "0s", "--queue", "5000")
    print(watch.says("connected to", 120), flush=True)
    before = [cpu(each.process.pid) for each in (watch, server)]
    server.tell("play")
    sent = server.answer("played", 3 * 60 * minutes / speed + 60)
    # The last hour ends two minutes later.
    state = lambda: json.loads((watched / ".stiction/live/status.json").read_text())  # noqa: E731
    wait_for(lambda: (state()["known_until"] or 0) > 1e-6 * end + 1, 60, "the end")
    used = [cpu(each.process.pid) - start for each, start in zip((watch, server), before)]
    most = memory(watch.process.pid)
    wait_for(lambda: state()["last_hour"] == hours.shown(hours.hour_of(end)), 120, "the judgement of the last hour")
    # On a busy machine values come after their hour was written. They wait in journals, and the hour is written again.
    late = lambda: [path for path in (watched / ".stiction/live").glob("*/*.values") if hours._journal_hour(path) < end]  # noqa: E731
    wait_for(lambda: not late() and not state()["judging"], 240, "the values that came late")
    server.tell("requests")
    asked = server.answer("requests")["requests"]
    code = watch.end()
    server.end(kill=True)
    wrong, otherwise = unequal(watched, data), judged_otherwise(watched, data, folder / "other")
    print(
        f"{sent['played']} values of {len(data)} tags in {sent['seconds']:.1f} s, {sent['played'] / sent['seconds']:.0f} a second: "
        f"{1e6 * used[0] / sent['played']:.1f} us of CPU per value, {most:.0f} MB (the server {1e6 * used[1] / sent['played']:.1f} us); "
        f"tags that differ: {len(wrong)}; columns of windows that differ: {', '.join(otherwise) or 'none'}; exit code {code}"
    )
    print(json.dumps(asked))
    return int(bool(wrong or otherwise or set(asked) - {kind.__name__ for kind in opcua.SERVICES} or code))


def load(folder: Path, loops: int, minutes: float) -> int:
    server, _, watch, watched = begun(folder, loops, 1, "--speed", 0.001, "--last", 60)
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


FETCH = """
import json, sys, time
from pathlib import Path
from stiction.live import sql
begin = time.monotonic()
done = sql.fetch(sys.argv[1], Path(sys.argv[2]), say=lambda text: print(text, file=sys.stderr, flush=True))
most = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
print(json.dumps(done | {"s": time.monotonic() - begin, "cpu_s": time.process_time(), "MB": most / 1024}))
"""


def rows_of(path: Path) -> pa.Table:
    """The times, tags and values of a file, in order of tag and time."""
    schema = pa.schema([("time", pa.timestamp("us", "UTC")), ("tag", pa.string()), ("value", pa.float64())])
    table = pq.read_table(path, columns=schema.names).cast(schema)
    return table.sort_by([("tag", "ascending"), ("time", "ascending")])


def sql(folder: Path, loops: int, days: int) -> int:
    plant, fetched, cluster = folder / "played", folder / "fetched", folder / "cluster"
    stiction.plant.demo(plant, loops=loops, days=days)
    for each in (fetched, cluster):
        each.mkdir()
    (fetched / "plant.toml").write_text((plant / "plant.toml").read_text().replace("data/*", "data/**/*"))
    files = sorted((plant / "data").glob("*.parquet"))
    with postgres(cluster) as url:
        with psycopg.connect(url) as connection, connection.cursor() as cursor:
            cursor.execute("CREATE TABLE samples (time timestamptz, tag text, value double precision)")
            for path in files:
                with cursor.copy("COPY samples FROM STDIN (FORMAT csv)") as copy, pq.ParquetFile(path) as file:
                    for batch in file.iter_batches(columns=["time", "tag", "value"]):
                        text = pa.BufferOutputStream()
                        csv.write_csv(batch, text, csv.WriteOptions(include_header=False))
                        copy.write(text.getvalue().to_pybytes())
            cursor.execute("CREATE INDEX ON samples (tag, time)")
            [rows] = cursor.execute("SELECT count(*) FROM samples").fetchone()
        print(f"{rows} rows in the table", flush=True)
        words = [sys.executable, "-c", FETCH, f"{url}?table=samples", str(fetched)]
        done = json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout)
    compared, wrong = 0, []
    for path in files:
        own, other = rows_of(path), rows_of(fetched / "data/sql/samples" / path.name)
        compared += len(other)
        if not own.equals(other):
            wrong.append(path.name)
    print(
        f"{done['rows']} rows of {loops} loops and {done['days']} days in {done['s']:.0f} s with {done['cpu_s']:.0f} s of CPU and "
        f"{done['MB']:.0f} MB; {compared} rows compared, other rows on {', '.join(wrong) or 'no day'}",
    )
    return int(bool(wrong) or not done["rows"] == compared == rows)


def main() -> int:
    whole = argparse.ArgumentParser()
    whole.add_argument("what", choices=["soak", "faults", "cpu", "play", "sql"])
    whole.add_argument("--loops", type=int, default=50)
    whole.add_argument("--minutes", type=float, default=120)
    whole.add_argument("--speed", type=float, default=100)
    whole.add_argument("--encrypted", action="store_true", help="of play")
    whole.add_argument("--days", type=int, default=7)
    known = whole.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="stiction-live-"))
    try:
        if known.what in ("soak", "faults"):
            return soak(folder, known.loops, known.minutes, known.what == "faults")
        if known.what == "play":
            return play(folder, known.loops, known.speed, known.minutes, known.encrypted)
        if known.what == "sql":
            return sql(folder, known.loops, known.days)
        return load(folder, known.loops, known.minutes)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
