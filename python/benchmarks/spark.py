"""Compares the time of a scan on Spark with the time of the local engine, for the table in BENCHMARKS.md.

    pip install ".[spark]" && python python/benchmarks/spark.py --loops 50 --days 3

A demo plant is scanned by the local engine in one thread, then by Spark on one machine with one and with two workers, each bound to
a separate CPU. Driver and master may use any CPU. CPU seconds are summed over processes and sampled from /proc: the driver, the
virtual machines of Java that work, and their Python, which reads tables and diagnoses. It runs on Linux.
"""

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import stiction.plant

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "spark"))
from cluster import Cluster, environment  # noqa: E402

TICK = os.sysconf("SC_CLK_TCK")
PAGE = os.sysconf("SC_PAGE_SIZE")


def below(root):
    """CPU time (s), memory (bytes) and command of a process and of all its descendants, by process ID."""
    parents, found = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            stat = (folder / "stat").read_text().rpartition(")")[2].split()
            command = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        pid = int(folder.name)
        parents[pid] = int(stat[1])
        found[pid] = ((int(stat[11]) + int(stat[12])) / TICK, int(stat[21]) * PAGE, command)
    own, reached = [root], {root: found[root]} if root in found else {}
    while own:
        parent = own.pop()
        for pid in [pid for pid, of in parents.items() if of == parent]:
            reached[pid] = found[pid]
            own.append(pid)
    return reached


@contextmanager
def sampled(*roots):
    """By number of each process at or below some, as it is sampled: the most CPU s, the most memory, command, and of which."""
    most, ended = {}, threading.Event()

    def sample():
        while not ended.wait(0.1):
            for root in roots:
                for pid, (cpu, memory, line) in below(root).items():
                    before = most.get(pid, (0.0, 0, "", root))
                    # A process that ends has no command any more.
                    most[pid] = (max(cpu, before[0]), max(memory, before[1]), line or before[2], root)

    sampling = threading.Thread(target=sample)
    sampling.start()
    yield most
    ended.set()
    sampling.join()


def on_spark(folder, workers, made):
    """Cost of a scan by this many workers, each on its own CPU: CPU s of the driver, of the workers' Java and of their Python, the
    largest memory of one of these in bytes, and s on the clock."""
    made.mkdir()
    cluster = Cluster(made, workers, sorted(os.sched_getaffinity(0)))
    command = [sys.executable, "-m", "stiction.plant.spark", "--plant", str(folder), "--output", str(made / "rows")]
    command += ["--input", str(folder / "data"), "--again", "--master", cluster.url, "--conf", "spark.ui.enabled=false"]
    # What reads and judges is on the path of the executors already.
    own = environment(PYSPARK_PYTHON=sys.executable)
    begin = time.monotonic()
    process = subprocess.Popen(command, env=own, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with sampled(process.pid, *(worker.pid for worker in cluster.workers)) as most:
        out, err = process.communicate()
        clock = time.monotonic() - begin
    cluster.end()
    if process.returncode != 0:
        raise SystemExit(err[-3000:])
    driver = sum(cpu for cpu, _, _, root in most.values() if root == process.pid)
    workers = [(cpu, memory, line) for cpu, memory, line, root in most.values() if root != process.pid]
    python = [(cpu, memory) for cpu, memory, line in workers if "daemon" in line]
    java = sum(cpu for cpu, _, line in workers if "daemon" not in line)
    print(out.strip())
    return driver, java, sum(cpu for cpu, _ in python), max(memory for _, memory in python), clock


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--loops", type=int, default=50)
    parser.add_argument("--days", type=int, default=3)
    of = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="stiction-spark-"))
    try:
        stiction.plant.demo(folder, loops=of.loops, days=of.days)
        begin = resource.getrusage(resource.RUSAGE_SELF)
        stiction.plant.scan(folder, threads=1)
        end = resource.getrusage(resource.RUSAGE_SELF)
        days = of.loops * of.days
        local = end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime
        print(f"{of.loops} loops x {of.days} days; CPU s a loop-day")
        print(f"local, reading and judging  {local / days:.3f}")
        for workers in (1, 2):
            driver, java, python, memory, clock = on_spark(folder, workers, folder / f"cluster-{workers}")
            print(
                f"Spark, {workers} workers: driver {driver / days:.3f}, Java of the workers {java / days:.3f}, Python "
                f"{python / days:.3f}; a worker of Python takes {memory / 1e6:.0f} MB at most; {clock:.0f} s on the clock"
            )
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
