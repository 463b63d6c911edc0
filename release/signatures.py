"""Print the public names of the installed package, each with its parameters: name, kind, and whether it may be left out."""

from __future__ import annotations

import importlib
import inspect
import json
import pkgutil
from collections.abc import Iterator
from typing import Any

import stiction


def called(name: str, what: object) -> tuple[str, list[Any] | None]:
    """A name and its parameters; `None` if the object has no parameters or conceals them."""
    try:
        parameters = inspect.signature(what).parameters.values() if callable(what) else None
    except (TypeError, ValueError):
        parameters = None
    if parameters is None:
        return name, None
    optional = [p.default is not p.empty or p.kind.name.startswith("VAR") for p in parameters]
    return name, [[p.name, p.kind.name, free] for p, free in zip(parameters, optional)]


def names(module: str) -> Iterator[tuple[str, list[Any] | None]]:
    """The public names of a module, and the members of its classes. Submodules are left out."""
    loaded = importlib.import_module(module)
    for own in getattr(loaded, "__all__", dir(loaded)):
        what = getattr(loaded, own)
        if own.startswith("_") or inspect.ismodule(what):
            continue
        yield called(f"{module}.{own}", what)
        if inspect.isclass(what):
            members = [(member, of) for member, of in inspect.getmembers(what) if not member.startswith("_")]
            yield from (called(f"{module}.{own}.{member}", of) for member, of in members)


def main() -> None:
    """Print all that can be imported here."""
    found: dict[str, Any] = {}
    own = [f"stiction.{module.name}" for module in pkgutil.iter_modules(stiction.__path__) if module.name[0] != "_"]
    for module in ["stiction", *own]:
        try:
            found.update(names(module))
        except ImportError:
            continue
    print(json.dumps(found))


if __name__ == "__main__":
    main()
