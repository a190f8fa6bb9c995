"""No sentence stands in the code: errors, findings and results state a message of the catalogue."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.messages.sources import ROOT

NUMERICS = ("service/balancing", "service/optimize", "service/mechanics", "service/design")
ERRORS = (
    "service/errors.py",
    "service/cli/support/client.py",
    "service/chaos/load.py",
    "service/mechanics/refusals.py",
)
FINDINGS = frozenset({"Finding", "Diagnostic", "diagnostic", "SelectionResult", "result_of"})
WORDS = re.compile(r"[A-Za-z]{2,} (?:\S+ )*?[a-z]{2,} (?:\S+ )*?[a-z]{2,}")
"""Three words at least: less is a name, a unit or a formula."""


def errors_of_the_product() -> frozenset[str]:
    """Names of the classes that are raised on purpose."""
    trees = [ast.parse((ROOT / path).read_text(encoding="utf-8")) for path in ERRORS]
    return frozenset(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))


def is_sentence(node: ast.AST) -> bool:
    """Whether an expression is a text with spaces, with values in it or not."""
    parts = [node] if isinstance(node, ast.Constant) else getattr(node, "values", [])
    texts = [part.value for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)]
    return (
        isinstance(node, ast.Constant | ast.JoinedStr) and WORDS.search(" ".join(" ".join(texts).split())) is not None
    )


def docstrings(tree: ast.AST) -> set[int]:
    """Expressions that stand alone: docstrings of modules, classes, functions and attributes."""
    return {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}


def sentences_raised(source: str, names: frozenset[str]) -> Iterator[int]:
    """Lines where one of these is made with a sentence."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in names:
            given = [*node.args, *(keyword.value for keyword in node.keywords if keyword.arg in {"message", "reason"})]
            if any(is_sentence(one) for one in given):
                yield node.lineno


def sentences_anywhere(source: str) -> Iterator[int]:
    """Lines with a sentence that is no docstring and no error of Python's own."""
    tree = ast.parse(source)
    passed = docstrings(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "AttributeError":
            passed |= {id(part) for part in ast.walk(node)}
        if isinstance(node, ast.JoinedStr) and id(node) not in passed:
            passed |= {id(part) for part in node.values}
    for node in ast.walk(tree):
        if id(node) not in passed and is_sentence(node):
            yield node.lineno  # type: ignore[attr-defined]


def files(*rooms: str) -> list[Path]:
    return sorted(path for room in rooms for path in (ROOT / room).rglob("*.py"))


def test_no_error_or_finding_is_made_with_a_sentence() -> None:
    names = errors_of_the_product() | FINDINGS
    assert {"InvalidInput", "Conflict", "Refused", "Refusal"} <= names
    found = [f"{path}:{line}" for path in files("service", "db") for line in sentences_raised(path.read_text(), names)]
    assert found == []


def test_the_numerics_hold_no_sentence() -> None:
    found = [f"{path}:{line}" for path in files(*NUMERICS) for line in sentences_anywhere(path.read_text())]
    assert found == []


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        ('raise Conflict("the box is empty")', [1]),
        ('raise Conflict(f"the box {x} is empty", field="a")', [1]),
        ('result_of(1, reason="the box is empty")', [1]),
        ('raise Conflict(Message("box_empty", box=x), field="a b c")', []),
        ("raise Conflict(message)", []),
    ],
)
def test_a_sentence_in_an_error_is_found(source: str, lines: list[int]) -> None:
    assert list(sentences_raised(source, frozenset({"Conflict", "result_of"}))) == lines


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        ('"""What it is."""\nx = 1\n"""A value of it."""', []),
        ('x = "a word of it"', [1]),
        ('x = f"{a} and {b} of it"', [1]),
        ('x = "g.mm"', []),
        ('raise AttributeError(f"module {a} has no {b}")', []),
    ],
)
def test_a_sentence_anywhere_is_found(source: str, lines: list[int]) -> None:
    assert list(sentences_anywhere(source)) == lines
