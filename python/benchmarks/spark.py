"""What a scan on Spark costs beside the same scan here: the table of BENCHMARKS.md.

    pip install ".[spark]" && python python/benchmarks/spark.py --loops 50 --days 3

A demo plant is scanned by the local engine in one thread, then by Spark on one machine with one and with two workers of
one core. CPU seconds are those of processes, sampled from /proc: the virtual machines of Java, and the workers of Python,
which read the tables and diagnose. It runs on Linux.
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
from pathlib import Path

import stiction.plant

TICK = os.sysconf("SC_CLK_TCK")
PAGE = os.sysconf("SC_PAGE_SIZE")


def below(root):
    """CPU s, memory in bytes and the command of all processes below one, by number."""
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
    own, reached = [root], {}
    while own:
        parent = own.pop()
        for pid in [pid for pid, of in parents.items() if of == parent]:
            reached[pid] = found[pid]
            own.append(pid)
    return reached


def on_spark(folder, workers, ended):
    """CPU s of Java and of the workers of Python, the most memory of one of these, and s on the clock of the job."""
    output = folder / f"rows-{workers}"
    command = [sys.executable, "-m", "stiction.plant.spark", "--plant", str(folder), "--output", str(output)]
    command += ["--again", "--master", f"local-cluster[{workers},1,1024]", "--conf", "spark.ui.enabled=false"]
    # What reads and judges is on the path of the executors already.
    home = str(Path(__import__("pyspark").__file__).parent)
    environment = {**os.environ, "PYSPARK_PYTHON": sys.executable, "SPARK_HOME": home, "SPARK_SCALA_VERSION": "2.13"}
    most = {}
    begin = time.monotonic()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def sample():
        while process.poll() is None:
            for pid, (cpu, memory, line) in below(process.pid).items():
                before = most.get(pid, (0.0, 0, ""))
                most[pid] = (max(cpu, before[0]), max(memory, before[1]), line)
            time.sleep(0.1)

    sampling = threading.Thread(target=sample)
    sampling.start()
    out, err = process.communicate()
    sampling.join()
    if process.returncode != ended:
        raise SystemExit(err[-3000:])
    java = sum(cpu for cpu, _, line in most.values() if "java" in line.split(" ")[0])
    python = [(cpu, memory) for cpu, memory, line in most.values() if "daemon" in line]
    return java, sum(cpu for cpu, _ in python), max(memory for _, memory in python), time.monotonic() - begin, out


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
            java, python, memory, clock, told = on_spark(folder, workers, 0)
            print(told.strip())
            print(
                f"Spark, {workers} workers: Java {java / days:.3f}, Python {python / days:.3f}; "
                f"a worker of Python takes {memory / 1e6:.0f} MB at most; {clock:.0f} s on the clock"
            )
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
