"""Draws again the pictures of the documents that a command of the project draws.

python3 docs/figures.py [path of the command, default target/release/stiction]

Other pictures in docs/figures have other sources. pages/check.py takes `report.png` and `index.png` in a browser.
`plant.png` is the page of `stiction plant demo --loops 200 --days 7`, 1300 by 1000 px in a browser.
python/benchmarks/communication_step.py, which needs FMPy, draws `fmu-communication-step.svg`. Block diagram and flow
chart are drawn by hand.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FIGURES = ROOT / "docs" / "figures"
#: What is drawn, and by which command; `figures` draws many, of which one is kept.
DRAWN = {
    "map.png": "limit-cycle paper/closed-loop --map S=1:10 J=0:10 --plot map.png",
    "closed-loop-response.svg": "simulate paper/closed-loop --set duration=120 --plot closed-loop-response.svg",
    "figures/figure-03-typical-behaviour.svg": "figures -o figures",
}
NAMES = {"figures/figure-03-typical-behaviour.svg": "sticking-valve.svg"}


def main() -> None:
    command = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/stiction").resolve()
    with tempfile.TemporaryDirectory() as folder:
        for drawn, arguments in DRAWN.items():
            subprocess.run([command, *arguments.split()], cwd=folder, stdout=subprocess.PIPE, check=True)
            (FIGURES / NAMES.get(drawn, drawn)).write_bytes((Path(folder) / drawn).read_bytes())


if __name__ == "__main__":
    main()
