"""Logins of browsers: a token typed in once, a cookie until it ends, is ended, or its token is."""

from __future__ import annotations

import secrets
from datetime import timedelta

from db.rows import LoginRow, TokenRow
from service.errors import Unauthorized
from service.messages import Message
from service.runtime.context import AppContext
from service.usecases.access import tokens
from service.usecases.access.tokens import Principal

LASTS = timedelta(hours=12)
"""A shift; then the token is asked for again."""
_SECRET_BYTES = 32


def log_in(work: AppContext, token: str) -> str:
    """The secret for a cookie that is good for LASTS. Raises Unauthorized where the token is not good."""
    principal = tokens.bearer(work, token)
    secret, now = secrets.token_urlsafe(_SECRET_BYTES), work.now()
    with work.write() as store:
        store.end_logins(before=now)
        store.add(
            LoginRow(
                id=tokens.digest_of(secret),
                token_id=principal.token_id,
                created_at=now,
                expires_at=now + LASTS,
            )
        )
    return secret


def log_out(work: AppContext, secret: str) -> None:
    """End a login; what is none is passed over."""
    with work.write() as store:
        store.end_logins(login_id=tokens.digest_of(secret))


def logged_in(work: AppContext, secret: str) -> Principal:
    """Who logged in with this cookie. Raises Unauthorized where the login is over, or its token is."""
    now = work.now()
    with work.read() as store:
        login = store.get(LoginRow, tokens.digest_of(secret))
        token = None if login is None else store.get(TokenRow, login.token_id)
        if login is None or token is None or login.expires_at <= now:
            raise Unauthorized(Message("login_over"))
        return tokens.principal_of(token, now)
