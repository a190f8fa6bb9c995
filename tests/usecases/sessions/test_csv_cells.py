"""No text that somebody typed runs in a spreadsheet."""

from __future__ import annotations

import csv
import io

import pytest

from service.usecases.sessions.csv_cells import safe_cell


@pytest.mark.parametrize(
    "text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "\n=1", " =cmd|' /C calc'!A0", '=HYPERLINK("x")', "-"]
)
def test_a_formula_becomes_text(text: str) -> None:
    out = io.StringIO()
    csv.writer(out).writerow([safe_cell(text), "next"])
    cell, after = next(csv.reader(io.StringIO(out.getvalue(), newline="")))
    assert (cell, after) == ("'" + text, "next")


@pytest.mark.parametrize("value", ["Drum 7", "", "a=b", "1-2", "'=1", -3.5, 12, None, "Überlänge"])
def test_anything_else_stays_as_it_is(value: object) -> None:
    assert safe_cell(value) == value
