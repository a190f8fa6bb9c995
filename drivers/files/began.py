"""When a recording began, as far as its file says: in a header of text, a column of times, or a field of its own."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime

from drivers.can.logs.dates import UnknownDate, read_date

EARLIEST = datetime(1990, 1, 1, tzinfo=UTC)
LATEST = datetime(2100, 1, 1, tzinfo=UTC)
MAX_LINES = 100
_KEYS = re.compile(r"\b(date|time|start|begin|began|created|record|datum|zeit|beginn|fecha|hora|data|heure)", re.I)
_DATE, _TIME = (
    re.compile(r"^\W*(date|datum|fecha|data)\b(.*)$", re.I),
    re.compile(r"^\W*(time|zeit|hora|heure)\b(.*)$", re.I),
)


def moment_of(text: str) -> datetime | None:
    """The date and time of day in a text, aware, in UTC; None where there is none, or no likely one."""
    try:
        found, _ = read_date(re.sub(r"[\t;]+|,(?!\d)|(?<!\d),", " ", text.strip().strip('"')))
    except (UnknownDate, ValueError, OverflowError):
        return None
    return found if EARLIEST <= found <= LATEST else None


def moment_of_seconds(seconds: float) -> datetime | None:
    """Seconds since 1970, if they are those of a likely moment."""
    return datetime.fromtimestamp(seconds, UTC) if EARLIEST.timestamp() <= seconds <= LATEST.timestamp() else None


def moment_in(lines: Sequence[str]) -> datetime | None:
    """The moment that a header states: in one line that speaks of time, or in one of date and one of time."""
    date = time = ""
    for line in lines[:MAX_LINES]:
        if not _KEYS.search(line):
            continue
        if found := moment_of(line.partition(":")[2]) or moment_of(line):
            return found
        date = date or (_DATE.match(line) or ["", "", ""])[2]
        time = time or (_TIME.match(line) or ["", "", ""])[2]
    return moment_of(f"{date.strip(' :=')} {time.strip(' :=')}") if date and time else None
