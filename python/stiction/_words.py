"""Documents attributes beside the types of the attributes, and parameters that functions share."""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

__all__: list[str] = []

F = TypeVar("F", bound=Callable[..., Any])

PARAMETERS = {
    "diagnoses": ("iterable of Diagnosis", "The diagnoses."),
    "folder": ("path", "The folder of ``plant.toml``."),
    "J": ("float", "Slip jump, percent of span."),
    "loop_type": ('str, default "unknown"', "Type of the loop, see `stiction.recordings.loop_types`."),
    "loops": ("str, optional", 'Judge only loops whose names match this pattern, such as ``"FIC*"``.'),
    "method": ("str", "Name of the method, see `stiction.detection.detectors`."),
    "model": ('str, default "two-phase"', "Name of a valve model, see `stiction.valves.valve_models`."),
    "name": ("str", "Name of the sample recording, see `names`."),
    "op": ("array_like", "Controller output, percent of span."),
    "period_s": ("float, optional", "Period of the oscillation, s; by default the period of the dominant oscillation."),
    "progress": ("callable, optional", "Called from time to time with the number of finished loops."),
    "pv": ("array_like", "Process value, with as many samples as the OP."),
    "recording": ("Recording or table", "The recording, or a table with the columns of one loop."),
    "S": ("float", "Stick band plus dead band, percent of span."),
    "sample_time": ("float", "Time between samples, s."),
    "scenario": ("Scenario, str, path or mapping", "A control loop, see `stiction.scenario`."),
    "settings": ("mapping, optional", "Changes to the scenario, by dotted key."),
    "since": ("str, optional", 'Judge windows from this day on, such as ``"2026-03-01"``.'),
    "vp": ("array_like", "Measured valve position, percent of span, with as many samples as the OP."),
    "week": ("str, optional", 'The week, such as ``"2026-W10"``; by default the last week with windows.'),
    "X": ("iterable of Recording or table, or array_like", "The cases."),
    "x": ("array_like", "The series."),
}
"""Types and descriptions of parameters that many functions share, by name of the parameter."""

_COUNTS = {2: "two", 3: "three", 4: "four"}
_SECTION = re.compile(r"^(\w+)\n-{3,}\n", re.MULTILINE)


def documented(function: F) -> F:
    """Document the parameters in `PARAMETERS` that the docstring of the function lacks."""
    function.__doc__ = completed(function.__doc__ or "", inspect.signature(function).parameters)
    return function


def drawn(count: int) -> Callable[[F], F]:
    """Document a function that draws on this number of axes and returns the axes."""

    def of(function: F) -> F:
        function.__doc__ = plotting(function.__doc__ or "", count)
        return function

    return of


def completed(text: str, names: Iterable[str]) -> str:
    """Return a docstring completed with the parameters that the docstring leaves to `PARAMETERS`, in the order of the signature."""
    places = {name: place for place, name in enumerate(names)}
    head, *parts = _SECTION.split(inspect.cleandoc(text))
    sections = dict(zip(parts[::2], parts[1::2]))
    told = re.findall(r"^\S.*\n(?:(?:    .*)?\n)*", sections.pop("Parameters", "").rstrip() + "\n", re.MULTILINE)
    entries = [(re.findall(r"\w+", entry.partition(" : ")[0]), entry.rstrip()) for entry in told]
    left = places.keys() - {name for names, _ in entries for name in names}
    entries += [([name], _entry(name, *PARAMETERS[name])) for name in left & PARAMETERS.keys()]
    entries.sort(key=lambda entry: places[entry[0][0]])
    return _joined(head, {"Parameters": "\n".join(entry for _, entry in entries), **sections})


def plotting(text: str, count: int) -> str:
    """Return the docstring of a drawing function, completed with the parameter for the axes."""
    head, *parts = _SECTION.split(inspect.cleandoc(text))
    one = count == 1
    kind = "matplotlib axes, optional" if one else f"sequence of {_COUNTS[count]} matplotlib axes, optional"
    sections = {
        "Parameters": _entry("ax", kind, "Axes to draw on; by default new axes."),
        "Returns": "matplotlib axes" if one else "list of matplotlib axes",
    }
    return _joined(head, {**sections, **dict(zip(parts[::2], parts[1::2]))})


def with_attributes(text: str, fields: Iterable[tuple[str, str, str, str]]) -> str:
    """Return the docstring of a class, completed with name, type, words and kind of each attribute.

    An attribute without words shares the words of the next attribute. An empty kind is made from the type.
    """
    head, *parts = _SECTION.split(inspect.cleandoc(text))
    entries, names = [], []
    for name, annotation, words, kind in fields:
        names.append(name)
        if words:
            entries.append(_entry(", ".join(names), kind or kind_of(annotation), words))
            names = []
    return _joined(head, {"Attributes": "\n".join(entries), **dict(zip(parts[::2], parts[1::2]))})


def kind_of(annotation: str) -> str:
    """Return a type in the notation of docstrings: ``list of float or None``."""
    kinds: list[tuple[str, Any]] = [
        (r"npt\.NDArray\[np\.(bool|int|float|complex|str)\w*\]", r"ndarray of \1"),
        (r"\bComplexArray\b", "ndarray of complex"),
        (r"\bArray\b", "ndarray"),
        (r"\bLiteral\[(.*)\]", lambda held: "{" + held[1].replace("'", '"') + "}"),
        (r"\bdict\[str, ([A-Z]\w+)\]", r"dict of \1"),
        (r"\bdict\[.*\]", "dict"),
        (r"\b(list|tuple|frozenset)\[(\w+)(?:, (?:\.\.\.|\2))*\]", r"\1 of \2"),
        (r"\s*\|\s*", " or "),
    ]
    for pattern, words in kinds:
        annotation = re.sub(pattern, words, annotation)
    return annotation


def _entry(name: str, kind: str, words: str) -> str:
    # Wrapping is slow, and most entries fit on one line.
    lines = textwrap.wrap(words, 110, break_on_hyphens=False) if len(words) > 110 else [words]
    return "\n    ".join([f"{name} : {kind}", *lines])


def _joined(head: str, sections: dict[str, str]) -> str:
    parts = [head.strip(), *(f"{name}\n{'-' * len(name)}\n{body.rstrip()}" for name, body in sections.items() if body)]
    return "\n\n".join(parts)
