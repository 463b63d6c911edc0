"""Measures the comparison of all loops of a week on Spark and on one machine, for the table of BENCHMARKS.md.

    pip install ".[spark]" && python python/benchmarks/spark_groups.py --loops 1000

The traces are synthetic, and a third of the loops swing in groups of three. Both methods have all cores of this machine.
"""

import argparse
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import stiction.plant
from pyspark.sql import SparkSession
from stiction import _core
from stiction.plant import spark as plant_spark

from spark import sampled

DAYS = 7
FIRST = 1_772_409_600
"""2026-03-02, a Monday."""
CELLS = 86_400 // _core.TRACE_STEP_S


def swing(rng, steps, late):
    """Return a swing in noise, whose period wanders about this number of steps."""
    phase = np.cumsum(2 * np.pi / steps * (1 + 0.3 * rng.standard_normal(DAYS * CELLS + 50)))
    noise = np.random.default_rng((int(steps * 1000), late, 7)).standard_normal(DAYS * CELLS)
    return np.sin(phase)[late : late + DAYS * CELLS] + 0.7 * noise


def values(loop, loops):
    group, member = (loop // 3, loop % 3) if loop < loops // 3 else (loop, 0)
    return swing(np.random.default_rng((group, 1)), 20 + group % 37 + group / 1e5, 5 * member)


def written(folder, loops):
    """The plant, its store, and the same rows as Spark writes them."""
    (folder / "plant.toml").write_text('name = "Many"\nzone = "UTC"\ndata = ["*.csv"]\n')
    schema = stiction.plant.schema()
    empty = {"string": "", "int64": 0, "double": 0.0, "bool": False}
    needed = {field.name: empty[str(field.type)] for field in schema if not field.nullable}
    output = folder / "rows" / "run=0001"
    output.mkdir(parents=True)
    for begin in range(0, loops, 100):
        rows, traces = [], []
        for loop in range(begin, min(begin + 100, loops)):
            x = values(loop, loops).reshape(DAYS, CELLS)
            for day in range(DAYS):
                start, unit = FIRST + 86_400 * day, float(x[day].std() / 100)
                rows.append({**needed, "loop": f"L{loop:05}", "window_start": start, "window_s": 86_400})
                whole = np.rint((x[day] - x[day].mean()) / unit).astype("<i2").tobytes()
                traces.append((start, "error", unit, whole))
        table = pa.Table.from_pylist(rows, schema)
        for field, column in zip(plant_spark._trace_fields(), zip(*traces)):
            table = table.append_column(field, pa.array(column, field.type))
        stiction.plant.take(folder, table, plant_spark._traces(table))
        pq.write_table(table, output / f"{begin:05}.parquet")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--loops", type=int, default=1000)
    of = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="stiction-groups-"))
    try:
        written(folder, of.loops)
        begin, cpu = time.monotonic(), time.process_time()
        expected = [group.to_dict() for group in stiction.plant.groups(folder)]
        told = f"{time.monotonic() - begin:.1f} s, {time.process_time() - cpu:.1f} s of CPU"
        print(f"{of.loops} loops, {len(expected)} groups; here {told}")
        cores = len(os.sched_getaffinity(0))
        os.environ["PYSPARK_PYTHON"] = sys.executable
        session = SparkSession.builder.master(f"local[{cores}]").config("spark.ui.enabled", "false").getOrCreate()
        rows = session.read.parquet(str(folder / "rows"))
        begin = time.monotonic()
        with sampled(os.getpid()) as most:
            found = plant_spark.pairs(rows, folder)
        clock = time.monotonic() - begin
        python = [(cpu, memory) for cpu, memory, line, _ in most.values() if "daemon" in line]
        print(
            f"Spark {clock:.1f} s, Python {sum(cpu for cpu, _ in python):.1f} s of CPU, "
            f"a worker of it {max(memory for _, memory in python) / 1e6:.0f} MB at most; {found}"
        )
        session.stop()
        begin = time.monotonic()
        same = [group.to_dict() for group in stiction.plant.groups(folder)] == expected
        print(f"here, with the pairs from Spark: {time.monotonic() - begin:.1f} s; the same groups: {same}")
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
