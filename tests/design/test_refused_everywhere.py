"""Every bad document is refused by the same name over the API, at the command line and on a page; never a trace."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from service.app import PREFIX
from service.cli import app
from service.design.findings import RefusedDesign
from service.design.registry import check
from tests.design.bad_documents import CASES
from tests.support.http.workshop import Workshop

pytestmark = pytest.mark.only("sqlite")
RUN = CliRunner()
PAGE = {"accept": "text/html", "accept-language": "en"}


def finite(document: Any) -> bool:
    """Whether JSON can say it: NaN and infinities are refused with the text that holds them."""
    try:
        json.dumps(document, allow_nan=False)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize(("document", "code"), CASES.values(), ids=CASES.keys())
def test_a_bad_document_is_refused_alike(
    shared_shop: Workshop, tmp_path: Path, document: dict[str, Any], code: str
) -> None:
    refused = {one.code: one for one in check(document) if one.severity == "refusal"}
    text = json.dumps(document)
    for path in ("design-evaluations", "design-studies", "design-runs"):
        body = json.dumps({"document": document, **({"name": "Bad"} if path == "design-studies" else {})})
        headers = {"content-type": "application/json"}
        answer = shared_shop.client.post(f"{PREFIX}/{path}", content=body, headers=headers)
        assert answer.status_code == 422
        if finite(document):
            assert answer.json()["code"] in refused
            assert answer.json()["advice"]
    file = tmp_path / "bad.json"
    file.write_text(text, encoding="utf-8")
    ran = RUN.invoke(app, ["design", "check", str(file), "--json"])
    assert ran.exit_code == 1
    assert code in [one["code"] for one in json.loads(ran.output)]
    for command in ("evaluate", "optimise", "verdict", "picture"):
        error = RUN.invoke(app, ["design", command, str(file)]).exception
        assert isinstance(error, RefusedDesign)
        assert error.code in refused
    form = {"study_name": "Bad", "base": "null", "study_version": "", "document": text}
    page = shared_shop.client.post("/designs/new", data=form, headers=PAGE, follow_redirects=False)
    assert page.status_code == 422
    assert any(first(one.message) in page.text for one in refused.values())
    live = shared_shop.client.post("/designs/check", data=form)
    assert live.json()["fields"] or live.json()["general"]


def first(message: str) -> str:
    """The beginning of a sentence as a page shows it: with a capital letter, up to the first sign that HTML writes."""
    text = message[:1].upper() + message[1:]
    return text[: min((text.index(sign) for sign in "'\"<>&-" if sign in text), default=len(text))]
