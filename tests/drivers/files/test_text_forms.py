"""Text files as loggers write them: any alphabet, separator, decimal sign, header and form of time reads the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.errors import UnreadableFile
from drivers.files.csv_file import read_csv
from tests.support.drivers.text_forms import ROWS, Form, text_of, written

forms = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@given(written(), st.integers(0, 2**32 - 1))
@forms
def test_every_form_gives_the_numbers_that_were_written(tmp_path: Path, form: Form, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(ROWS, 2)).round(5)
    path = tmp_path / "a.csv"
    path.write_bytes(text_of(form, values).encode(form.encoding))
    unit = form.time if form.time in ("ms", "us") and form.separator == " " else None
    time, rate = (None, form.rate) if form.time == "none" else ("t", None)
    found = read_csv(path, ["kp", "P"], time=time, sample_rate_hz=rate, time_unit=unit)
    tolerance = 0.02 if form.time == "rounded" else 2e-3
    assert found.sample_rate_hz == pytest.approx(form.rate, rel=tolerance)
    assert found.column("kp") == pytest.approx(values[:, 0], abs=1e-5)
    assert found.column("P") == pytest.approx(values[:, 1], abs=1e-8)
    assert any("cut off" in note for note in found.notes) == (form.tail == "cut")


def text(rows: str, count: int = 60, step: float = 0.001) -> str:
    return rows + "".join(f"{step * row:.6f},{row},0.5\n" for row in range(count))


@pytest.mark.parametrize(
    ("contents", "words"),
    [
        (text("t,kp,P\n") + "x,y,z\n" + text(""), "line 62: has 'y' where a finite number must be"),
        (text("t,kp,P,P\n"), "line 1: names 2 columns 'P': give each one name"),
        (text("t,kp,Q\n"), "has no column 'P': its columns are t, kp, Q"),
        (text(""), "its columns are not named, line 1 holds 3 numbers; put a line with 3 names above them"),
        ("t,kp,P\n" + "0.1,1,2\n0.1,1,2\n0.3,1,2\n", r"if its times are rounded, state sample_rate_hz"),
        ("\n\n", "has no line of names"),
    ],
)
def test_what_is_wrong_is_told_with_the_line_and_what_to_do(tmp_path: Path, contents: str, words: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(contents)
    with pytest.raises(UnreadableFile, match=words) as refused:
        read_csv(path, ["kp", "P"], time="t")
    assert len(str(refused.value)) < 600


def test_columns_without_names_are_named_by_number(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text(text(""))
    found = read_csv(path, ["2", "3"], time="1")
    assert found.column("2").tolist() == list(range(60))
    assert found.sample_rate_hz == pytest.approx(1000.0)


def test_times_that_no_machine_could_be_sampled_at_are_taken_in_their_unit_and_told(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text("t,kp,P\n", step=0.39))
    found = read_csv(path, ["kp", "P"], time="t")
    assert found.sample_rate_hz == pytest.approx(1000.0 / 0.39)
    assert "taken as ms" in found.notes[0]


def test_a_unit_that_a_file_states_is_kept_for_the_layout_to_be_checked(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text("t,kp,P\ns,V,g\n"))
    assert read_csv(path, ["kp", "P"], time="t").stated == {"P": (None, "g")}
    path.write_text(text("t [s],kp (V),P (mm/s)\n"))
    assert read_csv(path, ["kp", "P"], time="t").stated["P"] == (None, "mm/s")


def test_a_huge_cell_is_not_printed(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("x" * 1_000_000)
    with pytest.raises(UnreadableFile) as refused:
        read_csv(path, ["kp", "P"], time="t")
    assert len(str(refused.value)) < 500
