"""Shared features of all results."""

from __future__ import annotations

import dataclasses
import functools
import types
import typing
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from stiction import _words

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # Python 3.10 has none.

    def dataclass_transform(**_):
        return lambda cls: cls


__all__: list[str] = []

T = TypeVar("T")

LONGEST = 400
"""Maximum number of characters of a result at a prompt, which is five lines."""


class Result:
    """A result with named attributes, which unpack in order."""

    _documented_as: ClassVar[Mapping[str, str]] = {}
    """Names in documents of attributes with a different name."""
    _left_out: ClassVar[Mapping[str, str]] = {}
    """Fields of documents that are not attributes, with the reason."""

    @classmethod
    def _prepared(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        """Convert a document to the shape of the attributes, if `result_of` cannot."""
        return document

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain values.

        Returns
        -------
        dict
            Attributes by name. Results within the result become dictionaries, and arrays are unchanged.
        """
        return {name: _plain(value) for name, value in _items(self)}

    def __iter__(self) -> Iterator[Any]:
        return (value for _, value in _items(self))

    def _summary(self) -> list[str]:
        """Return at most five lines for a large result at a prompt, or no line to show the attributes instead."""
        return []

    def __repr__(self) -> str:
        lines = self._summary()
        if lines:
            return "<" + "\n ".join(lines) + ">"
        whole = f"{type(self).__name__}({', '.join(f'{name}={_short(value)}' for name, value in _items(self))})"
        if len(whole) <= LONGEST and "\n" not in whole:
            return whole
        parts = [f"{name}={_shorter(value)}" for name, value in _items(self)]
        return _within(LONGEST, f"{type(self).__name__}(", parts, ")")


def about(words: str, *, kind: str = "", default: Any = dataclasses.MISSING) -> Any:
    """Describe an attribute. An attribute without a description shares the description of the next attribute. By default the kind
    follows from the type of the attribute.
    """
    return dataclasses.field(default=default, metadata={"words": words, "kind": kind})


@dataclass_transform(frozen_default=True, eq_default=False, kw_only_default=True, field_specifiers=(about,))
def result(cls: type[T]) -> type[T]:
    """Make a frozen dataclass with keyword arguments. The class has no comparison, because comparing arrays gives no truth
    value."""
    made: Any = dataclasses.dataclass(frozen=True, eq=False, repr=False, kw_only=True)(cls)
    fields = [(each.name, str(each.type), each.metadata) for each in dataclasses.fields(made)]
    told = [(name, of, more.get("words", ""), more.get("kind", "")) for name, of, more in fields]
    made.__doc__ = _words.with_attributes(made.__doc__, told)
    return made  # type: ignore[no-any-return]


R = TypeVar("R", bound=Result)


def result_of(cls: type[R], document: Mapping[str, Any] | tuple[Any, ...]) -> R:
    """Make a result from a document with attributes by name or in order, and convert the attributes by type.

    A field that only the document or only the class has is an error, so that no field is forgotten.
    """
    made_of: Any = cls  # mypy doubts that a class is hashable.
    makers = _makers(made_of)
    if isinstance(document, tuple):
        document = dict(zip(makers, document, strict=True))
    fields = {name: value for name, value in cls._prepared(document).items() if name not in cls._left_out}
    if fields.keys() != makers.keys():
        extra, missing = sorted(fields.keys() - makers), sorted(makers.keys() - fields)
        raise TypeError(f"{cls.__name__} has no attribute for {extra}, and its document lacks {missing}")
    return cls(**{name: _made(hint, fields[field]) for field, (name, hint) in makers.items()})


@functools.cache
def _makers(cls: Any) -> dict[str, tuple[str, Any]]:
    """Return the types of the attributes, by the names of the attributes in documents."""
    hints = typing.get_type_hints(cls)
    names = [field.name for field in dataclasses.fields(cls)]
    return {cls._documented_as.get(name, name.rstrip("_")): (name, hints[name]) for name in names}


def _made(hint: Any, value: Any) -> Any:
    origin, inside = typing.get_origin(hint), typing.get_args(hint)
    if origin in {typing.Union, types.UnionType}:
        known = [each for each in inside if each is not type(None)]
        return value if value is None or len(known) > 1 else _made(known[0], value)
    if origin is list:
        return [_made(inside[0], each) for each in value]
    if origin is tuple:
        return tuple(value)
    if origin is dict and isinstance(value, list):
        # A list of named items becomes a dictionary by name.
        return {each["name"]: _made(inside[1], each) for each in value}
    if isinstance(hint, type) and issubclass(hint, Result):
        return result_of(hint, value)
    return value


def _items(value: Any) -> list[tuple[str, Any]]:
    return [(field.name, getattr(value, field.name)) for field in dataclasses.fields(value)]


def _plain(value: Any) -> Any:
    if isinstance(value, Result):
        return value.to_dict()
    if isinstance(value, (list, tuple)):
        return type(value)(_plain(each) for each in value)
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    return value


def _within(most: int, begin: str, items: list[str], end: str) -> str:
    """Join items, and leave out the last items if the text would be too long."""
    kept = list(items)
    while kept and len(begin) + len(end) + sum(len(item) + 2 for item in kept) > most:
        kept.pop()
    return begin + ", ".join(kept if len(kept) == len(items) else [*kept, "..."]) + end


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"<{value.dtype} array of {' x '.join(map(str, value.shape))}>"
    if isinstance(value, (list, tuple)) and len(value) > 6:
        return f"<{len(value)} items>"
    if isinstance(value, float):
        return f"{value:.6g}"
    return repr(value)


def _shorter(value: Any) -> str:
    """Return a short form of a value for a list of many values."""
    shown = _short(value)
    if len(shown) <= 40:
        return shown
    if isinstance(value, str):
        return repr(f"{value[:30]}...")
    if isinstance(value, (list, tuple, dict)):
        return f"<{len(value)} item{'s' if len(value) != 1 else ''}>"
    return f"<{type(value).__name__}>"
