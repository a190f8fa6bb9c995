"""Files of session logs: one document, or one on each line as `drumtrue export` writes them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from service.engine.logs.replay import read_log
from service.errors import InvalidInput
from service.messages import Message
from service.model.session import SessionLog

MAX_BYTES = 50_000_000
"""Longest log of one session."""
MAX_LISTED = 20


def documents(path: Path) -> Iterator[tuple[int, bytes]]:
    """Line number and text of each document: one a line, or one over many lines. Raises InvalidInput for a long one."""
    with path.open("rb") as lines:
        first = lines.readline(MAX_BYTES + 1)
        if not first:
            return  # an export of no session
        if not _is_json(first):
            yield 1, _bounded(1, path, first + lines.read(MAX_BYTES + 1 - len(first)))
            return
        number = 1
        while first:
            if first.strip():
                yield number, _bounded(number, path, first)
            first = lines.readline(MAX_BYTES + 1)
            number += 1


def one_log(path: Path, session: str | None) -> SessionLog:
    """The log of a file that holds one, or that of a session among several; session: its identifier.

    Raises InvalidInput for a file that holds none such, or several where none is named, or a log with a broken rule.
    """
    chosen: bytes | None = None
    listed: list[str] = []
    for _, text in documents(path):
        told = _told(text)
        listed.append(" ".join(filter(None, told)))
        if chosen is None and session in (None, told[0]):
            chosen = text
    if chosen is not None and (session is not None or len(listed) == 1):
        return read_log(chosen)
    if not listed:
        return read_log(b"")
    more = [f"(+ {len(listed) - MAX_LISTED})"] if len(listed) > MAX_LISTED else []
    names = "".join(f"\n  {one}" for one in [*listed[:MAX_LISTED], *more])
    raise InvalidInput(
        Message("invalid_log.several", path=path, count=len(listed), names=names)
        if session is None
        else Message("invalid_log.not_among", path=path, count=len(listed), session=session, names=names),
        field="session",
        value=session,
    )


def _told(text: bytes) -> tuple[str, str, str]:
    """What a document says of itself: identifier, machine, and when the session began; empty where it does not."""
    try:
        log: Any = json.loads(text)
        machine, record = log.get("machine"), log.get("record")
        name = machine.get("name") if isinstance(machine, dict) else None
        begun = record.get("created_at") if isinstance(record, dict) else None
        return str(log.get("session_id") or ""), str(name or ""), str(begun or "")
    except (ValueError, RecursionError, AttributeError):
        return "", "no session log", ""


def _bounded(number: int, path: Path, text: bytes) -> bytes:
    if len(text) > MAX_BYTES:
        raise InvalidInput(Message("invalid_log.line_too_long", path=path, line=number, most=MAX_BYTES), field="FILE")
    return text


def _is_json(text: bytes) -> bool:
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return False
    return True
