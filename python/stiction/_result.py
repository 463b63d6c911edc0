"""What all results have in common."""

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
"""Characters that a prompt shows of a result: five lines."""


class Result:
    """A result: named attributes that unpack in their order."""

    _documented_as: ClassVar[Mapping[str, str]] = {}
    """What attributes are called in documents, where that is not their name."""
    _left_out: ClassVar[Mapping[str, str]] = {}
    """Fields of documents that are no attributes, and why."""

    @classmethod
    def _prepared(cls, document: Mapping[str, Any]) -> Mapping[str, Any]:
        """Give a document the shape of the attributes, where `result_of` cannot."""
        return document

    def to_dict(self) -> dict[str, Any]:
        """Give the result as plain values.

        Returns
        -------
        dict
            Attributes by name, results in it as dictionaries, arrays as they are.
        """
        return {name: _plain(value) for name, value in _items(self)}

    def __iter__(self) -> Iterator[Any]:
        return (value for _, value in _items(self))

    def _summary(self) -> list[str]:
        """What a prompt shows of a large result, at most five lines; of others nothing, so that it shows the attributes."""
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
    """Say what an attribute is; one without words shares those of the next. Its kind is that of its type by default."""
    return dataclasses.field(default=default, metadata={"words": words, "kind": kind})


@dataclass_transform(frozen_default=True, eq_default=False, kw_only_default=True, field_specifiers=(about,))
def result(cls: type[T]) -> type[T]:
    """Make a frozen dataclass of keywords, without comparison, as arrays have none that is true or false."""
    made: Any = dataclasses.dataclass(frozen=True, eq=False, repr=False, kw_only=True)(cls)
    fields = [(each.name, str(each.type), each.metadata) for each in dataclasses.fields(made)]
    told = [(name, of, more.get("words", ""), more.get("kind", "")) for name, of, more in fields]
    made.__doc__ = _words.with_attributes(made.__doc__, told)
    return made  # type: ignore[no-any-return]


R = TypeVar("R", bound=Result)


def result_of(cls: type[R], document: Mapping[str, Any]) -> R:
    """Make a result of its document: attributes by name, what is in them by their types.

    A field that only one of document and class has is an error, so that none is forgotten.
    """
    made_of: Any = cls  # mypy doubts that a class is hashable.
    makers = _makers(made_of)
    fields = {name: value for name, value in cls._prepared(document).items() if name not in cls._left_out}
    if fields.keys() != makers.keys():
        extra, missing = sorted(fields.keys() - makers), sorted(makers.keys() - fields)
        raise TypeError(f"{cls.__name__} has no attribute for {extra}, and its document lacks {missing}")
    return cls(**{name: _made(hint, fields[field]) for field, (name, hint) in makers.items()})


@functools.cache
def _makers(cls: Any) -> dict[str, tuple[str, Any]]:
    """Give the attributes and their types by their names in documents."""
    hints = typing.get_type_hints(cls)
    names = [field.name for field in dataclasses.fields(cls)]
    return {cls._documented_as.get(name, name.rstrip("_")): (name, hints[name]) for name in names}


def _made(hint: Any, value: Any) -> Any:
    origin, inside = typing.get_origin(hint), typing.get_args(hint)
    if origin in {typing.Union, types.UnionType}:
        [known] = [each for each in inside if each is not type(None)]
        return None if value is None else _made(known, value)
    if origin is list:
        return [_made(inside[0], each) for each in value]
    if origin is tuple:
        return tuple(value)
    if origin is dict and isinstance(value, list):
        # What has a name is found by it.
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
    """Join items, leaving out the last ones where it would be longer."""
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
    """Give what stands for a value where there are many."""
    shown = _short(value)
    if len(shown) <= 40:
        return shown
    if isinstance(value, str):
        return repr(f"{value[:30]}...")
    if isinstance(value, (list, tuple, dict)):
        return f"<{len(value)} item{'s' if len(value) != 1 else ''}>"
    return f"<{type(value).__name__}>"
