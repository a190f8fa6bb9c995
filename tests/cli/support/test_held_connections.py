"""What somebody without a token can hold open, send by drips or send without end: the service goes on for others."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import httpx2
import pytest

from service.api import limits
from service.cli.commands.serve import serving
from service.cli.support import problem_protocol
from service.cli.support.pending_connections import PendingConnections
from service.cli.support.problem_protocol import MAX_HEAD_BYTES, ProblemProtocol
from service.settings import Settings

PATIENCE_S = 20.0


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder: Path = tmp_path_factory.mktemp("held")
    with serving(Settings(database_url=f"sqlite:///{folder / 'held.db'}")) as address:
        yield address


@pytest.fixture
def pending(monkeypatch: pytest.MonkeyPatch) -> PendingConnections:
    """Few and short-lived ones, so that a test need not wait."""
    few = PendingConnections(time.monotonic, of_address=20, in_all=30)
    monkeypatch.setattr(ProblemProtocol, "pending", few)
    return few


def opened(url: str, sent: bytes = b"") -> socket.socket:
    made = socket.create_connection(("127.0.0.1", int(url.rpartition(":")[2])), timeout=PATIENCE_S)
    if sent:
        made.sendall(sent)
    return made


def answer_of(made: socket.socket) -> tuple[int, dict[str, Any]]:
    """Status and problem of the answer on a connection that is then closed."""
    got = b""
    with suppress(ConnectionError):
        while part := made.recv(65_536):
            got += part
    head, _, body = got.partition(b"\r\n\r\n")
    return int(head.split()[1]), json.loads(body)


@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\nhost: localhost\r\nx: "])
def test_held_connections_make_room_and_the_service_answers(url: str, pending: PendingConnections, sent: bytes) -> None:
    held = [opened(url, sent) for _ in range(60)]
    try:
        answer = httpx2.get(f"{url}/health", timeout=PATIENCE_S, trust_env=False)
        assert answer.status_code == 200
        until = time.monotonic() + PATIENCE_S
        while len(pending) > 20:
            assert time.monotonic() < until
            httpx2.get(f"{url}/health", timeout=PATIENCE_S, trust_env=False)
        assert len(pending) <= 20
    finally:
        for one in held:
            one.close()


@pytest.mark.parametrize("sent", [b"", b"GET /health HTTP/1.1\r\nhost: localhost\r\nx: y"])
def test_a_head_that_does_not_come_is_not_waited_for(url: str, monkeypatch: pytest.MonkeyPatch, sent: bytes) -> None:
    monkeypatch.setattr(problem_protocol, "HEAD_S", 0.05)
    with opened(url, sent) as held:
        if sent:
            status, problem = answer_of(held)
            assert (status, problem["code"]) == (408, "request_timeout")
        else:
            with suppress(ConnectionResetError):
                assert held.recv(100) == b""


@pytest.mark.parametrize(
    ("sent", "status", "code"),
    [
        (b"GET /health HTTP/1.1\r\nhost: localhost\r\nx: " + MAX_HEAD_BYTES * b"y", 431, "head_too_long"),
        (
            b"GET /health HTTP/1.1\r\nhost: localhost\r\nx: " + MAX_HEAD_BYTES * b"y" + b"\r\n\r\n",
            431,
            "head_too_long",
        ),
        (b"GET /health HTTP/1.1\r\nhost: localhost\r\n" + 20_000 * b"a: b\r\n" + b"\r\n", 431, "head_too_long"),
        (b"GET /" + 200_000 * b"a" + b" HTTP/1.1\r\nhost: localhost\r\n\r\n", 414, "target_too_long"),
        (
            b"GET /" + 9_000 * b"a" + b" HTTP/1.1\r\nhost: a\r\nconnection: close\r\n\r\n",
            414,
            "target_too_long",
        ),
        (b"GET / HTTP/1.1\r\nhost: a\r\nhost: b\r\nconnection: close\r\n\r\n", 400, "bad_host"),
        (b"GET / HTTP/1.1\r\nconnection: close\r\n\r\n", 400, "bad_host"),
        (b"GET / HTTP/1.1\r\nhost: [bad\r\nconnection: close\r\n\r\n", 400, "bad_host"),
        (b"GET / HTTP/1.1\r\nhost: a\r\norigin: http://[bad\r\nconnection: close\r\n\r\n", 400, "bad_origin"),
    ],
    ids=str,
)
def test_a_head_that_cannot_be_taken_is_refused_in_words(url: str, sent: bytes, status: int, code: str) -> None:
    with opened(url, sent) as made:
        found, problem = answer_of(made)
    assert (found, problem["code"], problem["status"]) == (status, code, status)
    assert problem["advice"]


def test_two_requests_on_one_connection_are_both_answered(url: str) -> None:
    one = b"GET /health/live HTTP/1.1\r\nhost: localhost\r\n\r\n"
    with opened(url, one + one.replace(b"\r\n\r\n", b"\r\nconnection: close\r\n\r\n")) as made:
        got = b""
        while part := made.recv(65_536):
            got += part
    assert got.count(b"HTTP/1.1 200 OK") == 2


def test_a_body_of_somebody_unknown_is_short_and_does_not_take_for_ever(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "OF_ANYBODY_S", 0.05)
    head = "POST /login HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/x-www-form-urlencoded\r\n"
    with opened(url, f"{head}content-length: 5000\r\n\r\na=".encode()) as held:
        status, problem = answer_of(held)
    assert (status, problem["code"]) == (408, "request_timeout")
    answer = httpx2.post(f"{url}/login", data={"token": 20_000 * "x"}, timeout=PATIENCE_S, trust_env=False)
    assert (answer.status_code, answer.json()["code"]) == (413, "too_large")


@pytest.mark.parametrize("path", ["/health", "/", "/api/v1/machines", "/docs", "/openapi.json", "/static/base.css"])
def test_head_is_answered_wherever_get_is(url: str, path: str) -> None:
    with httpx2.Client(base_url=url, timeout=PATIENCE_S, trust_env=False) as client:
        full, head = client.get(path), client.head(path)
        assert (head.status_code, head.content) == (full.status_code, b"")
        assert head.headers.get("content-type") == full.headers.get("content-type")
        assert head.headers.get("content-length") in (None, full.headers.get("content-length"))
        assert client.get("/health/live").status_code == 200  # the connection is of use still


def test_a_packed_body_is_refused(url: str) -> None:
    headers = {"content-type": "application/json", "content-encoding": "gzip"}
    answer = httpx2.post(f"{url}/api/v1/readings", content=b"\x1f\x8b", headers=headers, trust_env=False)
    assert (answer.status_code, answer.json()["code"]) == (415, "content_coding")


def test_the_oldest_connection_of_an_address_makes_room_first() -> None:
    class One:
        def __init__(self) -> None:
            self.ended = False

        def give_up(self) -> None:
            self.ended = True

    pending = PendingConnections(lambda: 0.0, of_address=2, in_all=4)
    of = {address: [One() for _ in range(3)] for address in "abc"}
    for address, some in of.items():
        for one in some:
            pending.add(one, address)
    assert [[one.ended for one in of[address]] for address in "ab"] == [[True, True, True], [True, False, False]]
    assert len(pending) == 4
    for some in of.values():
        for one in some:
            pending.discard(one)
    assert len(pending) == 0
