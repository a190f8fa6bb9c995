"""Bodies that are no document, not declared as JSON, or too long: each a clear problem, and nothing stored."""

from __future__ import annotations

import json

import pytest

from service.app import PREFIX
from tests.support.http.workshop import Workshop, machine_body, problem_of

NOON = "2025-12-01T12:00:00Z"
BODIES: dict[str, tuple[bytes, str]] = {
    "no JSON": (b"{", "invalid_json"),
    "not UTF-8": (b'{"source": "\xff\xfe"}', "invalid_json"),
    "half a surrogate": (b'{"source": "\\ud800"}', "invalid_json"),
    "deeper than any document": (b"[" * 100_000, "invalid_json"),
    "longer number than any": (b'{"sequence": 1' + b"0" * 5000 + b"}", "invalid_json"),
    "nothing": (b"", "invalid_input"),
    "null": (b"null", "invalid_input"),
    "a text": (b'"READING"', "invalid_input"),
    "a list of lists": (b"[[1]]", "invalid_input"),
}


@pytest.fixture(scope="module")
def session(shared_shop: Workshop) -> str:
    return shared_shop.session()


@pytest.mark.parametrize(("body", "code"), BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("path", ["/readings", "/machines", "/sessions/$session/runs"])
def test_a_body_that_is_no_document(shared_shop: Workshop, session: str, path: str, body: bytes, code: str) -> None:
    shared_shop.refused("POST", path.replace("$session", session), body, 422, code)


@pytest.mark.parametrize("stated", [None, "text/plain", "application/x-www-form-urlencoded", "application/jsonp"])
def test_a_body_that_is_not_declared_as_json(shared_shop: Workshop, stated: str | None) -> None:
    before = shared_shop.rows()
    headers = {} if stated is None else {"content-type": stated}
    answer = shared_shop.client.post(PREFIX + "/machines", content=json.dumps(machine_body("new")), headers=headers)
    assert problem_of(answer, 415, "unsupported_media_type")["value"] == stated
    assert shared_shop.rows() == before


def test_ten_megabytes_of_readings(shared_shop: Workshop) -> None:
    one = json.dumps({"source": "bridge", "sequence": 7, "taken_at": NOON, "sensor": "P", "amplitude": 1.0}).encode()
    body = b"[" + b",".join([one] * (10 * 1024 * 1024 // len(one) + 1)) + b"]"
    assert len(body) > 10 * 1024 * 1024
    problem = shared_shop.refused("POST", "/readings", body, 413, "too_large")
    assert "bytes" in problem["detail"]
    assert "batches" in problem["advice"]
