"""Every text of the pages is translated, and numbers are read and written as the language does it."""

from __future__ import annotations

import re
import string

import pytest

from service.web import numbers
from service.web.preferences import LANGUAGES, Preferences
from tests.web.catalogue import extracted, stored, untranslated

OTHERS = sorted(set(LANGUAGES) - {"en"})


def texts(value: object) -> tuple[str, ...]:
    return tuple(value) if isinstance(value, tuple | list) else (str(value),)


@pytest.mark.parametrize("language", OTHERS)
def test_every_text_is_in_the_catalogue_and_translated(language: str) -> None:
    catalogue = stored(language)
    wanted, have = ({str(m.id) for m in one if m.id} for one in (extracted(), catalogue))
    assert wanted == have, "bring the catalogue up to date: python -m tests.web.catalogue"
    assert untranslated(catalogue) == []
    assert len(wanted) > 50


@pytest.mark.parametrize("language", OTHERS)
def test_translations_fill_in_the_same_values(language: str) -> None:
    for message in stored(language):
        if not message.id:
            continue
        wanted = {frozenset(re.findall(r"%\(\w+\)[sd]|\{\d*\}", text)) for text in texts(message.id)}
        for text in texts(message.string):
            assert frozenset(re.findall(r"%\(\w+\)[sd]|\{\d*\}", text)) in wanted, message.id


@pytest.mark.parametrize(
    ("header", "language"),
    [
        (None, "en"),
        ("", "en"),
        ("de", "de"),
        ("de-AT,de;q=0.9,en;q=0.8", "de"),
        ("fr, en;q=0.4, de;q=0.5", "de"),
        ("en-GB,de", "en"),
        (";;;q=,,🙂", "en"),
    ],
)
def test_the_language_is_the_best_one_accepted(header: str | None, language: str) -> None:
    assert Preferences.read(None, header).language == language


def test_a_cookie_goes_before_the_header_and_nonsense_in_it_is_passed_over() -> None:
    chosen = Preferences(language="de", mass="oz", detection="peak")
    assert Preferences.read(chosen.cookie(), "en") == chosen
    assert Preferences.read("language=xx&mass=%00&theme=dark&__class__=x", "de") == Preferences("de", "dark")


@pytest.mark.parametrize(
    ("typed", "language", "value"),
    [
        ("3.14", "en", 3.14),
        (" 12 ", "en", 12.0),
        ("\N{MINUS SIGN}5", "en", -5.0),
        (".5", "en", 0.5),
        ("3,14", "de", 3.14),
        ("3.14", "de", 3.14),
        ("1250", "de", 1250.0),
        ("+0,001", "de", 0.001),
    ],
)
def test_numbers_are_read_as_the_language_writes_them(typed: str, language: str, value: float) -> None:
    assert numbers.read(typed, language) == value


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    "typed", ["", "  ", "🙂", "3 g", "1e5", "nan", "inf", "0x10", "1_000", "--1", "٣", "1.2.3", "1,2,3"]
)
def test_what_is_no_number_is_refused_in_words(typed: str, language: str) -> None:
    with pytest.raises(numbers.NotANumber):
        numbers.read(typed, language)


def test_a_comma_is_refused_where_it_parts_thousands_and_a_point_where_it_may() -> None:
    for typed, language in (("3,14", "en"), ("1,250", "en"), ("1.250", "de"), ("12.345.678", "de")):
        with pytest.raises(numbers.NotANumber):
            numbers.read(typed, language)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0.00"), (-0.0001, "\N{MINUS SIGN}0.000100"), (1234.5, "1234"), (0.012345, "0.0123"), (9.996, "10.00")],
)
def test_numbers_are_written_with_three_digits_that_say_something(value: float, text: str) -> None:
    assert numbers.write(value, "en") == text
    assert numbers.write(value, "de") == text.replace(".", ",")


def test_what_is_put_into_a_field_is_read_back_as_the_same_number() -> None:
    for language in LANGUAGES:
        for value in (0.0, 1.5, -12.25, 460.0, 1e-6, 0.1 + 0.2, 1234567.0):
            assert numbers.read(numbers.plain(value, language), language) == pytest.approx(value, rel=1e-8)


def test_no_text_is_put_together_from_pieces_with_format_signs_left_over() -> None:
    for message in extracted():
        for text in texts(message.id):
            assert "%" not in re.sub(r"%\(\w+\)[sd]|%%| %", "", text), text
            # Texts without a value are not filled in: braces in them are shown as they are.
            places = string.Formatter().parse(text) if "{0}" in text else ()
            assert all(name is None or name.isdigit() or name == "" for _, name, _, _ in places)
