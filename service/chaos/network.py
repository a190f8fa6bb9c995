"""Faults of what is around a service, each with what must hold meanwhile; what did not hold is returned."""

from __future__ import annotations

import socket
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from datetime import datetime, timedelta
from email.utils import parsedate_to_datetime

import httpx2

from service.chaos.instances import Instance
from service.chaos.server import Server

HELD = 300
HELD_S = 1.5
BEGINNINGS = (b"", b"GET /he", b"POST /login HTTP/1.1\r\nhost: x\r\ncontent-length: 4000000\r\n\r\nusername=")
"""What is sent on connections that are then held: nothing, half a line, the head of a body that does not come."""
ALIVE_S = 5.0
"""Within this a service must answer that it lives, on a machine that has the campaign's own load only."""
HANG_S = 12.0
ANSWER_S = 10.0
ASKED_AT_ONCE = 20
AHEAD = timedelta(seconds=3)
"""The header `date` has whole seconds."""


def held_connections(instance: Instance, slack_s: float) -> list[str]:
    """Hold connections of a client that has no token and says nothing more. slack_s: as of `CampaignOptions`."""
    with ExitStack() as stack:
        for number in range(HELD):
            one = stack.enter_context(socket.create_connection(("127.0.0.1", instance.port), timeout=10.0))
            one.sendall(BEGINNINGS[number % len(BEGINNINGS)])
        wrong = _alive(instance, f"{HELD} connections were held", slack_s)
        time.sleep(HELD_S)
    return wrong


def hung_database(server: Server, instances: Sequence[Instance], slack_s: float) -> list[str]:
    """Stop the server, closing nothing: each request is answered in time that the database is away."""
    wrong: list[str] = []
    with server.hanging(), ThreadPoolExecutor(ASKED_AT_ONCE) as threads:
        end = time.monotonic() + HANG_S
        while time.monotonic() < end and not wrong:
            asked = [threads.submit(_asked, instances[n % len(instances)], slack_s) for n in range(ASKED_AT_ONCE)]
            for one in instances:
                wrong += _alive(one, "the database hung", slack_s)
            wrong += [line for one in asked for line in one.result()]
    return wrong


def shown_as_present(instance: Instance, session: str) -> list[str]:
    """Look whether a session shows what is not measured yet: a reading that is dated ahead must not pass for new."""
    try:
        answer = httpx2.get(f"{instance.url}/api/v1/sessions/{session}/now", timeout=ANSWER_S, trust_env=False)
    except httpx2.HTTPError:
        return []  # another fault's matter
    if not answer.is_success:
        return []
    measured, now = answer.json()["measured_at"], parsedate_to_datetime(answer.headers["date"])
    if measured is not None and datetime.fromisoformat(measured) > now + AHEAD:
        return [f"/now shows a reading of {measured} at {now}"]
    return []


def _alive(instance: Instance, while_: str, slack_s: float) -> list[str]:
    try:
        seconds = instance.alive_s(ALIVE_S + slack_s)
    except httpx2.HTTPError as silent:
        return [f"/health/live did not answer while {while_}: {type(silent).__name__}"]
    return [f"/health/live took {seconds:.1f} s while {while_}"] if seconds > ALIVE_S + slack_s else []


def _asked(instance: Instance, slack_s: float) -> list[str]:
    begun = time.monotonic()
    try:
        answer = httpx2.get(f"{instance.url}/api/v1/machines", timeout=2 * ANSWER_S + slack_s, trust_env=False)
    except httpx2.HTTPError as silent:
        return [f"no answer while the database hung: {type(silent).__name__}"]
    seconds = time.monotonic() - begun
    if answer.status_code != 503 or "retry-after" not in answer.headers:
        return [f"{answer.status_code} while the database hung: {answer.text[:200]}"]
    return [f"answered after {seconds:.1f} s while the database hung"] if seconds > ANSWER_S + slack_s else []
