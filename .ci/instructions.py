"""Counts the instructions of some commands, and compares them with what we allow (`.ci/instructions.json`, in millions).

    python3 .ci/instructions.py target/debug/stiction            # exit code 1: one takes more than allowed
    python3 .ci/instructions.py target/debug/stiction --write    # allow what was counted

One thread, the dev profile, valgrind: the counts differ by less than 0.1 % from run to run, whatever else the machine does. They may
exceed the allowed ones by 3 %, for other compilers and libraries. A commit that raises one says why in a line "Budget:".
"""

import csv
import json
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ALLOWED = ROOT / ".ci" / "instructions.json"
SAMPLE = ROOT / "samples" / "FIC101-sticky.csv"
COMMANDS = {
    "nothing": "--version",
    "diagnose, 2,400 samples": f"diagnose {SAMPLE}",
    "diagnose, 12,000 samples": "diagnose long.csv",
    "report": f"diagnose {SAMPLE} --report report.html",
    "fit": f"fit {SAMPLE}",
    "test read": f"test read {ROOT / 'samples' / 'test' / 'FIC106-tested.csv'}",
    "plant scan, 4 loop-days": "plant -C plant scan",
}
OVER = 1.03


def counted(program: Path, arguments: str, folder: Path) -> int:
    """The instructions of a command, in millions."""
    words = ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", str(program)]
    environment = {**os.environ, "RAYON_NUM_THREADS": "1", "HOME": str(folder)}
    done = subprocess.run([*words, *arguments.split()], cwd=folder, env=environment, capture_output=True, text=True)
    refs = re.search(r"I +refs: +([\d,]+)", done.stderr)
    if done.returncode != 0 or refs is None:
        sys.exit(f"{arguments}: exit code {done.returncode}\n{done.stderr}")
    return round(int(refs[1].replace(",", "")) / 1e6)


def main() -> int:
    program = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        header, *rows = list(csv.reader(SAMPLE.open()))
        with (folder / "long.csv").open("w", newline="") as file:
            out = csv.writer(file)
            out.writerow(header)
            out.writerows([k * len(rows) + int(row[0]), *row[1:]] for k in range(5) for row in rows)
        subprocess.run([program, "plant", "demo", "--loops", "4", "--days", "1", "-o", folder / "plant", "-q"], check=True)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            found = dict(zip(COMMANDS, pool.map(lambda of: counted(program, of, folder), COMMANDS.values()), strict=True))
    if "--write" in sys.argv:
        ALLOWED.write_text(json.dumps({"millions": found}, indent=2) + "\n")
        return 0
    allowed = json.loads(ALLOWED.read_text())["millions"]
    for what, count in found.items():
        print(f"{what}: {count} million instructions, {allowed[what]} allowed")
    over = [what for what, count in found.items() if count > OVER * allowed[what]]
    print(*(f"Too many: {what}" for what in over), sep="\n")
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())
