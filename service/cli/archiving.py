"""`drumtrue export` and `import`: sessions as files, a session log on every line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from db.documents.base import write_json
from db.documents.session import SessionLog
from service import bootstrap
from service.errors import Conflict, InvalidInput
from service.settings import Settings
from service.usecases import importing, sessions
from service.usecases.work import Work

PAGE = 500
MOST_BYTES = 50_000_000
"""Longest log of one session."""


def export_sessions(wanted: list[str], path: Path, database_url: str | None) -> None:
    """Write logs of the sessions, of all for an empty list; until the file is whole it has another name.

    Raises NotFound, Conflict where the file is there, InvalidInput where it cannot be written.
    """
    if path.exists():
        raise Conflict(
            f"{path} is there already",
            code="file_exists",
            field="FILE",
            value=str(path),
            advice="name another file: an export never replaces one",
        )
    unfinished = path.with_name(path.name + ".unfinished")
    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=False)
    count = 0
    try:
        with unfinished.open("w", encoding="utf-8") as out:
            for key in wanted or _all(work):
                out.write(write_json(sessions.log(work, key)) + "\n")
                count += 1
        unfinished.rename(path)
    except OSError as wrong:
        raise InvalidInput(
            f"cannot write {path}: {wrong}",
            field="FILE",
            value=str(path),
            advice="name a file in a folder that can be written and has room",
        ) from wrong
    finally:
        unfinished.unlink(missing_ok=True)
        work.database.close()
    print(f"{path}: {count} sessions")


def import_sessions(path: Path, database_url: str | None) -> None:
    """Store the sessions of a file, all or none; one that is here already, and the same, stays as it is.

    Raises InvalidInput with the line, Conflict with the session.
    """
    for _ in _logs(path):
        pass  # the whole file is read before the database is touched
    work = bootstrap.build_work(Settings.from_environment(database_url=database_url))
    try:
        done = importing.import_all(work, _logs(path))
    finally:
        work.database.close()
    print(f"{path}: {done.stored} sessions stored, {done.known} were here already")


def _all(work: Work) -> Iterator[str]:
    """All sessions there are, oldest first; those that are opened meanwhile are left out."""
    keys: list[str] = []
    while page := sessions.find(work, PAGE, len(keys)):
        keys += (one.id for one in page)
    yield from reversed(dict.fromkeys(keys))


def _logs(path: Path) -> Iterator[SessionLog]:
    for number, text in _documents(path):
        try:
            yield importing.read_whole_log(text)
        except InvalidInput as wrong:
            said = f"{path}, line {number}: {wrong.message}"
            raise InvalidInput(
                said, code=wrong.code, field=wrong.field, value=wrong.value, advice=wrong.advice
            ) from None


def _documents(path: Path) -> Iterator[tuple[int, bytes]]:
    """Line number and text of each document: one a line, or one over many lines."""
    with path.open("rb") as lines:
        first = lines.readline(MOST_BYTES + 1)
        if not _is_json(first):
            yield 1, _bounded(1, path, first + lines.read(MOST_BYTES + 1 - len(first)))
            return
        number = 1
        while first:
            if first.strip():
                yield number, _bounded(number, path, first)
            first = lines.readline(MOST_BYTES + 1)
            number += 1


def _bounded(number: int, path: Path, text: bytes) -> bytes:
    if len(text) > MOST_BYTES:
        raise InvalidInput(
            f"{path}, line {number}: longer than {MOST_BYTES} bytes",
            code="invalid_log",
            field="FILE",
            advice="give a file that `drumtrue export` wrote: a session log a line",
        )
    return text


def _is_json(text: bytes) -> bool:
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return False
    return True
