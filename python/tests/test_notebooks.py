"""Every notebook runs from its first to its last cell, and is stored with what it shows."""

import re
import sys
from pathlib import Path

import nbformat
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "notebooks"))
from run import NOTEBOOKS, ran


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def shown(cell):
    """What a cell shows, by kind: text as it is told, or the types of what is displayed."""
    return [out.get("name") or sorted(out.data) for out in cell.outputs]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs_and_shows_what_is_stored(path):
    stored, now = (code_cells(notebook) for notebook in (nbformat.read(path, as_version=4), ran(path)))
    assert [shown(cell) for cell in stored] == [shown(cell) for cell in now], "store it by python/notebooks/run.py"
    assert [cell.execution_count for cell in stored] == list(range(1, len(stored) + 1))
    assert any("image/png" in kinds for cell in stored for kinds in shown(cell))
    assert not any("stderr" in shown(cell) for cell in now)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_nothing_of_a_machine_is_stored(path):
    for cell in code_cells(nbformat.read(path, as_version=4)):
        for out in cell.outputs:
            texts = [out.get("text", ""), *(text for kind, text in out.get("data", {}).items() if "text" in kind)]
            assert not any(re.search(r"/(home|root|tmp|work|usr)/", text) for text in texts)
