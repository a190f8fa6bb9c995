"""Dates as loggers write them: ISO, day first with points, US with slashes, names of months in many languages."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta, timezone
from functools import cache

LANGUAGES = "en de fr it es pt nl sv da nb fi pl cs sk sl hr hu ro tr et lv lt"
EXTRA_MONTHS = {"mrz": 3, "mae": 3, "maerz": 3, "sept": 9}
"""Short names of operating systems that the Unicode locale data do not have."""
_FILLERS = frozenset(("de", "of", "den", "do", "the", "feira"))
YEARS = range(1980, 2200)

_TIME = re.compile(
    r"(?<![\d:])(\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:[.,:](\d{1,9})(?:\.\d{1,3})?)?)?"
    r"(?:\s*(am|pm|a\.m\.|p\.m\.|vorm\.|nachm\.)(?![a-z]))?",
    re.IGNORECASE,
)
_ZONE = re.compile(r"^\s*(?:(Z|UTC|GMT)|([+-])(\d{2}):?(\d{2}))\s*$", re.IGNORECASE)
_NUMBERS = re.compile(
    r"(?<![\d.:])(?:(\d{4})([-./])(\d{1,2})\2(\d{1,2})|(\d{1,2})([-./:])(\d{1,2})\6(\d{4}))(?![\d.:])"
)


class UnknownDate(ValueError):
    """The text is no date in a known form, or it can be read as two different days."""


def read_date(text: str) -> tuple[datetime, bool]:
    """Read a date with a time of day; returns it aware, in UTC, and whether its zone was stated (else taken as UTC).

    Raises `UnknownDate`.
    """
    text = text.strip().replace("T", " ", 1) if re.match(r"\s*\d{4}-\d\d-\d\dT", text) else text.strip()
    date = _NUMBERS.search(text)
    days = _numeric(date, text) if date else None
    rest = text if date is None else text[: date.start()] + " " + text[date.end() :]
    clock = _TIME.search(rest)
    if clock is None:
        raise UnknownDate(f"{text[:60]!r} has no time of day")
    zone, stated = _zone(rest[clock.end() :])
    if days is None:
        days = _named(rest[: clock.start()] + " " + rest[clock.end() :])
    if len(days) != 1:
        what = "can be read as two different days" if days else "has no date in a known form"
        raise UnknownDate(f"{text[:60]!r} {what}")
    moment = days.pop() + _of_day(clock)
    return moment.replace(tzinfo=zone).astimezone(UTC), stated


def _zone(text: str) -> tuple[timezone, bool]:
    found = _ZONE.match(text)
    if found is None:
        return UTC, False
    if found.group(1):
        return UTC, True
    offset = timedelta(hours=int(found.group(3)), minutes=int(found.group(4)))
    if offset >= timedelta(hours=24):
        raise UnknownDate(f"zone {text.strip()!r} is more than a day")
    return timezone(offset if found.group(2) == "+" else -offset), True


def _of_day(clock: re.Match[str]) -> timedelta:
    hour, minute, second = (int(one or 0) for one in clock.group(1, 2, 3))
    half = (clock.group(5) or "").lower()
    if hour > 23 or minute > 59 or second > 60 or (half and not 1 <= hour <= 12):
        raise UnknownDate(f"{clock.group(0)!r} is no time of day")
    if half:
        hour = hour % 12 + 12 * half.startswith(("p", "n"))
    fraction = float(f"0.{clock.group(4) or 0}")
    return timedelta(hours=hour, minutes=minute, seconds=second, microseconds=round(fraction * 1e6))


def _numeric(found: re.Match[str], text: str) -> set[datetime]:
    """Days that three numbers can mean: year first; else day first, with slashes or dashes month first as well."""
    first, _, second, third, one, mark, two, year = found.groups()
    if first is not None:
        orders = [(first, second, third)]
    elif mark in "/-":
        first, second, third = one, two, year
        orders = [(third, second, first), (third, first, second)]
        if mark == "/" and re.search(r"\d\s*[ap]m\b", text, re.IGNORECASE):
            orders = orders[1:]  # AM and PM go with the month first
    else:
        orders = [(year, two, one)]
    return {day for order in orders if (day := _day(*(int(part) for part in order))) is not None}


def _day(year: int, month: int, day: int) -> datetime | None:
    try:
        return datetime(year, month, day) if year in YEARS else None  # noqa: DTZ001  (its zone follows)
    except ValueError:
        return None


def _named(text: str) -> set[datetime]:
    """Days that a day, a year and names of a month and a weekday can mean; names of one language each."""
    numbers = re.findall(r"(?<!\d)\d{1,4}(?!\d)", text)
    years = [int(one) for one in numbers if len(one) == 4]
    days = [int(one) for one in numbers if len(one) <= 2]
    words = [word for one in re.findall(r"[^\W\d_]{2,}", text) if (word := _plain(one)) not in _FILLERS]
    if len(years) != 1 or len(days) != 1 or not 1 <= len(words) <= 2:
        return set()
    for whole in (True, False):  # first as the languages write them, then cut short as some systems do
        found = {_fitting(years[0], month, days[0], words) for month in _months(words[-1], whole)} - {None}
        if found:
            return {one for one in found if one is not None}
    return set()


def _fitting(year: int, month: tuple[str, int], day: int, words: list[str]) -> datetime | None:
    language, number = month
    found = _day(year, number, day)
    if found is None or len(words) == 1:
        return found
    weekdays = _names(language)[1]
    return found if any(_is(words[0], name) for name in weekdays[found.weekday()]) else None


def _months(word: str, whole: bool) -> Iterator[tuple[str, int]]:
    """Languages and months that a word names, as a whole or by its first letters."""
    if word in EXTRA_MONTHS:
        yield "de", EXTRA_MONTHS[word]
    for language in LANGUAGES.split():
        for month, names in enumerate(_names(language)[0], start=1):
            if word in names if whole else any(_is(word, name) for name in names):
                yield language, month


def _is(word: str, name: str) -> bool:
    return name == word or (len(word) >= 2 and name.startswith(word))


@cache
def _names(language: str) -> tuple[list[set[str]], list[set[str]]]:
    """Names of the months and of the weekdays from Monday, from the Unicode locale data."""
    from babel import Locale  # only logs with names in them pay for it

    locale = Locale(language)
    found = []
    for table, numbers in ((locale.months, range(1, 13)), (locale.days, range(7))):
        found.append([{_plain(table["format"][width][one]) for width in ("wide", "abbreviated")} for one in numbers])
    return found[0], found[1]


def _plain(name: str) -> str:
    """Lower case, without accents and points."""
    spread = unicodedata.normalize("NFKD", name.casefold())
    return "".join(one for one in spread if one.isalpha() and not unicodedata.combining(one))
