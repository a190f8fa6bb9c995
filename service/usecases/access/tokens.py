"""Tokens: who may do what over HTTP.

A token's text is shown once, when it is created, and stored nowhere.

The text is `dt_ID_SECRET`. A row is found by ID; what is stored of SECRET is its SHA-256. A slow hash guards secrets
that people choose, of which a list can be tried; this one is 160 bits from the operating system, which no list holds,
and a slow hash would cost every request what it costs a guesser.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime

from pydantic import ValidationError

from db.rows import TokenRow
from service.errors import Conflict, InvalidInput, NotFound, Unauthorized
from service.messages import Message
from service.model.access import SCOPES, Scope, Token
from service.model.base import Name, adapter
from service.runtime.context import AppContext

LETTERS = "0123456789abcdefghjkmnpqrstvwxyz"
"""Crockford's 32: none is read for another when a token is typed in."""
ID_LETTERS, SECRET_LETTERS = 8, 32
_TEXT = re.compile(f"dt_([{LETTERS}]{{{ID_LETTERS}}})_([{LETTERS}]{{{SECRET_LETTERS}}})")


@dataclass(frozen=True)
class Principal:
    """Who asks, and what they may do; token_id: None where no token is needed."""

    name: str
    scopes: frozenset[Scope]
    token_id: str | None


LOCAL = Principal(name="local", scopes=frozenset(SCOPES), token_id=None)
"""Anyone at the machine itself, as long as no token was created."""


def create(
    work: AppContext, name: str, scopes: Collection[Scope], expires_at: datetime | None = None
) -> tuple[Token, str]:
    """A new token and its text, to be shown once. Raises as `check`, or Conflict for a name used before."""
    now = work.now()
    name = check(name, scopes, expires_at, now)
    token_id, secret = _letters(ID_LETTERS), _letters(SECRET_LETTERS)
    with work.write() as store:
        if store.token_named(name) is not None:
            raise _name_taken(name)
        row = TokenRow(
            id=token_id,
            name=name,
            scopes=tuple(sorted(set(scopes))),
            digest=digest_of(secret),
            created_at=now,
            expires_at=expires_at,
            revoked_at=None,
        )
        if not store.added(row):
            raise _name_taken(name)
        return _view(row), f"dt_{token_id}_{secret}"


def _name_taken(name: str) -> Conflict:
    return Conflict(Message("name_taken.token", name=name), field="name", value=name)


def check(name: str, scopes: Collection[Scope], expires_at: datetime | None, now: datetime) -> str:
    """The name, if a token may be created so as far as can be told without looking what is stored, or InvalidInput."""
    name = _checked_name(name)
    for scope in scopes:
        if scope not in SCOPES:
            raise InvalidInput(
                Message("invalid_input.unknown_scope", scope=scope, scopes=SCOPES), field="scope", value=scope
            )
    if not scopes:
        raise InvalidInput(Message("invalid_input.no_scope", scopes=SCOPES), field="scope")
    if expires_at is not None and expires_at <= now:
        raise InvalidInput(Message("invalid_input.expires_past", time=expires_at.isoformat()), field="expires")
    return name


def find(work: AppContext) -> tuple[Token, ...]:
    """All tokens, oldest first, those that are not good any more among them."""
    with work.read() as store:
        return tuple(_view(row) for row in store.tokens())


def revoke(work: AppContext, name: str) -> Token:
    """End a token, and every login made with it, from the next request on; again is harmless. Raises NotFound."""
    with work.write() as store:
        row = store.token_named(name) or store.get(TokenRow, name)
        if row is None:
            raise NotFound(Message("not_found.token", name=name), field="name", value=name)
        row.revoked_at = row.revoked_at or work.now()
        store.end_logins(token_id=row.id)
        return _view(row)


def needed(work: AppContext) -> bool:
    """Whether a token was ever created; revoked ones count, or revoking the last would open the service to all."""
    with work.read() as store:
        return store.any_token()


def bearer(work: AppContext, text: str) -> Principal:
    """Who bears this token. Raises Unauthorized, which tells why only to those who have its secret."""
    parts = split(text)
    if parts is None:
        raise unknown()
    token_id, secret = parts
    with work.read() as store:
        row = store.get(TokenRow, token_id)
        digest = "" if row is None else row.digest
        if not hmac.compare_digest(digest, digest_of(secret)) or row is None:
            raise unknown()
        return principal_of(row, work.now())


def principal_of(row: TokenRow, now: datetime) -> Principal:
    """The bearer of a token whose secret was right. Raises Unauthorized where it is revoked or over."""
    if row.revoked_at is not None:
        raise Unauthorized(Message("token_revoked", name=row.name, time=row.revoked_at.isoformat()))
    if row.expires_at is not None and row.expires_at <= now:
        raise Unauthorized(Message("token_expired", name=row.name, time=row.expires_at.isoformat()))
    return Principal(name=row.name, scopes=frozenset(row.scopes), token_id=row.id)


def split(text: str) -> tuple[str, str] | None:
    """A token's identifier and secret, as typed in capitals or with blanks around; None for what is no token."""
    found = _TEXT.fullmatch(text.strip().lower())
    return None if found is None else (found[1], found[2])


def digest_of(secret: str) -> str:
    """SHA-256 of a secret, hexadecimal."""
    return hashlib.sha256(secret.encode()).hexdigest()


def unknown() -> Unauthorized:
    """The error for what is no token of this service."""
    return Unauthorized(Message("token_unknown"))


def _letters(count: int) -> str:
    return "".join(secrets.choice(LETTERS) for _ in range(count))


def _checked_name(name: str) -> str:
    try:
        checked: str = adapter(Name).validate_python(name)
    except ValidationError as wrong:
        raise InvalidInput(
            Message("invalid_input.token_name", name=name[:100], rule=wrong.errors()[0]["msg"]),
            field="name",
            value=name,
        ) from None
    return checked


def _view(row: TokenRow) -> Token:
    return Token(
        id=row.id,
        name=row.name,
        scopes=row.scopes,
        created_at=row.created_at,
        expires_at=row.expires_at,
        revoked_at=row.revoked_at,
    )
