"""The texts of each language: `texts/<language>/*.toml`, one table for each key with `message` and `advice`.

A text names its values in braces: {sensor}, {share:.0%}. `message = { one = "...", other = "..." }` has a form for each
plural of the language, chosen by the parameter `count`. The tables `word` and `unit` hold plain texts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

TEXTS = Path(__file__).parent / "texts"
SOURCE = "en"
"""The language that every text has."""
ENGLISH_ONLY = frozenset({"arrays", "terminal"})
"""Files whose texts reach callers in Python and readers at the command line, never a page."""
FIELDS = frozenset({"message", "advice"})
_PLAIN = frozenset({"word", "unit", "part", "list"})
"""Tables of plain texts, which other texts are put together from."""


@dataclass(frozen=True)
class Text:
    """A text by plural category (CLDR: one, other, ...); `other` is there always."""

    forms: Mapping[str, str]

    @property
    def plural(self) -> bool:
        """Whether a form must be chosen."""
        return len(self.forms) > 1


@dataclass(frozen=True)
class Entry:
    """What stands under a key."""

    message: Text
    advice: Text | None = None


@cache
def entries(language: str, name: str = "*") -> Mapping[str, Entry]:
    """Every text of a language, or of one of its files, by its key; empty for a language that has none."""
    # Imported here: a command that says nothing needs no texts.
    import tomllib

    found: dict[str, Entry] = {}
    for path in sorted((TEXTS / language).glob(f"{name}.toml")):
        for key, entry in _entries(tomllib.loads(path.read_text(encoding="utf-8"))):
            if key in found:
                raise ValueError(f"{path.name}: the key {key} must be used once, got it again")
            found[key] = entry
    return found


def entry(key: str, language: str) -> Entry | None:
    """The texts under a key, in English where the language has none; None for an unknown key."""
    return entries(language).get(key) or entries(SOURCE).get(key)


def word(table: str, name: str, language: str) -> str:
    """A plain text, such as `word.trial`; the name itself where there is none."""
    found = entry(f"{table}.{name}", language)
    return name if found is None else found.message.forms["other"]


def _entries(tables: Mapping[str, Any]) -> Iterator[tuple[str, Entry]]:
    for code, table in tables.items():
        if code in _PLAIN:
            yield from ((f"{code}.{name}", Entry(_text(text))) for name, text in table.items())
            continue
        if FIELDS & table.keys():
            yield code, _entry(table)
        yield from ((f"{code}.{name}", _entry(inner)) for name, inner in table.items() if name not in FIELDS)


def _entry(table: Mapping[str, Any]) -> Entry:
    return Entry(_text(table["message"]), _text(table["advice"]) if "advice" in table else None)


def _text(value: str | Mapping[str, str]) -> Text:
    return Text({"other": value} if isinstance(value, str) else dict(value))
