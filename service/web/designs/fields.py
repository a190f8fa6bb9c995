"""A design document as a form: fields by groups, each with its unit; what was typed put back into a document."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from service.design.reading import Asked
from service.design.registry import study_of
from service.design.units import PURE, unit_of
from service.web import numbers
from service.web.designs.names import CHOICES, FIELDS, GROUPS, name_of
from service.web.forms import Form
from service.web.language import N_
from service.web.pictures.reader import Reader

Kind = Literal["number", "list", "text", "choice", "flag"]
LEFT_OUT = frozenset({"study", "version", "units", "published"})
"""What a form does not change."""
MAX_IN_ONE = 24
"""Numbers in one field; of a longer nested list each row is a field."""
_STEP = re.compile(r"[^.\[\]]+|\[\d+\]")
_INDEX = re.compile(r"\[\d+\]")
_APART = re.compile(r"[\s;]+")


@dataclass(frozen=True)
class Field:
    """A field of the form. name: its path in the document; value: as it stands there; text: as it is shown."""

    name: str
    label: str
    kind: Kind
    unit: str
    value: Any
    text: str
    choices: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class FieldGroup:
    """Fields that belong together."""

    name: str
    fields: tuple[Field, ...]


def groups(form: Form, document: Mapping[str, Any]) -> tuple[FieldGroup, ...]:
    """The document's fields by group, in its own order. Raises RefusedDesign for a study that is not known."""
    words = Reader(form.preferences)
    asked = study_of(document).asked(document)
    units = document.get("units", {})
    out: dict[str, list[Field]] = {}
    for path, value in _leaves(document, ""):
        group = path.rpartition(".")[0]
        out.setdefault(group, []).append(_field(words, path, value, asked, units if isinstance(units, dict) else {}))
    return tuple(FieldGroup(_group_name(words, name, document), tuple(fields)) for name, fields in out.items())


def changed(form: Form, document: Mapping[str, Any], fields: tuple[FieldGroup, ...]) -> dict[str, Any]:
    """The document with what was typed; a field that was left as it was shown keeps its value to the last digit."""
    made: dict[str, Any] = copy.deepcopy(dict(document))
    for group in fields:
        for one in group.fields:
            typed = form.value(one.name, one.text)
            if typed.strip() != one.text:
                value = _read(form, one, typed)
                if one.name not in form.errors:
                    _put(made, one.name, value)
    return made


def typed_into(form: Form, document: Mapping[str, Any]) -> dict[str, Any]:
    """The document that a form was made from, with what was typed. Raises RefusedDesign for a study not known."""
    return changed(form, document, groups(form, document))


def place_of(path: str | None, fields: tuple[FieldGroup, ...]) -> str:
    """The form's field that holds a path of the document: itself, or the longest that it lies in; else none."""
    names = {one.name for group in fields for one in group.fields}
    while path and path not in names:
        path = path[: max(path.rfind("."), path.rfind("["), 0)]
    return path or ""


def _leaves(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            if path or name not in LEFT_OUT:
                yield from _leaves(inner, f"{path}.{name}" if path else str(name))
    elif isinstance(value, list) and value and all(isinstance(one, Mapping) for one in value):
        for k, inner in enumerate(value):
            yield from _leaves(inner, f"{path}[{k}]")
    elif isinstance(value, list) and any(isinstance(one, list) for one in value) and len(_flat(value)) > MAX_IN_ONE:
        for k, inner in enumerate(value):
            yield f"{path}[{k}]", inner
    else:
        yield path, value


def _flat(value: Any) -> list[Any]:
    return [one for inner in value for one in _flat(inner)] if isinstance(value, list) else [value]


def _field(words: Reader, path: str, value: Any, asked: Mapping[str, Asked], units: Mapping[str, str]) -> Field:
    row = _INDEX.findall(path)[-1][1:-1] if path.endswith("]") else None
    known = asked.get(path if row is None else path[: path.rfind("[")], Asked())
    label = name_of(FIELDS, (path if row is None else path[: path.rfind("[")]).rpartition(".")[2], words.gettext)
    label = label if row is None else f"{label}, {int(row) + 1}"
    unit = unit_of(known.quantity, units) if known.quantity != PURE else ""
    kind: Kind = "text"
    if isinstance(value, bool):
        kind = "flag"
    elif isinstance(value, int | float):
        kind = "number"
    elif isinstance(value, list):
        kind = "list"
    choices: tuple[tuple[str, str], ...] = ()
    if kind == "text" and known.choices:
        kind = "choice"
        choices = tuple((one, name_of(CHOICES, one, words.gettext)) for one in known.choices)
    if kind == "flag":
        choices = (("true", words.gettext(N_("yes"))), ("false", words.gettext(N_("no"))))
    return Field(path, label, kind, unit, value, _text(value, words.preferences.language), choices)


def _text(value: Any, language: str) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return numbers.plain(float(value), language) if abs(value) < 1e15 else str(value)
    if isinstance(value, list):
        return " ".join(_text(one, language) for one in _flat(value))
    return "" if value is None else str(value)


def _read(form: Form, field: Field, typed: str) -> Any:
    """What was typed into a field, of the kind that stands there; a fault is put beside the field."""
    try:
        if field.kind == "number":
            return _number(typed, form.language, whole=isinstance(field.value, int))
        if field.kind == "list":
            return _list(typed, form.language, field.value)
    except numbers.NotANumber as wrong:
        form.wrong(field.name, str(wrong))
        return None
    if field.kind == "flag":
        return typed == "true"
    return typed.strip()


def _number(typed: str, language: str, *, whole: bool = False) -> float | int:
    value = numbers.read(typed, language)
    return int(value) if whole and value == int(value) else value


def _list(typed: str, language: str, before: list[Any]) -> list[Any]:
    """Parts between spaces, in the shape that the list has; a plain list may be of any length."""
    parts = [part for part in _APART.split(typed.strip()) if part]
    flat = _flat(before)
    if any(isinstance(one, str) for one in flat):
        return list(parts)
    read = [_number(part, language, whole=isinstance(old, int)) for part, old in _with_old(parts, flat)]
    if not any(isinstance(one, list) for one in before):
        return read
    if len(read) != len(flat):
        raise numbers.NotANumber(N_("This field needs as many numbers as before."))
    return list(_shaped(before, iter(read)))


def _with_old(parts: list[str], flat: list[Any]) -> Iterator[tuple[str, Any]]:
    for k, part in enumerate(parts):
        yield part, flat[k] if k < len(flat) else (flat[-1] if flat else 0.0)


def _shaped(like: list[Any], values: Iterator[Any]) -> Iterator[Any]:
    for one in like:
        yield list(_shaped(one, values)) if isinstance(one, list) else next(values)


def _put(document: dict[str, Any], path: str, value: Any) -> None:
    steps = [int(step[1:-1]) if step.startswith("[") else step for step in _STEP.findall(path)]
    held: Any = document
    for step in steps[:-1]:
        held = held[step]
    held[steps[-1]] = value


def _group_name(words: Reader, path: str, document: Mapping[str, Any]) -> str:
    """Such as: Link 2, Points of link 2, Disc."""
    plain = _INDEX.sub("", path)
    name = name_of(GROUPS, plain, words.gettext)
    held: Any = document
    called = ""
    for step in _STEP.findall(path):
        held = held[int(step[1:-1])] if step.startswith("[") else held.get(step)
        if isinstance(held, Mapping):
            found = next((held[key] for key in ("name", "link", "joint") if isinstance(held.get(key), str)), "")
            called = found or called
    return f"{name} {called}".strip() if called else name
