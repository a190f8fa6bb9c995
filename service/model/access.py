"""Tokens, and what they let their bearer do."""

from __future__ import annotations

from datetime import datetime
from typing import Literal, get_args

from service.model.base import document

Scope = Literal["admin", "bridge", "read", "technician"]
SCOPES: tuple[Scope, ...] = get_args(Scope)


@document
class Token:
    """A token as it is listed: never its secret, which is stored nowhere."""

    id: str
    """First part of the token's text, by which it is found."""
    name: str
    """Who or what bears it; history names it."""
    scopes: tuple[Scope, ...]
    """What it lets its bearer do."""
    created_at: datetime
    """When it was created, UTC."""
    expires_at: datetime | None
    """When it ends to be good, UTC; null: never."""
    revoked_at: datetime | None
    """When it was revoked, UTC."""
