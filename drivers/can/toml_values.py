"""Values of a mapping file: taken from its tables, or refused with the line they are on."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from drivers.errors import InvalidSetting
from drivers.files.toml_lines import Where


class TomlValues:
    """The tables of one file. name: of the file, for errors. lines: where its keys stand."""

    def __init__(self, data: dict[str, Any], lines: dict[Where, int], name: str) -> None:
        self.data, self._lines, self._name = data, lines, name

    def tables(self, name: str) -> list[Any]:
        """The tables of a name that is written in double brackets."""
        value = self.data.get(name, [])
        if not isinstance(value, list):
            raise self.wrong((name, 0, ""), f"is [{name}]: write [[{name}]], one for each")
        return value

    def only(self, table: Any, known: Iterable[str], where: Where) -> None:
        """Raise for what is no table, and for an unknown key."""
        if not isinstance(table, dict):
            raise self.wrong(where, f"is {table!r}: write a table")
        for key in table:
            if key not in known:
                raise self.wrong(where, f"has the unknown key {key!r}: use {', '.join(sorted(known))}", key)

    def text(self, table: Any, key: str, where: Where, *default: None) -> Any:
        """A text that is not empty; default: None where it may be left out."""
        value = table.get(key) if isinstance(table, dict) else None
        if value is None and default:
            return None
        if not isinstance(value, str) or not value:
            raise self.wrong(where, f"has {key} {value!r}: state a text", key)
        return value

    def name_of(self, table: Any, key: str, where: Where) -> str:
        """A name that a reading can hold."""
        name = self.text(table, key, where)
        if len(name) > 100:
            raise self.wrong(where, f"has a {key} of {len(name)} characters: 100 are the most", key)
        return str(name)

    def number(self, table: Any, key: str, where: Where, default: float) -> float:
        """A number above 0."""
        value = table.get(key, default) if isinstance(table, dict) else default
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < 1e6:
            raise self.wrong(where, f"has {key} {value!r}: state a number above 0", key)
        return float(value)

    def choice(self, table: Any, key: str, known: tuple[str, ...], where: Where, default: str | None = None) -> str:
        """One of the known texts."""
        value = table.get(key, known[0] if default is None else default) if isinstance(table, dict) else None
        if value not in known and not (value == "" and key not in table):
            raise self.wrong(where, f"has {key} {value!r}: use one of {', '.join(known)}", key)
        return str(value)

    def wrong(self, where: Where, what: str, key: str = "") -> InvalidSetting:
        """The error for what is wrong at a place: with file and line."""
        table, index, own_key = where
        places = [(table, index, own_key or key), (table, index, own_key), (table, index, ""), (key, 0, "")]
        line = next((self._lines[place] for place in places if place in self._lines), None)
        label = " ".join(part for part in (f"[{table}]" if table else "", own_key) if part)
        return InvalidSetting(f"{self._name}{f', line {line}' if line else ''}: {label + ' ' if label else ''}{what}")
