"""The package passes mypy in strict mode, and so do the examples that use it."""

import json
import os
import subprocess
import sys
from pathlib import Path

PYTHON = Path(__file__).parents[1]
NOTEBOOKS = PYTHON / "notebooks"


def mypy(*arguments, cwd):
    config = PYTHON.parent / "pyproject.toml"
    command = [sys.executable, "-m", "mypy", "--config-file", str(config), *map(str, arguments)]
    run = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    assert run.returncode == 0, run.stdout + run.stderr


def test_the_package(tmp_path):
    mypy(cwd=PYTHON.parent)


def test_the_stub_is_the_module(tmp_path):
    command = [sys.executable, "-m", "mypy.stubtest", "--ignore-disjoint-bases", "stiction._core"]
    # Away from both, so that the module is the installed one.
    environment = {**os.environ, "MYPYPATH": str(PYTHON)}
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert run.returncode == 0, run.stdout


def test_the_notebooks(tmp_path):
    files = []
    for notebook in sorted(NOTEBOOKS.glob("*.ipynb")):
        cells = json.loads(notebook.read_text())["cells"]
        code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        lines = [line for cell in code for line in cell.splitlines() if not line.startswith("%")]
        files.append(tmp_path / f"{notebook.stem}.py")
        files[-1].write_text("\n".join(lines) + "\n")
    for file in files:
        mypy(file, cwd=PYTHON.parent)
