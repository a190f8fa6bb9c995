"""The commands on what is stored: migrate, verify, backup, restore, retain, export, import."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.cli.support.options import DatabaseUrl


def migrate(database_url: DatabaseUrl = None) -> None:
    """Bring the database's schema up to date, keeping the data."""
    from service import bootstrap
    from service.settings import Settings

    before, after = bootstrap.migrate_database(Settings.from_environment(database_url=database_url))
    print(f"schema {before or 'empty'} -> {after}" if before != after else f"schema {after}: up to date")


def verify(
    head: Annotated[
        str | None, typer.Option(help="NUMBER:HASH that an earlier check printed: shows that no end was cut off.")
    ] = None,
    head_to: Annotated[
        Path | None,
        typer.Option(dir_okay=False, help="File of heads: its last must be on the chain, the present is added."),
    ] = None,
    head_key: Annotated[
        Path | None, typer.Option(exists=True, dir_okay=False, help="Key that signs the lines of the file of heads.")
    ] = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Compare all that is stored with the history; say what was altered, removed or inserted (status 1)."""
    from service.cli.commands.verify import verify_history
    from service.cli.support.heads import Heads, key_from

    if head_key is not None and head_to is None:
        raise typer.BadParameter("it signs a file of heads: name one with --head-to", param_hint="--head-key")
    heads = None if head_to is None else Heads(head_to, key_from(head_key))
    raise SystemExit(verify_history(database_url, head, heads))


def repair(
    only_list: Annotated[bool, typer.Option("--list", help="Only list what cannot be read; change nothing.")] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """List what is stored and cannot be read; mend what needs no guess, with a line of history (status 1: not all)."""
    from service.cli.commands.repair import repair_database

    raise SystemExit(repair_database(database_url, mend=not only_list))


def backup(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="New file, an SQLite database whatever the engine.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Write all that is stored, as of one moment, to a file; the service may go on meanwhile."""
    from service.cli.commands.backup import back_up_to

    back_up_to(file, database_url)


def restore(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A file that `drumtrue backup` wrote.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Put a backup into an empty database, of either engine."""
    from service.cli.commands.backup import restore_from

    restore_from(file, database_url)


def retain(
    days: Annotated[int, typer.Option(min=1, help="Days for which raw readings are kept.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Roll up older raw readings, one row a source, sensor and minute; what runs took of them stays."""
    from service.cli.commands.backup import retain_for

    retain_for(days, database_url)


def export(
    to: Annotated[Path, typer.Option("--to", dir_okay=False, help="New file, JSON Lines: a session log a line.")],
    session: Annotated[list[str] | None, typer.Argument(help="Identifiers of sessions.")] = None,
    every: Annotated[bool, typer.Option("--all", help="All sessions there are.")] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """Write sessions to a file that `import` stores elsewhere and, one session, `solve` solves again."""
    from service.cli.commands.transfer import export_sessions

    if every == bool(session):
        raise typer.BadParameter("name sessions, or --all", param_hint="SESSION")
    raise SystemExit(export_sessions(session or [], to, database_url))


def import_(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A file that `drumtrue export` wrote.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Store the sessions of a file, all or none; machines and boxes are found by name or created, stock stays."""
    from service.cli.commands.transfer import import_sessions

    import_sessions(file, database_url)
