"""The reference of codes is that of today."""

from __future__ import annotations

from tests.messages.codes import PATH, written


def test_the_reference_of_codes_is_up_to_date() -> None:
    assert PATH.read_text(encoding="utf-8") == written(), "write it again: python -m tests.messages.codes"
