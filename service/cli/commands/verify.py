"""`drumtrue verify`: whether the history and the file are whole, and every closed session as it was closed."""

from __future__ import annotations

from sqlalchemy.exc import DatabaseError

from db import backup
from service import bootstrap
from service.cli.support.files import counted
from service.settings import Settings
from service.usecases import audit


def verify_history(database_url: str | None, head: str | None) -> int:
    """Print what a look at an SQLite file's pages and a walk along the chain found; 0 where all is well, else 1."""
    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=False)
    try:
        damage = backup.damage(work.database) if work.database.embedded else None
        if damage:
            print(f"database_damaged: {damage}; have the disk looked at, restore the last backup into a new database")
        try:
            verdict = audit.verify(work, head)
        except DatabaseError as error:
            if not damage:
                raise
            print(f"NOT as it was: the file is damaged, the history cannot be read to its end ({error.orig})")
            return 1
    finally:
        work.database.close()
    for finding in verdict.findings:
        print(f"{finding.code}: {finding.detail}")
    print(f"{verdict.entries} entries, {verdict.sessions} closed sessions, head {verdict.head}")
    if wrong := len(verdict.findings) + bool(damage):
        print(f"NOT as it was: {counted(wrong, 'finding')}")
        return 1
    parts = "the history's chain, the closed sessions, the balances of stock"
    structure = " and the file's structure" if work.database.embedded else ""
    print(f"everything is as it was written: {parts}{structure}")
    return 0
