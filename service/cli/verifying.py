"""`drumtrue verify`: whether the history is whole, and every closed session as it was closed."""

from __future__ import annotations

from service import bootstrap
from service.settings import Settings
from service.usecases import history


def verify_history(database_url: str | None, head: str | None) -> int:
    """Print what a walk along the chain found; 0 where nothing is wrong, else 1."""
    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=False)
    try:
        verdict = history.verify(work, head)
    finally:
        work.database.close()
    for finding in verdict.findings:
        print(f"{finding.code}: {finding.detail}")
    print(f"{verdict.entries} entries, {verdict.sessions} closed sessions, head {verdict.head}")
    print(f"NOT as it was: {len(verdict.findings)} findings" if verdict.findings else "everything is as it was written")
    return 1 if verdict.findings else 0
