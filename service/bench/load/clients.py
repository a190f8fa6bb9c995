"""Clients that post prepared bodies over kept connections: they cost as little as a client can."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any
from urllib.parse import urlsplit

PREFIX = "/api/v1"
START = datetime(2026, 3, 1, 12, tzinfo=UTC)


@dataclass(frozen=True)
class Load:
    """Seconds of each answer, and from the first request to the last answer."""

    taken: Sequence[float]
    seconds: float

    def percentile(self, share: float) -> float:
        """The time within which this share of the answers came, s."""
        return sorted(self.taken)[min(len(self.taken) - 1, int(share * len(self.taken)))]


class Connection:
    """One kept connection to a service."""

    def __init__(self, url: str) -> None:
        self._http = http.client.HTTPConnection(urlsplit(url).netloc, timeout=60)

    def ask(self, method: str, path: str, body: bytes | None = None, prefix: str = PREFIX) -> bytes:
        """The body of the answer. Raises ValueError for one that is no success."""
        headers = {} if body is None else {"content-type": "application/json"}
        self._http.request(method, prefix + path, body, headers)
        answer = self._http.getresponse()
        text = answer.read()
        if answer.status >= 300:
            raise ValueError(f"{method} {path}: {answer.status} {text[:300]!r}")
        return text

    def post(self, path: str, document: object) -> Any:
        """The answer to a document, read."""
        return json.loads(self.ask("POST", path, json.dumps(document).encode()))

    def close(self) -> None:
        """Let go of it."""
        self._http.close()


def bodies(source: str, count: int, size: int, first: int = 0) -> list[bytes]:
    """Bodies of `size` readings each, numbered on from `first`; of one reading, not in a list."""
    out = []
    for body in range(count):
        numbers = range(first + body * size, first + (body + 1) * size)
        readings = [_reading(source, number) for number in numbers]
        out.append(json.dumps(readings if size > 1 else readings[0]).encode())
    return out


def _reading(source: str, number: int) -> dict[str, Any]:
    return {
        "source": source,
        "sequence": number,
        "taken_at": (START + timedelta(milliseconds=10 * number)).isoformat(),
        "sensor": "PQ"[number % 2],
        "amplitude": 3.0 + 0.001 * (number % 500),
        "phase_deg": 0.1 * (number % 3600),
        "speed_rpm": 460.0 + 0.01 * (number % 100),
        "scatter": 0.02,
        "overall_rms": 4.2,
    }


def post_all(url: str, each: Sequence[Iterable[bytes]], path: str = "/readings") -> Load:
    """Post the bodies of every client one after another, the clients beside each other. Raises what a client raised."""
    taken: list[float] = []
    wrong: list[Exception] = []

    def post(one: Iterable[bytes]) -> None:
        connection = Connection(url)
        try:
            for body in one:
                begun = time.perf_counter()
                connection.ask("POST", path, body)
                taken.append(time.perf_counter() - begun)
        except (OSError, ValueError, http.client.HTTPException) as error:
            wrong.append(error)
        finally:
            connection.close()

    threads = [threading.Thread(target=post, args=(one,)) for one in each]
    begun = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    seconds = time.perf_counter() - begun
    if wrong:
        raise wrong[0]
    return Load(taken, seconds)
