"""What a person can put right."""

from __future__ import annotations

__all__: list[str] = []


class Refused(Exception):
    """Something that is not done; the message states why, and the remedy."""
