"""Numbers as the reader's language writes them, and back."""

from __future__ import annotations

import math
import re
from decimal import Decimal

from service.web.language import N_

COMMA = frozenset({"de"})
"""Languages whose decimal sign is the comma."""
NO_BREAK = "\N{NARROW NO-BREAK SPACE}"
MINUS = "\N{MINUS SIGN}"
_PLAIN = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(\.\d{3})+")


class NotANumber(ValueError):
    """What was typed is no number; the text says how one is written."""


def write(value: float | None, language: str, *, digits: int = 3, places: int | None = None) -> str:
    """A number with this many significant digits, or this many decimal places; an em dash for nothing.

    Whole digits are never rounded away: 1234.5 with 3 digits is 1235.
    """
    if value is None or not math.isfinite(value):
        return "\N{EM DASH}"
    if places is None:
        size = math.floor(math.log10(abs(value))) + 1 if value else 1
        places = min(max(digits - size, 0), 9)
    text = f"{value:.{places}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return localised(text, language).replace("-", MINUS)


def plain(value: float | None, language: str) -> str:
    """A number as it is put into a field: as short as it can be, no rounding that shows; empty for nothing."""
    return "" if value is None else localised(format(Decimal(f"{value:.9g}"), "f"), language)


def read(text: str, language: str) -> float:
    """The number that was typed. Raises NotANumber, with a text for the catalogue.

    The decimal sign is the language's own. A point is taken in a comma language too (many keypads have no comma), but
    not where it may be meant to part thousands.
    """
    typed = text.strip().replace(MINUS, "-").replace(NO_BREAK, "")
    if not typed:
        raise NotANumber(N_("Fill in this field."))
    if language in COMMA:
        if _THOUSANDS.fullmatch(typed):
            raise NotANumber(N_("This can be read in two ways. Write it without a point, or with a decimal comma."))
        typed = typed.replace(",", ".")
    elif "," in typed:
        raise NotANumber(N_("Write decimals with a point, such as 3.14."))
    if not _PLAIN.fullmatch(typed) or not typed.isascii():
        raise NotANumber(N_("This is not a number. Use figures only."))
    return float(typed)


def localised(text: str, language: str) -> str:
    """A number's text with the decimal sign of the language."""
    return text.replace(".", ",") if language in COMMA else text
