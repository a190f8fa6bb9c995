"""Who hangs up stops the computation, and nothing of it is stored."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import httpx2 as httpx
import pytest
import uvicorn

from service.errors import Abandoned
from service.runtime.presence import LOOK_EVERY_S, Presence
from service.usecases.plans import plans
from tests.support.http.workshop import Workshop, application

LONG_S = 60.0
"""Long enough for any machine: a test that fails waits so long."""


@contextmanager
def served() -> Iterator[int]:
    """The application of the workshop on a port, in a thread."""
    listening = socket.socket()
    listening.bind(("127.0.0.1", 0))
    server = uvicorn.Server(uvicorn.Config(application(), log_level="critical", lifespan="off"))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
    thread.start()
    try:
        yield listening.getsockname()[1]
    finally:
        server.should_exit = True
        thread.join()


@pytest.mark.only("sqlite")
@pytest.mark.parametrize("key", [{}, {"idempotency-key": "k"}])
def test_who_hangs_up_stops_the_plan(shop: Workshop, monkeypatch: pytest.MonkeyPatch, key: dict[str, str]) -> None:
    session = shop.session()
    shop.learn(session)
    request = {"correction_id": shop.correct(session)["id"], "objective": "residual_vibration"}
    begun, ended = threading.Event(), threading.Event()

    def endless(*_given: Any, monotonic: Callable[[], float], **_more: Any) -> None:
        begun.set()
        try:
            over = time.monotonic() + LONG_S
            while time.monotonic() < over:
                monotonic()
        except Abandoned:
            ended.set()
            raise

    monkeypatch.setattr(plans, "solve_plan", endless)
    before = shop.count("plan"), shop.count("audit"), shop.count("idempotency")
    with served() as port, httpx.Client() as client:
        url = f"http://127.0.0.1:{port}/api/v1/sessions/{session}/plans"
        with pytest.raises(httpx.TimeoutException):
            client.post(url, json=request, headers=key, timeout=httpx.Timeout(LONG_S, read=0.5))
        assert begun.wait(LONG_S)
        assert ended.wait(LONG_S)
        with shop.work.turns.turn():  # both are free again
            pass
    assert (shop.count("plan"), shop.count("audit"), shop.count("idempotency")) == before


def test_a_client_is_looked_for_no_more_often_than_every_quarter_of_a_second() -> None:
    seconds = [0.0]
    asked: list[float] = []

    class Request:
        async def is_disconnected(self) -> bool:
            asked.append(seconds[0])
            return False

    present = Presence(Request(), lambda: seconds[0])
    assert not present()
    seconds[0] = LOOK_EVERY_S
    assert not present(), "no event loop waits for this thread: it is never gone"
    assert asked == []
