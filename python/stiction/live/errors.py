"""Errors that a user can correct."""

from __future__ import annotations

import re

__all__: list[str] = []


class Refused(Exception):
    """A refusal. The message states the reason and the remedy."""


def redacted(url: str) -> str:
    """Return an address without the password."""
    return re.sub(r"(?i)([?&;][a-z_ ]*(?:password|pwd)\s*=)[^&;]*", r"\1", re.sub(r"(://[^:/@]*):.*@", r"\1@", url))


def refuse_password(url: str, variable: str) -> None:
    """Refuse an address with a password.

    The whole text is searched, because a slash in the password would end the host part of a parsed address.
    """
    if redacted(url) != url:
        raise Refused(f"the address holds a password; give it in the environment as {variable}")
