"""`drumtrue export` and `import`: sessions as files, a session log on every line."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from service import bootstrap
from service.cli.support.files import counted, writing
from service.cli.support.log_files import documents
from service.errors import Conflict, InvalidInput
from service.messages import Message
from service.model.base import write_json
from service.model.session import SessionLog
from service.runtime.context import AppContext
from service.settings import Settings
from service.usecases.sessions import log_import, sessions

PAGE = 500


def export_sessions(wanted: list[str], path: Path, database_url: str | None) -> int:
    """Write logs of the sessions, of all for an empty list; until the file is whole it has another name.

    A session of which a part cannot be read is left out and named: 1 then, else 0. Raises NotFound, Conflict where the
    file is there, InvalidInput where it cannot be written.
    """
    unfinished = path.with_name(path.name + ".unfinished")
    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=False)
    count = 0
    left_out: list[str] = []
    try:
        with writing(path, "export"):
            with unfinished.open("w", encoding="utf-8") as out:
                for key in wanted or _all(work):
                    text, why = _whole_log(work, key)
                    if text is None:
                        left_out.append(why)
                    else:
                        out.write(text + "\n")
                        count += 1
            unfinished.rename(path)
    finally:
        unfinished.unlink(missing_ok=True)
        work.database.close()
    print(f"{path}: {counted(count, 'session')}")
    for line in left_out:
        print(f"left out: {line}", file=sys.stderr)
    if left_out:
        print("what to do: run `drumtrue repair`; GET /sessions/{id}/log has what can be read", file=sys.stderr)
    return 1 if left_out else 0


def _whole_log(work: AppContext, key: str) -> tuple[str | None, str]:
    """The log of a session as text; None, and why, where a part of it cannot be read."""
    try:
        log = sessions.log(work, key)
    except Conflict as wrong:
        if wrong.code != "row_unreadable":
            raise
        return None, f"session {key}: {wrong.message}"
    if log.unreadable:
        parts = "; ".join(f"{part.kind} {part.number} cannot be read ({part.field})" for part in log.unreadable)
        return None, f"session {key}: {parts}"
    return write_json(log), ""


def import_sessions(path: Path, database_url: str | None) -> None:
    """Store the sessions of a file, all or none; one that is here already, and the same, stays as it is.

    Raises InvalidInput with the line, Conflict with the session.
    """
    for _ in _logs(path):
        pass  # the whole file is read before the database is touched
    work = bootstrap.build_work(Settings.from_environment(database_url=database_url))
    try:
        done = log_import.import_all(work, _logs(path))
    finally:
        work.database.close()
    print(f"{path}: {counted(done.stored, 'session')} stored, {done.known} here already")


def _all(work: AppContext) -> Iterator[str]:
    """All sessions there are, oldest first; those that are opened meanwhile are left out."""
    keys: list[str] = []
    while page := sessions.find(work, PAGE, len(keys)):
        keys += (one.id for one in page)
    yield from reversed(dict.fromkeys(keys))


def _logs(path: Path) -> Iterator[SessionLog]:
    for number, text in documents(path):
        try:
            yield log_import.read_whole_log(text)
        except InvalidInput as wrong:
            message = Message("invalid_log.at_line", path=path, line=number, cause=wrong.data)
            raise InvalidInput(message, code=wrong.code, field=wrong.field, value=wrong.value) from None
