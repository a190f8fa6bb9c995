"""`drumtrue arrange`: a request as the API takes it; each refusal by its name, an infeasible problem as an answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from service.cli import app
from service.errors import DrumtrueError
from tests.api.arrangements.test_arrangements import BARS, parts, places
from tests.api.arrangements.test_bad_arrangement_input import BAD

RUN = CliRunner()
OF_A_SERVER = {"machine_missing": "needs_a_server", "places_missing": "needs_a_server"}
"""What the file cannot say without a server is told so first."""


def arranged(tmp_path: Path, request: dict[str, Any], *options: str) -> Any:
    file = tmp_path / "request.json"
    file.write_text(json.dumps(request))
    return RUN.invoke(app, ["arrange", str(file), *options])


def test_the_answer_is_the_api_s(tmp_path: Path) -> None:
    answer = json.loads(arranged(tmp_path, {"places": places(), "parts": parts()}, "--json").output)
    assert (answer["status"], answer["gap"]) == ("optimal", 0.0)
    told = arranged(tmp_path, {"places": places(), "parts": parts()}).output
    assert "proved: no arrangement within the limits is better" in told
    assert "the maker's rule would leave" in told
    front = json.loads(arranged(tmp_path, {"places": places(), "parts": parts()}, "--front", "--json").output)
    assert front[-1]["offer"]["objective_value"] == pytest.approx(answer["objective_value"])


def test_what_cannot_be_is_an_answer_with_its_reason(tmp_path: Path) -> None:
    answer = json.loads(arranged(tmp_path, {"places": places(), "parts": parts(BARS[:4])}, "--json").output)
    assert (answer["status"], answer["code"]) == ("infeasible", "too_few_parts")


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_meant_is_refused_by_the_same_name(tmp_path: Path, name: str) -> None:
    body, code = BAD[name]
    answer = arranged(tmp_path, body)
    assert answer.exit_code != 0
    assert isinstance(answer.exception, DrumtrueError)
    assert answer.exception.code in (code, OF_A_SERVER.get(code))
