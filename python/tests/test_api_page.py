"""The page of the Python API is what `docs/python_api.py` makes of the sources, and has every public name."""

import importlib.util
from pathlib import Path

import stiction

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_page_is_up_to_date():
    spec = importlib.util.spec_from_file_location("python_api", DOCS / "python_api.py")
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    assert maker.page() == (DOCS / "python-api.md").read_text(encoding="utf-8"), "run python3 docs/python_api.py"


def test_every_public_name_has_a_heading_and_words():
    text = (DOCS / "python-api.md").read_text(encoding="utf-8")
    parts = {part.partition("\n")[0]: part.partition("\n")[2] for part in text.split("\n### ")}
    for name in set(stiction.__all__) - {"__version__"}:
        words = parts[name].split("```")[2].strip()
        assert words and not words.startswith("#"), f"{name} is not documented"
