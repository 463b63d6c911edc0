"""Compares the time of a call from Python with the time of the call in Rust.

    pip install . && python python/benchmarks/overhead.py

The times are the best of many runs on one machine. Then eight threads diagnose, and the last figure is the number of busy cores.
Rust and Python allocate the valve positions anew each time. Rust's are cleared first, as a slice must be; NumPy's need not be, so
that Python can be the faster.
"""

import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import stiction

ROOT = Path(__file__).parents[2]
SAMPLES = 2000


def best(run, times):
    """Best of `times` runs, s."""
    found = float("inf")
    for _ in range(times):
        begin = time.perf_counter()
        run()
        found = min(found, time.perf_counter() - begin)
    return found


def main():
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "FIC101.csv"
        lines = (ROOT / "samples" / "FIC101-sticky.csv").read_text().splitlines()[: SAMPLES + 1]
        path.write_text("\n".join(lines) + "\n")
        peer = ["cargo", "run", "--quiet", "--release", "-p", "stiction", "--example", "python_peer", str(path)]
        printed = subprocess.run(peer, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        rust_follow, rust_diagnosis = map(float, printed.split())
        (recording,) = stiction.read(path)

    op = 50 + 12 * np.sin(np.arange(1_000_000) * 0.011)
    follow = best(lambda: stiction.valve(op, S=5, J=2, position=50), 50)
    diagnosis = best(lambda: stiction.diagnose(recording), 100)
    print(f"a valve over 1e6 samples: Rust {1e3 * rust_follow:.3f} ms, Python {1e3 * follow:.3f} ms,"
          f" ratio {follow / rust_follow:.3f}")
    print(f"a diagnosis of {SAMPLES} samples: Rust {1e3 * rust_diagnosis:.2f} ms,"
          f" Python {1e3 * diagnosis:.2f} ms, ratio {diagnosis / rust_diagnosis:.3f}")

    wall, cpu = time.perf_counter(), time.process_time()
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(stiction.diagnose, [recording] * 400))
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"eight threads: {cpu / wall:.2f} of {os.cpu_count()} cores busy, {400 / wall:.0f} diagnoses a second")


if __name__ == "__main__":
    sys.exit(main())
