"""Every block of Python in the documents runs, in the order of its page, beside what a clone holds."""

import shutil
from pathlib import Path

import matplotlib.pyplot
import pytest
import stiction

matplotlib.use("Agg")

ROOT = Path(__file__).parents[2]
#: A page whose blocks need one of these is skipped where it is not installed, saying so.
OPTIONAL = {"control", "fmpy", "matplotlib", "pandas", "polars", "pyarrow", "sklearn", "tqdm"}


def blocks(page):
    """Give the blocks of Python of a page, each with the number of its first line."""
    found, block = [], None
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if block is None:
            if line.startswith("```"):
                block = (line.removeprefix("```"), number + 1, [])
        elif line.startswith("```"):
            found.append(block)
            block = None
        else:
            block[2].append(line)
    assert block is None, f"{page}: a block is not closed"
    return [(number, "\n".join(lines)) for language, number, lines in found if language == "python"]


PAGES = [
    page
    for page in [ROOT / "README.md", ROOT / "python" / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if blocks(page)
]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "samples", "samples")
    # What the first command of docs/fmu.md writes.
    stiction.fmu.export("valve.fmu", "two-phase", S=5, J=3)
    names = {"__name__": "__main__"}
    for number, code in blocks(page):
        # Errors name the line of the page.
        compiled = compile("\n" * (number - 1) + code, str(page), "exec")
        try:
            exec(compiled, names)
        except ModuleNotFoundError as error:
            if error.name.partition(".")[0] not in OPTIONAL:
                raise
            pytest.skip(f"line {number} needs {error.name}")
        finally:
            matplotlib.pyplot.close("all")


def test_pages_are_found():
    found = {page.relative_to(ROOT).as_posix(): len(blocks(page)) for page in PAGES}
    assert found["python/README.md"] >= 3 and found["docs/guides/researcher.md"] >= 8
