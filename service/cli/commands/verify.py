"""`drumtrue verify`: whether the history and the file are whole, and every closed session as it was closed."""

from __future__ import annotations

from sqlalchemy.exc import DatabaseError

from db import backup
from service import bootstrap
from service.cli.support.files import counted
from service.cli.support.heads import Heads
from service.settings import Settings
from service.usecases import audit

COVERED = (
    "the history's chain; closed sessions; machines, boxes, open sessions, runs, corrections, plans, stops, learned "
    "coefficients, sources, tokens, balancers' answers; the stock's ledger and balances; readings by batch"
)
NOT_COVERED = (
    "rows from before the upgrade to digests, until then; lines of readings, and readings rewritten with their line; "
    "findings beside readings; rolled-up minutes; logins; keys of requests; counters of frames"
)


def verify_history(database_url: str | None, head: str | None, heads: Heads | None = None) -> int:
    """Print what a look at an SQLite file's pages and a comparison with the history found; 0 where all is well, else 1.

    heads: file whose last head must be on the chain, and which gets the present one where all is well.
    """
    if heads is not None:
        head = head or heads.last()
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
    if heads is not None:
        heads.append(verdict.head, work.now())
    structure = "; the file's structure" if work.database.embedded else ""
    print(f"everything is as it was written: {COVERED}{structure}")
    print(f"not compared: {NOT_COVERED}")
    return 0
