"""The texts of the pages and their translations; `python -m tests.web.catalogue` brings the catalogues up to date.

New texts are added without a translation, texts that are gone are dropped; `test_language` fails until all are
translated.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_dir
from babel.messages.pofile import read_po, write_po

from service.web.language import DOMAIN, LOCALES

ROOM = LOCALES.parent
ROOT = ROOM.parents[1]
TOLD = (
    "service/api/auth.py",
    "service/balancing/influence/amplitude_only.py",
    "service/balancing/influence/corrections.py",
    "service/balancing/influence/diagnosis/*.py",
    "service/balancing/influence/fit.py",
    "service/balancing/selection/infeasibility.py",
    "service/balancing/selection/objectives.py",
    "service/balancing/influence/saved.py",
    "service/balancing/influence/static_couple.py",
    "service/balancing/rotor/tolerance.py",
    "service/balancing/influence/trial_mass.py",
    "service/balancing/rotor/units.py",
    "service/usecases/access/login_throttle.py",
    "service/usecases/stock/catalogues.py",
    "service/usecases/names.py",
    "service/usecases/plans/corrections.py",
    "service/engine/influence_fits.py",
    "service/usecases/plans/reservations.py",
    "service/usecases/machines/influence.py",
    "service/engine/kept_masses.py",
    "service/usecases/sessions/live.py",
    "service/usecases/access/logins.py",
    "service/usecases/machines/machines.py",
    "service/engine/mapping.py",
    "service/engine/alternatives.py",
    "service/runtime/idempotency.py",
    "service/usecases/plans/plans.py",
    "service/engine/selection_problem.py",
    "service/engine/balance_quality.py",
    "service/engine/validation.py",
    "service/usecases/sessions/runs.py",
    "service/engine/plan_solver.py",
    "service/usecases/sessions/sessions.py",
    "service/engine/plan_methods.py",
    "service/engine/correction_solver.py",
    "service/engine/session_state.py",
    "service/engine/trial_check.py",
    "service/usecases/stock/ledger.py",
    "service/usecases/sessions/stops.py",
    "service/usecases/readings/clocks.py",
    "service/usecases/readings/run_averaging.py",
    "service/usecases/access/tokens.py",
    "service/runtime/solver_slots.py",
    "service/engine/evidence/*.py",
    "service/runtime/context.py",
    "service/web/form_tokens.py",
    "service/web/routers/login.py",
    "service/web/routers/runs.py",
    "service/web/routers/stream.py",
)
SHORTEST = 16
"""Shorter texts are codes and names."""
METHODS = [("templates/**.html", "jinja2"), ("**.py", "python")]
KEYWORDS = {"_": None, "gettext": None, "ngettext": (1, 2), "N_": None}
OPTIONS = {"templates/**.html": {"extensions": "jinja2.ext.do", "trimmed": "true", "silent": "false"}}

HEADER = """\
msgid ""
msgstr ""
"MIME-Version: 1.0\\n"
"Content-Type: text/plain; charset=utf-8\\n"
"Content-Transfer-Encoding: 8bit\\n"
"Plural-Forms: nplurals=2; plural=(n != 1);\\n"

"""


def extracted() -> Catalog:
    """Every text of code and templates."""
    found = Catalog(charset="utf-8")
    for name, line, message, _comments, context in extract_from_dir(ROOM, METHODS, OPTIONS, KEYWORDS):
        found.add(message, None, [(Path(name).as_posix(), line)], context=context)
    for text in said_by_use_cases():
        found.add(text)
    return found


def said_by_use_cases() -> Iterator[str]:
    """What use cases say to a reader: every sentence in the modules of TOLD, {0}, {1} ... where values stand in it."""
    for pattern in TOLD:
        for path in sorted(ROOT.glob(pattern)):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                for value in _said(node):
                    text = _sentence(value)
                    if " " in text and "\n" not in text and len(text) >= SHORTEST:
                        yield text


def _said(node: ast.AST) -> Iterator[ast.expr]:
    """Expressions that may be a text for somebody: arguments, what is returned, yielded or assigned; no docstrings."""
    if isinstance(node, ast.Call):
        yield from node.args
        yield from (keyword.value for keyword in node.keywords)
    elif isinstance(node, ast.Return | ast.Assign | ast.AugAssign | ast.Yield) and node.value is not None:
        yield node.value
    elif isinstance(node, ast.Tuple | ast.List):
        yield from node.elts
    elif isinstance(node, ast.IfExp | ast.BoolOp):
        yield from (node.body, node.orelse) if isinstance(node, ast.IfExp) else node.values


def _sentence(value: ast.expr) -> str:
    if isinstance(value, ast.Constant) and isinstance(value.value, str):
        return value.value.strip("; ")
    if not isinstance(value, ast.JoinedStr):
        return ""
    text, count = "", 0
    for part in value.values:
        if isinstance(part, ast.Constant):
            text += str(part.value)
        else:
            text, count = text + f"{{{count}}}", count + 1
    return text.strip("; ")


def path_of(language: str) -> Path:
    """Where the catalogue of a language lies."""
    return LOCALES / language / "LC_MESSAGES" / f"{DOMAIN}.po"


def stored(language: str) -> Catalog:
    """The catalogue of a language as it lies in the repository."""
    with path_of(language).open("rb") as text:
        return read_po(text, locale=language)


def update(language: str) -> list[str]:
    """Write the catalogue again with today's texts; returns those that still need a translation."""
    path = path_of(language)
    before = {message.id: message.string for message in stored(language) if message.id} if path.is_file() else {}
    catalogue = Catalog(locale=language, charset="utf-8")
    for message in extracted():
        if message.id:
            catalogue.add(message.id, before.get(message.id))
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as text:
        text.write(HEADER.encode())
        write_po(text, catalogue, width=118, sort_output=True, omit_header=True)
    return untranslated(catalogue)


def untranslated(catalogue: Catalog) -> list[str]:
    """Texts without a translation, in all their numbers."""
    return [
        str(m.id) for m in catalogue if m.id and not (all(m.string) if isinstance(m.string, tuple | list) else m.string)
    ]


if __name__ == "__main__":
    for text in update("de"):
        print(f"untranslated: {text}")  # noqa: T201
