"""Forms: what was typed, read into words and numbers. A fault stands beside its field; what was typed is kept.

A field carries the name of the document's field that it fills, such as `readings[0].amplitude`, so that what a use case
refuses finds its place too.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Annotated

from fastapi import Depends, Request

from service.errors import DrumtrueError
from service.web import numbers
from service.web.display import Display
from service.web.language import N_, translations
from service.web.preferences import Preferences
from service.web.sentences import advice_of, message_of
from service.web.units import DEGREES, Unit

MAX_FIELDS = 4000
LONGEST = 20_000
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_APART = re.compile(r"[\t\n\r]")
_WITH_UNIT = re.compile(r"(.*\d[.,]?)\s*([^\d\s.,][^\d.,]{0,11}(?:-?[12])?)")
AS_TYPED = Unit("", 1.0)


class Form:
    """One form of a page: first empty or filled by the page, later as it was typed."""

    def __init__(self, values: Mapping[str, str] | None = None, preferences: Preferences | None = None) -> None:
        self.values = dict(values or {})
        self.preferences = preferences or Preferences()
        self.language = self.preferences.language
        self.errors: dict[str, str] = {}

    @property
    def ok(self) -> bool:
        """Nothing is wrong so far."""
        return not self.errors

    @property
    def general(self) -> str | None:
        """What is wrong with the form as a whole."""
        return self.errors.get("")

    def value(self, name: str, otherwise: str = "") -> str:
        """What stands in a field."""
        return self.values.get(name, otherwise)

    def error(self, name: str) -> str | None:
        """What is wrong with a field."""
        return self.errors.get(name)

    def ticked(self, name: str) -> bool:
        """Whether a box is ticked."""
        return bool(self.values.get(name))

    def wrong(self, name: str, message: str, **values: object) -> None:
        """Put a fault beside a field; the first one stays."""
        found = translations(self.language).gettext(message)
        self.errors.setdefault(name, found % values if values else found)

    def refused(self, error: DrumtrueError) -> None:
        """Put what a use case refuses beside the field that it names, else above the form."""
        show = Display(self.preferences)
        text = " ".join(_sentence(part) for part in (message_of(error, show), advice_of(error, show)) if part)
        self.errors.setdefault(error.field if error.field in self.values else "", text)

    # ------------------------------------------------------------ reading
    def text(self, name: str, *, required: bool = False, most: int = 100, listed: bool = False) -> str | None:
        """A line of text, spaces at its ends cut off; None where it is empty. A list may be parted by tabs or lines."""
        text = self.values.get(name, "").strip()
        text = _APART.sub(" ", text) if listed else text
        if not text:
            if required:
                self.wrong(name, N_("Fill in this field."))
            return None
        if len(text) > most:
            self.wrong(name, N_("At most %(most)s characters; these are %(count)s."), most=most, count=len(text))
        if _CONTROL.search(text):
            self.wrong(name, N_("This holds signs that cannot be shown. Type it again."))
        return text

    def number(
        self,
        name: str,
        *,
        low: float | None = None,
        high: float | None = None,
        above: float | None = None,
        unit: Unit = AS_TYPED,
        required: bool = True,
    ) -> float | None:
        """A number in the stored unit, typed in `unit` or with a unit of its own; limits are stored ones too.

        None where it is empty or wrong.
        """
        typed = self.values.get(name, "")
        if not typed.strip() and not required:
            return None
        figure, sign = _parted(typed) if unit.others else (typed, "")
        size = unit.size_of(sign) if sign else unit.size
        if size is None:
            known = ", ".join(dict.fromkeys(one for one, _ in ((unit.sign, 1.0), *unit.others)))
            self.wrong(name, N_("“%(sign)s” is no unit for this field. It takes: %(known)s."), sign=sign, known=known)
            return None
        try:
            value = size * numbers.read(figure, self.language)
        except numbers.NotANumber as wrong:
            self.wrong(name, str(wrong))
            return None
        bounds = {"low": low, "high": high, "above": above}
        plain = {k: numbers.plain(None if v is None else unit.show(v), self.language) for k, v in bounds.items()}
        shown = {k: text.replace("-", numbers.MINUS) for k, text in plain.items()}
        if above is not None and not value > above:
            self.wrong(name, N_("This must be more than %(above)s."), **shown)
        elif (low is not None and value < low) or (high is not None and value > high):
            if low is not None and high is not None:
                self.wrong(name, N_("This must lie between %(low)s and %(high)s."), **shown)
            elif low is not None:
                self.wrong(name, N_("This must be at least %(low)s."), **shown)
            else:
                self.wrong(name, N_("This must be at most %(high)s."), **shown)
        return value

    def angle(self, name: str, *, required: bool = True) -> float | None:
        """An angle or a phase in degrees: any within a turn either way."""
        return self.number(name, low=-360.0, high=360.0, unit=DEGREES, required=required)

    def whole(self, name: str, *, low: int, high: int, required: bool = True) -> int | None:
        """A whole number. None where it is empty or wrong."""
        value = self.number(name, low=low, high=high, required=required)
        if value is None or name in self.errors:
            return None
        if value != int(value):
            self.wrong(name, N_("This must be a whole number."))
            return None
        return int(value)

    def choice(self, name: str, options: Iterable[str], *, required: bool = True) -> str | None:
        """One of the options of a list."""
        value = self.values.get(name, "")
        if not value and not required:
            return None
        if value not in set(options):
            self.wrong(name, N_("Choose one of the list."))
            return None
        return value


async def typed_fields(request: Request) -> dict[str, str]:
    """Fields of a form that was sent, as text; of several of one name the last."""
    async with request.form(max_fields=MAX_FIELDS, max_files=0) as form:
        return {
            name: value.encode("utf-8", "replace").decode()[:LONGEST]
            for name, value in form.multi_items()
            if isinstance(value, str)
        }


TypedDep = Annotated[dict[str, str], Depends(typed_fields)]


def _parted(typed: str) -> tuple[str, str]:
    """A number and the sign of the unit behind it, empty where there is none."""
    found = _WITH_UNIT.fullmatch(typed.strip())
    return (found[1], found[2]) if found else (typed, "")


def _sentence(text: str) -> str:
    text = text.strip()
    return text[:1].upper() + text[1:] + ("" if text[-1:] in ".!?" else ".") if text else ""
