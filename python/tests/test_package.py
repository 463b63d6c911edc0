"""Every public name is documented and typed, and unknown keywords are refused."""

import dataclasses
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
import typing

import pytest
import stiction
from stiction import _core
from stiction._result import Result


def _modules():
    for info in pkgutil.iter_modules(stiction.__path__):
        if not info.name.startswith("_"):
            yield importlib.import_module(f"stiction.{info.name}")


def _public():
    """Each public object once, with the name it is found by."""
    seen = {}
    for module in _modules():
        for name in module.__all__:
            value = getattr(module, name)
            if callable(value) and getattr(value, "__module__", "").startswith("stiction"):
                seen.setdefault(id(value), (f"{module.__name__}.{name}", value))
    return list(seen.values())


def _callables():
    """Public functions, classes, and the methods and properties of public classes."""
    for name, value in _public():
        yield name, value
        if inspect.isclass(value):
            for cls in value.__mro__:
                if not getattr(cls, "__module__", "").startswith("stiction"):
                    continue
                for key, member in vars(cls).items():
                    if not key.startswith("_") and (callable(member) or isinstance(member, (property, classmethod, staticmethod)) or inspect.isgetsetdescriptor(member)):
                        yield f"{name}.{key}", member


PUBLIC = _public()
# Sorted, so that several processes collect the same tests.
CALLABLES = sorted({name: value for name, value in _callables()}.items(), key=lambda item: item[0])


def _doc(value):
    return inspect.getdoc(value.__func__ if isinstance(value, (classmethod, staticmethod)) else value) or ""


def test_modules_say_what_they_are():
    for module in _modules():
        assert module.__doc__, module.__name__
        assert module.__all__, module.__name__


def test_help_is_a_table_of_contents():
    code = "import pydoc, stiction; print(*dir(stiction)); print(pydoc.plain(pydoc.render_doc(stiction)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    shown, contents = run.stdout.split("\n", 1)
    names = [name for name in shown.split() if name[0] != "_"]
    assert len(names) <= 40 and len(contents.splitlines()) < 140
    described = contents.partition("PACKAGE CONTENTS")[0]
    for name in [*names, *(module.__name__ for module in _modules())]:
        assert re.search(rf"^ +(\w+, )?{name}\b", described, re.MULTILINE) or f"stiction.{name} " in described, name
    elsewhere = {name for module in _modules() for name in module.__all__}
    assert all(name in elsewhere or inspect.ismodule(getattr(stiction, name)) for name in names)


@pytest.mark.parametrize("name, value", CALLABLES, ids=[name for name, _ in CALLABLES])
def test_it_is_documented(name, value):
    doc = _doc(value)
    assert doc, f"{name} is not documented"
    if isinstance(value, property) or inspect.isgetsetdescriptor(value):
        return
    if inspect.isclass(value) and dataclasses.is_dataclass(value):
        named = doc[doc.index("Attributes\n") :] if "Attributes\n" in doc else ""
        for field in dataclasses.fields(value):
            assert field.name in named, f"{name}: its attribute {field.name} is not documented"
        return
    function = value.__func__ if isinstance(value, (classmethod, staticmethod)) else value
    try:
        signature = inspect.signature(function)
    except ValueError:
        return
    for parameter in signature.parameters.values():
        if parameter.name in {"self", "cls"} or parameter.kind in {parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD}:
            continue
        assert "Parameters\n" in doc, f"{name}: its parameters are not documented"
        parameters = doc[doc.index("Parameters\n") :]
        assert parameter.name in parameters, f"{name}: {parameter.name} is not documented"


@pytest.mark.parametrize("name, value", CALLABLES, ids=[name for name, _ in CALLABLES])
def test_it_is_typed(name, value):
    function = value.__func__ if isinstance(value, (classmethod, staticmethod)) else value
    if isinstance(function, property):
        function = function.fget
    if inspect.isfunction(function):
        hints = typing.get_type_hints(function)
        assert "return" in hints, f"{name} does not say what it returns"
        for parameter in inspect.signature(function).parameters:
            if parameter not in {"self", "cls"}:
                assert parameter in hints, f"{name}: {parameter} has no type"


@pytest.mark.parametrize("name, value", PUBLIC, ids=[name for name, _ in PUBLIC])
def test_it_refuses_an_unknown_keyword(name, value):
    with pytest.raises(TypeError):
        value(no_such_keyword=1)


def test_results_unpack_and_turn_into_dictionaries():
    model = stiction.valves.valve_models()[0]
    assert isinstance(model, Result)
    name, aliases, *_ = model
    assert name == "two-phase" and model.to_dict()["aliases"] == aliases
    assert "two-phase" in repr(model)


def test_the_version_is_the_librarys():
    assert stiction.__version__ == _core.__version__
