"""Options that commands share."""

from __future__ import annotations

from typing import Annotated

import typer

DatabaseUrl = Annotated[
    str | None,
    typer.Option(
        "--database-url",
        envvar="DRUMTRUE_DATABASE_URL",
        help="SQLite file (sqlite:///PATH) or PostgreSQL (postgresql+psycopg://...).",
    ),
]
TokenText = Annotated[
    str | None,
    typer.Option(
        "--token",
        envvar="DRUMTRUE_TOKEN",
        show_envvar=True,
        help="Token for the service, where it needs one; better in the environment, where other users do not see it.",
    ),
]
OneSession = Annotated[
    str | None, typer.Option("--session", help="Identifier of the session, of a file that holds several.")
]
