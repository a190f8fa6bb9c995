"""TOML by hand: the line of a key in a file, for error messages, and texts as they are written."""

from __future__ import annotations

import json
import re

_HEADER = re.compile(r"^\s*\[(\[)?\s*([A-Za-z0-9_-]+)\s*\]?\]\s*(#.*)?$")
_KEY = re.compile(r"^\s*([A-Za-z0-9_-]+)\s*=")

Where = tuple[str, int, str]
"""Table, its place among tables of this name, key."""


def lines_of(text: str) -> dict[Where, int]:
    """Line of every key and table header, counted from 1; a header's key is empty."""
    found: dict[Where, int] = {}
    table, index = "", 0
    counts: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if header := _HEADER.match(line):
            table = header.group(2)
            index = counts[table] = counts.get(table, -1) + 1
            found[table, index, ""] = number
        elif key := _KEY.match(line):
            found.setdefault((table, index, key.group(1)), number)
    return found


def quoted(text: str) -> str:
    """A text as TOML writes it."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
