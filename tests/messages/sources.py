"""Messages as the code makes them: keys with the names of their parameters, read from the source text."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
MAKERS = frozenset({"Message"})


@dataclass(frozen=True)
class Made:
    """A message made at a place of the code. names: of its parameters; None where `**` hands on others."""

    key: str
    names: frozenset[str] | None
    place: str


def made_in(source: str, place: str) -> Iterator[Made]:
    """Every message of a source text, both of a conditional key."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and _is(node.func, {"partial"}) and node.args and _is(node.args[0], MAKERS):
            yield from (Made(key, None, f"{place}:{node.lineno}") for key in _keys(node.args[1]))
        elif isinstance(node, ast.Call) and _is(node.func, MAKERS) and node.args:
            names = [keyword.arg for keyword in node.keywords]
            known = None if None in names else frozenset(name for name in names if name is not None)
            for key in _keys(node.args[0]):
                yield Made(key, known, f"{place}:{node.lineno}")


def all_made() -> list[Made]:
    """Every message of the product."""
    files = sorted(path for room in ("service", "db") for path in (ROOT / room).rglob("*.py"))
    return [one for path in files for one in made_in(path.read_text(encoding="utf-8"), str(path.relative_to(ROOT)))]


def _is(node: ast.expr, names: Collection[str]) -> bool:
    return isinstance(node, ast.Name) and node.id in names


def _keys(node: ast.expr) -> Iterator[str]:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.IfExp):
        yield from _keys(node.body)
        yield from _keys(node.orelse)
