"""Checks of arguments, by name."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable
from typing import Any, cast

__all__: list[str] = []


def number(name: str, value: Any) -> float:
    """Return `value` as a float, or raise an error if `value` is not a number."""
    if isinstance(value, (str, bytes)):
        raise TypeError(f"{name} must be a number, but its type is {type(value).__name__}")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a number, but its type is {type(value).__name__}") from None


def positive(name: str, value: Any) -> float:
    """Return `value` as a finite float above 0."""
    found = number(name, value)
    if not 0 < found < math.inf:
        raise ValueError(f"{name} is {found:g}, but must be a finite number above 0")
    return found


def at_least_zero(name: str, value: Any) -> float:
    """Return `value` as a finite float of at least 0."""
    found = number(name, value)
    if not 0 <= found < math.inf:
        raise ValueError(f"{name} is {found:g}, but must be a finite number of at least 0")
    return found


def integer(name: str, value: Any, least: int = 0) -> int:
    """Return `value` as an int of at least `least`."""
    try:
        whole = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, but its type is {type(value).__name__}") from None
    if whole < least:
        raise ValueError(f"{name} is {whole}, but must be at least {least}")
    return whole


def optional(name: str, value: Any) -> float | None:
    """Return `value` as a float, or None unchanged."""
    return None if value is None else number(name, value)


def text(name: str, value: Any) -> str:
    """Return `value`, or raise an error if `value` is not text."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a string, but its type is {type(value).__name__}")
    return value


def choice(name: str, value: Any, known: Iterable[str]) -> str:
    """Return `value`, or raise an error if it is not one of `known`."""
    known = list(known)
    if text(name, value) not in known:
        raise ValueError(f"{name} is {value!r}, but must be one of {', '.join(map(repr, known))}")
    return str(value)


def callback(name: str, value: Any) -> Callable[[int], object] | None:
    """Return `value`, or raise an error if it is neither callable nor None."""
    if value is not None and not callable(value):
        raise TypeError(f"{name} must be callable, but its type is {type(value).__name__}")
    return cast("Callable[[int], object] | None", value)


def instance(name: str, value: Any, *kinds: type) -> Any:
    """Return `value`, or raise an error if it is neither None nor of one of the `kinds`."""
    if value is None or isinstance(value, kinds):
        return value
    wanted = " or ".join(kind.__name__ for kind in kinds)
    hint = "; give an object, not its class" if isinstance(value, type) else ""
    raise TypeError(f"{name} must be {wanted}, but its type is {type(value).__name__}{hint}")
