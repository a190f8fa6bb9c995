"""The way out to the service: readings posted in batches. The service stores each (source, sequence) once."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Protocol

import httpx2

from drivers.checks import require
from drivers.errors import DeliveryFailed, DeliveryRefused
from drivers.opened import Closed
from drivers.reading import Reading
from drivers.wire import readings_to_json

PATH = "/api/v1/readings"
ANSWERS_PATH = "/api/v1/balancer-answers"
LATER = frozenset({408, 425, 429})
"""Client errors that say "not now" rather than "not this"."""
DETAIL_CHARS = 500


class Outlet(Protocol):
    """Where readings go."""

    def post(self, readings: Sequence[Reading]) -> int:
        """Hand readings over and return how many were acknowledged; raises a `DeliveryError`."""
        ...

    def close(self) -> None:
        """Let go of the connection."""
        ...


class HttpOut(Closed):
    """Posts readings to `{base_url}/api/v1/readings`, at most batch_size in one request.

    Nothing is kept: after `DeliveryFailed` the caller posts the same readings again, which is safe, since the service
    knows them by source and sequence. token: sent as `authorization: Bearer`. client: an httpx2 client to use instead
    of an own one; closed with this object all the same.
    """

    def __init__(
        self,
        base_url: str,
        *,
        batch_size: int = 500,
        timeout_s: float = 10.0,
        token: str | None = None,
        client: httpx2.Client | None = None,
    ) -> None:
        require(
            base_url.startswith(("http://", "https://")), f"base_url {base_url!r}", "begin with http:// or https://"
        )
        require(batch_size >= 1, f"batch_size {batch_size}", "be 1 or more")
        require(timeout_s > 0.0, f"timeout_s {timeout_s}", "be > 0")
        self._base_url = base_url.rstrip("/")
        self._batch_size = batch_size
        self._headers = {"content-type": "application/json"}
        if token:
            self._headers["authorization"] = f"Bearer {token}"
        self._client = client or httpx2.Client(timeout=timeout_s)

    def post(self, readings: Sequence[Reading]) -> int:
        """Post the readings and return their number.

        Raises `DeliveryFailed` where the same call may succeed later, `DeliveryRefused` where it cannot, `BrokenSource`
        for a number that is not finite.
        """
        for start in range(0, len(readings), self._batch_size):
            self._post_batch(readings[start : start + self._batch_size])
        return len(readings)

    def close(self) -> None:
        """Close the connection; harmless when closed."""
        self._client.close()

    def _post_batch(self, batch: Sequence[Reading]) -> None:
        what = f"{len(batch)} readings, sequences {batch[0].sequence} to {batch[-1].sequence},"
        self.post_body(readings_to_json(batch), what)

    def post_body(self, body: bytes, what: str, path: str = PATH) -> None:
        """Post JSON that is written already; what: its name in an error. Raises as `post` does."""
        url = self._base_url + path
        try:
            response = self._client.post(url, content=body, headers=self._headers)
        except (httpx2.HTTPError, httpx2.InvalidURL) as error:
            raise DeliveryFailed(
                f"{what} did not reach {url} ({type(error).__name__}: {error}): is the service running there?"
            ) from error
        if response.is_success:
            return
        status, detail = response.status_code, _words_of(response)
        if status >= 500 or status in LATER:
            raise DeliveryFailed(f"{what} were not taken by {url} now (status {status}): {detail}")
        raise DeliveryRefused(f"{what} were refused by {url} (status {status}): {detail}", status=status, detail=detail)


def _words_of(response: httpx2.Response) -> str:
    """What the service says, in one line: detail and advice of problem JSON (RFC 9457), else its text, shortened."""
    try:
        problem = json.loads(response.content)
    except (ValueError, RecursionError):
        problem = None
    words = [response.text]
    if isinstance(problem, dict):
        said = problem.get("detail") or problem.get("title")
        if isinstance(said, str):
            advice = problem.get("advice")
            words = [said, f"what to do: {advice}" if isinstance(advice, str) else ""]
    return " ".join("; ".join(filter(None, words)).split())[:DETAIL_CHARS]
