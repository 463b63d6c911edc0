"""The examples in docstrings give what they say."""

import doctest
import importlib
import pkgutil

import pytest
import stiction
from stiction import _core

MODULES = ["stiction", *(f"stiction.{info.name}" for info in pkgutil.iter_modules(stiction.__path__))]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failed, _ = doctest.testmod(importlib.import_module(name))
    assert failed == 0


def test_examples_of_compiled_classes():
    finder, runner = doctest.DocTestFinder(), doctest.DocTestRunner()
    classes = [value for value in vars(_core).values() if isinstance(value, type)]
    assert classes
    for cls in classes:
        for test in finder.find(cls, cls.__name__, globs={"stiction": stiction}):
            runner.run(test)
    assert runner.summarize(verbose=False).failed == 0
