"""The page of the Python API and the classes of a diagnosis are what `docs/python_api.py` makes, and have every name."""

import importlib.util
from pathlib import Path

import pytest
import stiction

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.parametrize("made", ["classes", "page"])
def test_what_is_made_is_up_to_date(made):
    spec = importlib.util.spec_from_file_location("python_api", DOCS / "python_api.py")
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    path = {"classes": maker.CLASSES, "page": maker.PAGE}[made]
    assert getattr(maker, made)() == path.read_text(encoding="utf-8"), "run python3 docs/python_api.py"


def test_every_public_name_has_a_heading_and_words():
    text = (DOCS / "python-api.md").read_text(encoding="utf-8")
    parts = {part.partition("\n")[0]: part.partition("\n")[2] for part in text.split("\n### ")}
    for name in set(stiction.__all__) - {"__version__"}:
        words = parts[name].split("```")[2].strip()
        assert words and not words.startswith("#"), f"{name} is not documented"
