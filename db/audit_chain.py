"""The hash chain of the history, and the digest of a closed session's record. Format 1; both must never change.

Canonical JSON follows RFC 8785 in spirit: keys in order, no spaces, UTF-8, no NaN. Two things differ: keys are ordered
by code points, and numbers are written as Python does, the shortest text that reads back the same. Times are ISO 8601
in UTC with microseconds. An entry's hash is SHA-256 over the canonical JSON of the entry and of the hash before it. A
record is what the tables hold, text of documents parsed, or as it is where it is no JSON: a migration must not rewrite
documents of closed sessions.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Text, select, type_coerce
from sqlalchemy.orm import Session

from db.rows import Base
from db.types import Document

FORMAT = 1
BEGIN = "0" * 64
"""What the first entry takes for the hash before it."""
ENTRY = ("number", "at", "actor", "action", "kind", "key", "session_id", "changes")
_RECORD: Mapping[str, tuple[str, ...]] = {
    "session": (
        *("id", "machine_id", "machine_name", "machine", "catalogue_id", "state", "technician", "note", "run_out"),
        *("on_rotor", "fitted_plan_id", "created_at", "closed_at", "version"),
    ),
    "run": ("id", "number", "run"),
    "correction": ("id", "number", "correction"),
    "plan": ("id", "number", "plan"),
    "stop": ("id", "number", "stop"),
    "stock_entry": ("catalogue_id", "item", "kind", "pieces", "held", "plan_id", "until", "at"),
}


def canonical(value: object) -> str:
    """Canonical JSON text of dictionaries, lists, texts, numbers, times. Raises ValueError for NaN and Infinity."""
    return json.dumps(
        value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False, default=_plain_time
    )


def digest(value: object) -> str:
    """SHA-256 of the canonical JSON, in hexadecimal."""
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def link(before: str, entry: Mapping[str, Any]) -> str:
    """Hash of an entry (its `ENTRY` fields) after the entry whose hash is `before`."""
    return digest([FORMAT, before, {name: entry[name] for name in ENTRY}])


def record_digest(session: Session, session_id: str) -> str | None:
    """Digest of all that is stored of a session; None where there is no such session."""
    record = {}
    for name, columns in _RECORD.items():
        table = Base.metadata.tables[name]
        owner = table.c.id if name == "session" else table.c.session_id
        texts = {column for column in columns if isinstance(table.c[column].type, Document)}
        chosen = [type_coerce(table.c[c], Text).label(c) if c in texts else table.c[c] for c in columns]
        found = session.execute(select(*chosen).where(owner == session_id).order_by(table.c.id)).mappings()
        record[name] = [{c: parsed(row[c]) if c in texts else row[c] for c in columns} for row in found]
    return digest([FORMAT, record]) if record["session"] else None


def parsed(text: str) -> Any:
    """The value of a JSON text that has a canonical form; else the text: a damaged document has a digest too."""
    try:
        value = json.loads(text, parse_constant=_finite, parse_float=_finite)
        if "\\ud" in text.lower():
            canonical(value).encode()  # half of a surrogate pair has no UTF-8
        return value
    except (ValueError, RecursionError):
        return text


def _finite(number: str) -> float:
    value = float(number)
    if not math.isfinite(value):
        raise ValueError(f"{number} has no canonical JSON")
    return value


def _plain_time(value: object) -> str:
    if isinstance(value, datetime):
        return value.astimezone(UTC).isoformat(timespec="microseconds")
    raise ValueError(f"{value!r} has no canonical JSON")
