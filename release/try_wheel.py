"""Try a released wheel for Linux in fresh environments of several Pythons, without a compiler in reach.

    python release/try_wheel.py OUT/stiction-0.1.0-cp310-abi3-*_x86_64.whl python3.10 python3.11 python3.12 python3.13

Each Python gets an environment of its own. `pip` installs the wheel there with a PATH that has nothing else in it, so that nothing
can be compiled. Then a sample is diagnosed, a valve and a loop are simulated, and an FMU is written. Results must be equal for all
Pythons.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

SAMPLE = pathlib.Path(__file__).resolve().parents[1] / "samples/FIC101-sticky.csv"
TRIAL = """
import sys, stiction
[loop] = stiction.read(sys.argv[1])
verdict = stiction.diagnose(loop).verdict
position = stiction.valve([0, 4, 8, 4, 0], S=5, J=2)
run = stiction.simulate("paper/closed-loop")
stiction.fmu.export(sys.argv[2], model="two-phase", S=5, J=3)
print(verdict.class_, verdict.probability, list(position), run.period_s)
"""


def tried(wheel: pathlib.Path, python: str, folder: pathlib.Path) -> str:
    """What the trial prints in a fresh environment of a Python."""
    environment = folder / "environment"
    subprocess.run([python, "-m", "venv", "--clear", environment], check=True)
    own = environment / "bin/python"
    alone = {"PATH": str(environment / "bin"), "HOME": str(folder)} | {k: v for k, v in os.environ.items() if k.startswith("PIP_")}
    subprocess.run([own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:", wheel], env=alone, check=True)
    words = [own, "-c", TRIAL, SAMPLE, folder / "valve.fmu"]
    return subprocess.run(words, env=alone, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()


def main() -> int:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("wheel", type=pathlib.Path)
    asked.add_argument("pythons", nargs="+", metavar="PYTHON")
    options = asked.parse_args()
    found = set()
    for python in options.pythons:
        with tempfile.TemporaryDirectory() as folder:
            result = tried(options.wheel.resolve(), python, pathlib.Path(folder))
        print(f"{python}: {result}")
        found.add(result)
    print(f"{len(options.pythons)} Pythons, {len(found)} result{'' if len(found) == 1 else 's'}")
    return int(len(found) != 1)


if __name__ == "__main__":
    sys.exit(main())
