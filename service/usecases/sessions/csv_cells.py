"""Cells of a CSV file that a spreadsheet shows as the text they are."""

from __future__ import annotations

STARTS = ("=", "+", "-", "@", "\t", "\r", "\n")
"""What a spreadsheet takes for the start of a formula (OWASP, CSV injection)."""


def safe_cell(value: object) -> object:
    """The value; a text that a spreadsheet would run as a formula gets an apostrophe before it, numbers stay."""
    if isinstance(value, str) and value.lstrip(" ").startswith(STARTS):
        return f"'{value}"
    return value
