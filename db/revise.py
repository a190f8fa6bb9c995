"""`python -m db.revise "what changes"`: write the migration from the newest revision to the tables in `rows`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from db import migrate
from db.database import Database


def main() -> None:
    """Compare the tables with a freshly migrated database and write the difference."""
    message = " ".join(sys.argv[1:])
    if not message:
        raise SystemExit('say what changes: python -m db.revise "Add ..."')
    with tempfile.TemporaryDirectory() as folder:
        database = Database(f"sqlite:///{Path(folder) / 'revise.db'}")
        migrate.upgrade(database)
        migrate.revise(database, message)
        database.close()


if __name__ == "__main__":
    main()
