"""Tokens, logins, and requests that are done once."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta

from sqlalchemy import delete, func, select
from sqlalchemy.exc import IntegrityError

from db.queries.base import Queries
from db.rows import IdempotencyRow, LoginRow, TokenRow
from db.set_apart import readable

NEWEST_KEYS = 1000
"""This many keys of requests are kept even when their time is over."""


class Access(Queries):
    """Who may ask, and what was answered to whom."""

    def tokens(self) -> Sequence[TokenRow]:
        """All tokens, oldest first."""
        return readable(self._session.scalars(select(TokenRow).order_by(TokenRow.created_at, TokenRow.id)).all())

    def token_named(self, name: str) -> TokenRow | None:
        """The token of this name."""
        return self._session.scalars(select(TokenRow).where(TokenRow.name == name)).one_or_none()

    def any_token(self) -> bool:
        """Whether a token was ever created."""
        return self._session.scalar(select(TokenRow.id).limit(1)) is not None

    def end_logins(
        self, *, login_id: str | None = None, token_id: str | None = None, before: datetime | None = None
    ) -> None:
        """Forget logins: one, those of a token, or those that ended by themselves before a moment."""
        for column, value in ((LoginRow.id, login_id), (LoginRow.token_id, token_id)):
            if value is not None:
                self._session.execute(delete(LoginRow).where(column == value))
        if before is not None:
            self._session.execute(delete(LoginRow).where(LoginRow.expires_at < before))

    def claim(self, row: IdempotencyRow, now: datetime) -> bool:
        """Store a key that no one has; another unit of work that is about to store it is waited for.

        False where it is taken. Some keys whose time is over are forgotten first. No key may end early because a clock
        was set: its time ends after that of every key before it, and the newest are kept whatever the clock says.
        """
        end = IdempotencyRow.expires_at
        newest = select(end).order_by(end.desc()).offset(NEWEST_KEYS).limit(1).scalar_subquery()
        over = select(IdempotencyRow.id).where(end <= now, end <= newest).order_by(end, IdempotencyRow.id)
        old = over.limit(100).with_for_update(skip_locked=True)
        self._session.execute(delete(IdempotencyRow).where(IdempotencyRow.id.in_(old)))
        if self._session.get(IdempotencyRow, row.id) is not None:
            return False
        latest = self._session.scalar(select(func.max(end)))
        if latest is not None:
            row.expires_at = max(row.expires_at, latest + timedelta(microseconds=1))
        self._session.add(row)
        try:
            self._session.flush()
        except IntegrityError:
            return False
        return True
