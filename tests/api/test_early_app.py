"""The service answers health before the rest of it is built, and everything else by building it first."""

from __future__ import annotations

import threading

import pytest
from fastapi.testclient import TestClient

from service.early_app import HEALTH, EarlyApp
from service.settings import Settings
from tests.support.http.workshop import HERE, Workshop, application


def early(shop: Workshop, built: list[str]) -> EarlyApp:
    settings = Settings(database_url="sqlite://", loopback=True)
    return EarlyApp(settings, shop.work, lambda: False, lambda: built.append(threading.current_thread().name))


@pytest.mark.parametrize("path", sorted(HEALTH))
def test_health_is_the_same_before_and_after_the_rest_is_there(shop: Workshop, path: str) -> None:
    built: list[str] = []
    app = early(shop, built)
    client = TestClient(app, base_url=HERE)
    before = client.get(path)
    assert not built
    app.whole()
    after = client.get(path)
    assert (before.status_code, before.headers["content-type"]) == (after.status_code, after.headers["content-type"])
    if "metrics" not in path and "ready" not in path:
        assert before.json() == after.json()
    assert before.headers.get("content-security-policy") == after.headers.get("content-security-policy")


def test_any_other_request_builds_the_whole_once(shop: Workshop) -> None:
    built: list[str] = []
    client = TestClient(early(shop, built), base_url=HERE)
    assert client.get("/api/v1/machines").status_code == 200
    assert client.get("/no/such/page").status_code == 404
    assert client.get("/openapi.json").json()["paths"] == application().openapi()["paths"]
    assert len(built) == 1


def test_nobody_gets_in_by_being_early(shop: Workshop) -> None:
    """Metrics need a token, before as after."""
    app = early(shop, [])
    elsewhere = TestClient(app, base_url="http://drum.example")
    assert elsewhere.get("/metrics").status_code == 401
    app.whole()
    assert elsewhere.get("/metrics").status_code == 401
