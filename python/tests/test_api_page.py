"""The page of the Python API and the classes of results are what `docs/python_api.py` makes, and have every name."""

import importlib
import importlib.util
import pkgutil
import re
from pathlib import Path

import pytest
import stiction

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.parametrize("made", ["classes", "page", "stub"])
def test_what_is_made_is_up_to_date(made):
    spec = importlib.util.spec_from_file_location("python_api", DOCS / "python_api.py")
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    path = {"classes": maker.CLASSES, "page": maker.PAGE, "stub": maker.STUB}[made]
    assert getattr(maker, made)() == path.read_text(encoding="utf-8"), "run python3 docs/python_api.py"


def test_every_public_name_has_a_row_and_words():
    text = (DOCS / "python-api.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) < 700
    parts = {part.partition("\n")[0]: part for part in text.split("\n## ")}
    for name in (f"stiction.{info.name}" for info in pkgutil.iter_modules(stiction.__path__) if info.name[0] != "_"):
        rows = re.findall(r"^\| `(\w+)` \| .* \| .+[.:] \|$", parts[name], re.MULTILINE)
        assert sorted(rows) == sorted(importlib.import_module(name).__all__)
