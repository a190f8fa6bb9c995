"""Dates in logs: what a date says in any usual form comes back, and what could be two days is refused."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest
from babel.dates import format_datetime
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.can.logs.dates import LANGUAGES, UnknownDate, read_date

MOMENTS = st.integers(0, 3_000_000_000).map(lambda s: datetime(1990, 1, 1, tzinfo=UTC) + timedelta(seconds=s))
NUMERIC = ("%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M:%S", "%Y/%m/%d %H:%M:%S", "%d.%m.%Y %H:%M:%S", "%m/%d/%Y %I:%M:%S %p")


@given(MOMENTS, st.sampled_from(NUMERIC))
def test_dates_in_numbers(moment: datetime, form: str) -> None:
    assert read_date(moment.strftime(form)) == (moment, False)


@given(MOMENTS, st.integers(-14 * 60, 14 * 60))
def test_a_stated_zone_counts(moment: datetime, minutes: int) -> None:
    sign, size = "-" if minutes < 0 else "+", abs(minutes)
    local = moment + timedelta(minutes=minutes)
    assert read_date(f"{local:%Y-%m-%d %H:%M:%S} {sign}{size // 60:02d}:{size % 60:02d}") == (moment, True)


@given(
    MOMENTS,
    st.sampled_from(LANGUAGES.split()),
    st.sampled_from(("EEE MMM d HH:mm:ss yyyy", "EEE MMM d HH:mm:ss.SSS yyyy", "EEEE, d MMMM yyyy HH:mm:ss")),
)
@settings(max_examples=200)
def test_names_of_many_languages(moment: datetime, language: str, form: str) -> None:
    assert read_date(format_datetime(moment, form, locale=language)) == (moment, False)


@pytest.mark.parametrize(
    "text",
    [
        "05/04/2026 08:30:00",
        "Mon Qux 4 08:30:00 2026",
        "Tue May 4 08:30:00 2026",
        "2026-05-04",
        "08:30:00",
        "",
        "31.02.2026 08:30:00",
        "04.05.2026 25:00:00",
    ],
)
def test_what_is_no_date_or_two_is_refused(text: str) -> None:
    with pytest.raises(UnknownDate):
        read_date(text)


@given(st.text(max_size=60))
def test_any_text_is_a_date_or_refused(text: str) -> None:
    try:
        moment, _ = read_date(text)
    except UnknownDate:
        return
    assert moment.tzinfo is UTC
