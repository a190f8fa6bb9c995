"""A message as a sentence in a reader's language and units."""

from __future__ import annotations

import string
from collections.abc import Mapping

from service.messages.catalogue import SOURCE, Text, entry, word
from service.messages.message import Message, Parameter, Part, Quantity, Word

_PARSER = string.Formatter()
_CONVERTED = ".4g"
"""Digits of a quantity that is shown in another unit than it is stored in."""


class Reader:
    """How values are written in English, in the units that are stored; a page's reader overrides it."""

    gap = " "
    """Between a number and its unit."""

    @property
    def language(self) -> str:
        """The language of the texts."""
        return SOURCE

    def in_unit(self, value: float, unit: str) -> tuple[float, str]:
        """A stored quantity in the reader's unit, with that unit's sign."""
        return value, unit

    def figure(self, text: str) -> str:
        """A number with the reader's decimal sign."""
        return text


ENGLISH = Reader()


def render(message: Message, reader: Reader = ENGLISH) -> str:
    """The message's sentence, without capital letter and full stop; its key where the catalogue does not know it."""
    found = entry(message.key, reader.language)
    return message.key if found is None else _filled(found.message, message.parameters, reader)


def render_advice(message: Message, reader: Reader = ENGLISH) -> str | None:
    """What to do about it; None where the catalogue has no advice."""
    found = entry(message.key, reader.language)
    return None if found is None or found.advice is None else _filled(found.advice, message.parameters, reader)


def _filled(text: Text, parameters: Mapping[str, Parameter], reader: Reader) -> str:
    out = []
    for before, name, spec, _ in _PARSER.parse(_form(text, parameters, reader.language)):
        out.append(before)
        if name is not None:
            # A stored message may be older than its text: the value it lacks is left open.
            out.append(_shown(parameters[name], spec or "", reader) if name in parameters else "?")
    return "".join(out)


def _form(text: Text, parameters: Mapping[str, Parameter], language: str) -> str:
    count = parameters.get("count")
    if not text.plural or not isinstance(count, int | float):
        return text.forms["other"]
    # Imported here: few texts count anything.
    from babel import Locale

    return text.forms.get(Locale.parse(language).plural_form(count), text.forms["other"])


def _shown(value: Parameter, spec: str, reader: Reader) -> str:
    """A value as the text asks for it.

    spec: of a number; of a list `and`, `or`, `,`, `;` or `()`, then its items' after `|`; `advice` of a message.
    """
    if isinstance(value, tuple):
        joint, _, inner = spec.partition("|")
        return _listed([_shown(one, inner, reader) for one in value], joint or "and", reader.language)
    if isinstance(value, bool) or value is None:
        return word("word", {True: "true", False: "false", None: "none"}[value], reader.language)
    if isinstance(value, int | float):
        return _number(value, spec, reader)
    if isinstance(value, Quantity):
        return _quantity(value, spec, reader)
    if isinstance(value, Word):
        return word("word", value.name, reader.language)
    if isinstance(value, Part):
        return _part(value, reader)
    if isinstance(value, Message):
        return (render_advice(value, reader) or "") if spec == "advice" else render(value, reader)
    return value


def _number(value: float, spec: str, reader: Reader) -> str:
    return reader.figure(format(value, spec or ("" if isinstance(value, int) else "g")))


def _quantity(value: Quantity, spec: str, reader: Reader) -> str:
    shown, unit = reader.in_unit(value.value, value.unit)
    digits = spec or ("g" if unit == value.unit else _CONVERTED)
    return f"{reader.figure(format(shown, digits))}{reader.gap}{word('unit', unit, reader.language)}"


def _part(part: Part, reader: Reader) -> str:
    kind = f"{part.kind}_{'numbered' if part.name is None else 'named'}{'' if part.note is None else '_noted'}"
    values = {"number": str(part.number), "name": part.name or "", "note": _shown(part.note, "", reader)}
    return word("part", kind, reader.language).format_map(values)


def _listed(items: list[str], joint: str, language: str) -> str:
    """`a`, `a and b`, `a, b and c`; with `or` in place of `and`; `a, b, c`; `(a, b, c)`."""
    if joint == "()":
        return f"({', '.join(items)}{',' * (len(items) == 1)})"
    if joint in {",", ";"} or len(items) < 2:
        return f"{joint} ".join(items) or word("list", "empty", language)
    return f"{', '.join(items[:-1])} {word('list', joint, language)} {items[-1]}"
