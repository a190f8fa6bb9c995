"""Requests are told apart, counted and told; slow and broken are two things."""

from __future__ import annotations

import json
import logging
import re
from typing import Any

import pytest

from db.store import Store
from service.api.telemetry import REQUEST_ID
from service.cli.support.logs import JsonLines
from service.runtime import health
from service.runtime.listeners import ListenerState
from tests.support.http.workshop import Workshop, application


def figures(shop: Workshop) -> dict[str, float]:
    """Every line of the metrics by name and labels."""
    text = shop.client.get("/metrics").text
    return {
        line.rpartition(" ")[0]: float(line.rpartition(" ")[2])
        for line in text.splitlines()
        if line and not line.startswith("#")
    }


def sent(shop: Workshop, *sequences: int) -> Any:
    stamp = {"source": "bridge", "taken_at": "2026-01-01T00:00:00Z", "sensor": "P", "amplitude": 1.0, "phase_deg": 0.0}
    return shop.post("/readings", [{**stamp, "sequence": number} for number in sequences])


@pytest.mark.parametrize("stated", ["abc-123", "a" * 64, "7f.b:1"])
def test_a_request_keeps_its_identifier(shared_shop: Workshop, stated: str) -> None:
    answer = shared_shop.client.get("/api/v1/machines/none", headers={"x-request-id": stated})
    assert answer.headers["x-request-id"] == stated


@pytest.mark.parametrize("stated", ["", "a b", "a" * 65, "é", 'x"y'])
def test_what_is_no_identifier_is_replaced(shared_shop: Workshop, stated: str) -> None:
    headers = {b"x-request-id": stated.encode()}
    first, second = (shared_shop.client.get("/health", headers=headers).headers["x-request-id"] for _ in range(2))
    assert re.fullmatch("[0-9a-f]{32}", first)
    assert first != second


def test_what_happened_is_counted(shop: Workshop) -> None:
    shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
    sent(shop, 1, 2, 3)
    sent(shop, 3, 4, 7)
    plan = shop.planned(shop.session())
    shop.client.get("/api/v1/nowhere")
    found = figures(shop)
    assert found["drumtrue_readings_stored_total"] == 5
    assert found["drumtrue_readings_repeated_total"] == 1
    assert found['drumtrue_sequence_gaps_total{source="bridge"}'] == 1
    assert found['drumtrue_source_lag_seconds{source="bridge"}'] > 0
    assert found[f'drumtrue_solve_seconds_count{{method="exact",status="{plan["status"]}"}}'] == 1
    assert found['drumtrue_request_seconds_count{operation="add_readings",status="201"}'] == 2
    assert found['drumtrue_request_seconds_count{operation="none",status="404"}'] == 1


def test_a_request_is_one_line_of_json(shop: Workshop) -> None:
    lines: list[str] = []

    class Kept(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            lines.append(JsonLines().format(record))

    logger, handler = logging.getLogger("drumtrue.requests"), Kept()
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        session = shop.session()
        shop.client.get(f"/api/v1/sessions/{session}", headers={"x-request-id": "walk-1"})
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
    line = json.loads(lines[-1])
    assert line.pop("ms") >= 0.0
    assert line.pop("time").endswith("+00:00")
    assert line == {
        "level": "info",
        "logger": "drumtrue.requests",
        "message": "GET get_session 200",
        "request_id": "walk-1",
        "operation": "get_session",
        "method": "GET",
        "status": 200,
        "session_id": session,
        "who": "local",
    }
    assert REQUEST_ID.get() is None


def test_well_slow_and_broken_are_told_apart(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    def ready() -> tuple[int, str]:
        answer = shop.client.get("/health/ready")
        return answer.status_code, answer.json()["status"]

    assert ready() == (200, "ready")
    monkeypatch.setattr(health, "SLOW_S", 0.0)
    assert ready() == (200, "slow")

    def gone(_store: Store) -> None:
        raise ConnectionError

    monkeypatch.setattr(Store, "ping", gone)
    assert ready() == (503, "broken")
    assert shop.client.get("/health/live").json() == {"status": "ok"}


def test_a_database_that_says_nothing_is_broken(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    import threading

    over = threading.Event()
    monkeypatch.setattr("service.api.routers.health.PATIENCE_S", 0.05)
    monkeypatch.setattr(Store, "ping", lambda _store: over.wait(30))
    try:
        answer = shop.client.get("/health/ready")
        assert (answer.status_code, answer.json()["status"]) == (503, "broken")
        assert "no answer within" in answer.json()["database"]
    finally:
        over.set()


def test_metrics_need_a_token_where_tokens_are_needed() -> None:
    from service.api.permissions import LOOKERS, OPERATIONS

    assert OPERATIONS["get_metrics"] == LOOKERS
    assert {"/metrics", "/api/v1/metrics"} <= {route.path for route in _every_route()}


def _every_route() -> Any:
    from fastapi.routing import iter_route_contexts

    return iter_route_contexts(application().routes)


def test_a_bus_that_is_not_read_shows_in_health_and_metrics(shared_shop: Workshop) -> None:
    listeners = shared_shop.work.listeners
    state = ListenerState(
        source="shed", state="reopening", reason="can0 was lost", reopened=3, restarts=1, refused={"late": 2}
    )
    listeners.add("shed", lambda: state)
    try:
        answer = shared_shop.client.get("/health")
        assert (answer.status_code, answer.json()["status"]) == (200, "degraded")
        assert answer.json()["listeners"] == [
            {
                "source": "shed",
                "state": "reopening",
                "reason": "can0 was lost",
                "reopened": 3,
                "restarts": 1,
                "refused": {"late": 2},
            }
        ]
        found = figures(shared_shop)
        assert found['drumtrue_listener_up{source="shed"}'] == 0.0
        assert found['drumtrue_listener_again{source="shed"}'] == 4.0
        assert found['drumtrue_frames_refused{reason="late",source="shed"}'] == 2.0
    finally:
        listeners.remove("shed")
    assert shared_shop.client.get("/health").json()["status"] == "ok"
