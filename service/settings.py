"""Settings of a running service: from the command line, else the environment, else the defaults here."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from service.errors import InvalidInput
from service.messages import Message

DEFAULT_DATABASE = Path.home() / ".local" / "share" / "drumtrue" / "drumtrue.db"


@dataclass(frozen=True)
class Settings:
    """What a deployment may choose.

    database_url: SQLAlchemy address; SQLite file or PostgreSQL (`postgresql+psycopg://...`). max_body_bytes: longest
    request body. max_readings: longest list of readings in one request. loopback: the service listens on an address
    of this machine alone, and answers without a token until one is created. trusted_proxies: addresses and networks,
    with commas between, whose X-Forwarded-For and X-Forwarded-Proto are believed; none if empty. solves: selections
    that are computed at once; None: one a core. retain_days: raw readings are rolled up after this many; None: never.
    max_ahead_s: readings dated further ahead of the moment at which they come are set apart.
    """

    database_url: str = f"sqlite:///{DEFAULT_DATABASE}"
    max_body_bytes: int = 4 * 1024 * 1024
    max_readings: int = 10_000
    loopback: bool = False
    trusted_proxies: str = ""
    solves: int | None = None
    retain_days: int | None = None
    max_ahead_s: float = 60.0

    @property
    def shown(self) -> str:
        """The address of the database without its password."""
        return re.sub(r"(?<=://)([^:/@]*):[^@/]*@", r"\1:***@", self.database_url)

    @staticmethod
    def from_environment(environment: Mapping[str, str] = os.environ, *, database_url: str | None = None) -> Settings:
        """Settings from `DRUMTRUE_DATABASE_URL`, unless stated, and `DRUMTRUE_TRUSTED_PROXIES`.

        Raises InvalidInput for an empty address; an empty variable is none.
        """
        url = environment.get("DRUMTRUE_DATABASE_URL") or None if database_url is None else database_url
        if url is not None and not url.strip():
            raise InvalidInput(Message("invalid_input.database_address_empty"), field="database_url", value=url)
        settings = Settings(trusted_proxies=environment.get("DRUMTRUE_TRUSTED_PROXIES", ""))
        return settings if url is None else replace(settings, database_url=url)
