"""Names that must be unique: machines, boxes."""

from __future__ import annotations

from service.errors import Conflict


def name_taken(noun: str, name: str) -> Conflict:
    """The error for a name that is used already."""
    return Conflict(
        f"there is a {noun} named {name!r} already",
        code="name_taken",
        field="name",
        value=name,
        advice=f"use that {noun}, or choose another name",
    )
