"""What all results have in common."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # Python 3.10 has none.

    def dataclass_transform(**_):
        return lambda cls: cls


__all__: list[str] = []

T = TypeVar("T")


class Result:
    """A result: named attributes that unpack in their order."""

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

    def __repr__(self) -> str:
        inside = ", ".join(f"{name}={_short(value)}" for name, value in _items(self))
        return f"{type(self).__name__}({inside})"


@dataclass_transform(frozen_default=True, eq_default=False, kw_only_default=True)
def result(cls: type[T]) -> type[T]:
    """Make a frozen dataclass of keywords, without comparison, as arrays have none that is true or false."""
    return dataclasses.dataclass(frozen=True, eq=False, repr=False, kw_only=True)(cls)


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


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"<{value.dtype} array of {' x '.join(map(str, value.shape))}>"
    if isinstance(value, (list, tuple)) and len(value) > 6:
        return f"<{len(value)} items>"
    if isinstance(value, float):
        return f"{value:.6g}"
    return repr(value)
