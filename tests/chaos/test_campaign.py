"""The campaign of faults in its least form, and what its parts do: the portal, and half an answer."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import pytest

from drivers.bridge.http import HttpOut
from drivers.errors import DeliveryFailed
from drivers.reading import Reading
from service.chaos import gate
from service.chaos.campaign import CampaignOptions, run
from service.chaos.gate import PORTALS, Gate

READINGS = [
    Reading(source="s", sequence=number, taken_at=datetime(2026, 1, 1, tzinfo=UTC), sensor="P", amplitude=1.0)
    for number in (1, 2)
]


class Receipts(BaseHTTPRequestHandler):
    """Acknowledges two readings, whatever is posted."""

    protocol_version = "HTTP/1.1"

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["content-length"]))
        self.send_response(201)
        body = b'{"accepted": 2, "duplicates": 0}'
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - the name of the base
        """Say nothing."""


@pytest.fixture
def acknowledging() -> Iterator[Gate]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Receipts) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        with closing(Gate(server.server_address[1], random.Random(1))) as made:
            yield made
        server.shutdown()


def test_a_sign_in_page_acknowledges_nothing(acknowledging: Gate, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever it answers, to the very request that is acknowledged where nothing stands between."""
    for portal in PORTALS:
        monkeypatch.setattr(gate, "PORTALS", (portal,))
        with closing(HttpOut(acknowledging.url)) as out:
            acknowledging.become("portal")
            with pytest.raises(DeliveryFailed):
                out.post(READINGS)
            acknowledging.become("open")
            assert out.post(READINGS) == 2


def test_half_an_answer_acknowledges_nothing(acknowledging: Gate, monkeypatch: pytest.MonkeyPatch) -> None:
    """However much of it comes, as long as it is not all."""
    acknowledging.become("half_answers")
    for most in (1, 20, 60, 100):
        monkeypatch.setattr(gate, "MAX_HALF_BYTES", most)
        with closing(HttpOut(acknowledging.url)) as out, pytest.raises(DeliveryFailed):
            out.post(READINGS)


def test_faults_around_a_service_lose_and_double_nothing() -> None:
    wishes = CampaignOptions(
        kills=0,
        others=1,
        engine="sqlite",
        replicas=1,
        bridges=1,
        technicians=1,
        within_s=0.0,
        only=("portal", "half_answers", "wrong_clock", "held_connections"),
    )
    outcome = run(wishes, lambda _line: None)
    assert outcome.judgement.wrong == ()
    assert outcome.done == dict.fromkeys(wishes.only, 1)
    assert outcome.judgement.readings > 0
