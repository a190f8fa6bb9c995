"""`drumtrue design`: files in, answers out, and refusals with what to do."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from service.cli import app
from service.design.documents import preset_text

RUN = CliRunner()


def test_presets_are_listed_and_can_be_checked() -> None:
    listed = json.loads(RUN.invoke(app, ["design", "list", "--json"]).output)
    assert "sixbar" in [one["name"] for one in listed]
    for one in listed:
        assert RUN.invoke(app, ["design", "check", one["name"]]).exit_code == 0


def test_a_preset_that_is_shown_can_be_evaluated_as_a_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(RUN.invoke(app, ["design", "show", "sixbar"]).output)
    answer = json.loads(RUN.invoke(app, ["design", "evaluate", str(file), "--json"]).output)
    assert answer["scalars"]["force_rms"] == pytest.approx(0.2422045897)
    assert answer["feasible"]


def test_all_problems_of_a_file_are_listed(tmp_path: Path) -> None:
    file = tmp_path / "wrong.toml"
    text = preset_text("sixbar").replace("mass = 0.6935", "mass = -1.0").replace('joint = "G"', 'joint = "G"\nx = nan')
    file.write_text(text)
    answer = RUN.invoke(app, ["design", "check", str(file)])
    assert answer.exit_code == 1
    assert "linkage.link[0].mass must be above 0" in answer.output
    assert "linkage.dyad[1].x must not be stated" in answer.output
