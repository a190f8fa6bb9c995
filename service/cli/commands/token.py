"""`drumtrue token`: who may use the service over HTTP."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Annotated

import typer

from service.errors import InvalidInput
from service.messages import Message

if TYPE_CHECKING:
    from service.runtime.context import AppContext

app = typer.Typer(help="Tokens: who may use the service over HTTP.", no_args_is_help=True)

DatabaseUrl = Annotated[
    str | None,
    typer.Option("--database-url", envvar="DRUMTRUE_DATABASE_URL", help="Database of the service."),
]
_LONG = {"h": timedelta(hours=1), "d": timedelta(days=1)}


@app.command()
def create(
    name: Annotated[str, typer.Argument(help="Who or what will bear it; history names it.")],
    scope: Annotated[
        list[str],
        typer.Option(
            help="technician: balance; bridge: send readings, answers and blocks, nothing else; read: look; "
            "admin: everything. May be given again."
        ),
    ],
    expires: Annotated[str, typer.Option(help="90d, 12h, or a time such as 2027-01-31; default: never.")] = "",
    quiet: Annotated[bool, typer.Option("--quiet", help="Print the token and nothing else.")] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """Create a token and show it, this once. From the first one on, every request needs one."""
    from service.runtime.context import utc_now
    from service.usecases.access import tokens

    until = expiry(expires, utc_now())
    # Refused before a database is opened, which may make one.
    tokens.check(name, scope, until, utc_now())  # type: ignore[arg-type]
    with _working(database_url, create=True) as work:
        token, text = tokens.create(work, name, scope, until)  # type: ignore[arg-type]
    print(text)
    if not quiet:
        end = f", good until {token.expires_at:%Y-%m-%d %H:%M} UTC" if token.expires_at else ""
        print(f"for {token.name!r}, scope {' '.join(token.scopes)}{end}. It is stored nowhere: keep it now.")


@app.command("list")
def list_tokens(database_url: DatabaseUrl = None) -> None:
    """List the tokens, without their secrets."""
    from rich.console import Console
    from rich.table import Table

    from service.usecases.access import tokens

    with _working(database_url) as work:
        table = Table("id", "name", "scope", "created", "good until", "revoked")
        for token in tokens.find(work):
            times = (token.created_at, token.expires_at, token.revoked_at)
            table.add_row(token.id, token.name, " ".join(token.scopes), *map(_shown, times))
    Console(highlight=False).print(table)


@app.command()
def revoke(
    name: Annotated[str, typer.Argument(help="Name or id of the token.")], database_url: DatabaseUrl = None
) -> None:
    """Revoke a token: the next request with it is refused, and its logins are over."""
    from service.usecases.access import tokens

    with _working(database_url) as work:
        token = tokens.revoke(work, name)
    print(f"{token.name!r} revoked at {_shown(token.revoked_at)}")


def expiry(text: str, now: datetime) -> datetime | None:
    """The time that `90d`, `12h` or a date states; None for an empty text. Raises InvalidInput."""
    if not text:
        return None
    if found := re.fullmatch(r"(\d{1,5})([hd])", text):
        return now + int(found[1]) * _LONG[found[2]]
    try:
        stated = datetime.fromisoformat(text)
    except ValueError:
        raise InvalidInput(Message("invalid_input.expires", text=text), field="expires", value=text) from None
    return stated if stated.tzinfo else stated.replace(tzinfo=UTC)


def _shown(time: datetime | None) -> str:
    return "-" if time is None else f"{time:%Y-%m-%d %H:%M} UTC"


@contextmanager
def _working(database_url: str | None, *, create: bool = False) -> Iterator[AppContext]:
    from service import bootstrap
    from service.settings import Settings

    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=create)
    try:
        yield work
    finally:
        work.database.close()
