"""`drumtrue design`: files in, answers out, and refusals with what to do."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from typer.testing import CliRunner

from service.cli import app
from service.design.documents import preset_text
from service.design.findings import RefusedDesign
from service.errors import InvalidInput

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


def test_a_design_is_optimised_and_written(tmp_path: Path) -> None:
    file = tmp_path / "best.json"
    ran = RUN.invoke(app, ["design", "optimise", "gear_pair", "--output", str(file)])
    assert ran.exit_code == 0
    assert "enumeration: optimal, proved: the bound is 24.2339237" in ran.output
    answer = json.loads(RUN.invoke(app, ["design", "evaluate", str(file), "--json"]).output)
    assert answer["feasible"]
    assert answer["scalars"]["mass"] == pytest.approx(46.811794)
    again = RUN.invoke(app, ["design", "optimise", "gear_pair", "--output", str(file)])
    assert again.exit_code == 1


def test_an_infeasible_design_ends_with_status_1_and_its_limits(tmp_path: Path) -> None:
    text = preset_text("flywheel_thresher").replace("stress = 6.4", "stress = 2.0")
    file = tmp_path / "weak.toml"
    file.write_text(text)
    ran = RUN.invoke(app, ["design", "optimise", str(file), "--steps", "2"])
    assert ran.exit_code == 1
    assert "sqp: infeasible" in ran.output
    assert "breaks stress" in ran.output


def test_a_front_is_printed_and_one_that_is_none_is_refused() -> None:
    ran = RUN.invoke(app, ["design", "front", "shaft_set_conflict", "--points", "5", "--json"])
    points = json.loads(ran.output)["points"]
    assert len(points) >= 4
    assert points[0]["objectives"][0] == pytest.approx(1353.6, rel=1e-6)
    assert RUN.invoke(app, ["design", "front", "gear_pair"]).exit_code == 1


def test_the_verdict_tells_what_published_designs_break() -> None:
    ran = RUN.invoke(app, ["design", "verdict", "flywheel_literature", "--steps", "8"])
    assert "breaks stress (r = 0.15 m): 220.275 against 120 MPa" in ran.output
    assert "optimum 12307074 J" in ran.output


def test_a_method_that_is_not_for_the_problem_is_refused() -> None:
    ran = RUN.invoke(app, ["design", "optimise", "gear_pair", "--method", "sqp"])
    assert isinstance(ran.exception, RefusedDesign)
    assert "method must be one of enumeration, de_standard" in ran.exception.message


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("sixbar", ""),
        ("sixbar", "hodograph"),
        ("cleaning", "moment"),
        ("flywheel_thresher", "stress"),
        ("gear_pair", "gears"),
        ("shaft_set_conflict", "bars"),
        ("shaft_set_conflict", "front"),
    ],
)
def test_a_picture_stands_alone_in_its_file(tmp_path: Path, name: str, kind: str) -> None:
    file = tmp_path / "out.svg"
    asked = [*(["--kind", kind] if kind else []), "--output", str(file), "--language", "de", "--points", "4"]
    ran = RUN.invoke(app, ["design", "picture", name, *asked])
    assert ran.exit_code == 0, ran.exception
    root = ET.fromstring(file.read_text(encoding="utf-8"))
    assert root.tag.endswith("svg")
    assert "var(--" not in file.read_text(encoding="utf-8")


def test_a_picture_that_a_design_does_not_offer_is_refused_with_those_it_does() -> None:
    ran = RUN.invoke(app, ["design", "picture", "shaft_set_conflict", "--kind", "gears"])
    assert isinstance(ran.exception, InvalidInput)
    assert ran.exception.code == "design_picture_unknown"
    assert "bars, front" in ran.exception.message
    ran = RUN.invoke(app, ["design", "picture", "gear_pair", "--language", "xx"])
    assert isinstance(ran.exception, InvalidInput)
    assert ran.exception.code == "language_unknown"
