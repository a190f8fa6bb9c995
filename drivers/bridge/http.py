"""Deliver readings to the service over HTTP, in batches.

The service stores each (source, sequence) once.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Protocol

import httpx2

from drivers.checks import require
from drivers.closeable import Closeable
from drivers.errors import DeliveryFailed, DeliveryRefused
from drivers.reading import Reading
from drivers.reading_json import readings_to_json

PATH = "/api/v1/readings"
ANSWERS_PATH = "/api/v1/balancer-answers"
LATER = frozenset({408, 425, 429})
"""Client errors that say "not now" rather than "not this"."""
DETAIL_CHARS = 500
MAX_ANSWER_BYTES = 65_536
"""What is read of an answer, at most: a receipt has under 100 bytes, a problem a few thousand."""
_RECEIPT, _PROBLEM = "application/json", "application/problem+json"
_TAKEN = (200, 201)


class Outlet(Protocol):
    """Where readings go."""

    def post(self, readings: Sequence[Reading]) -> int:
        """Hand readings over and return how many were acknowledged; raises a `DeliveryError`."""
        ...

    def close(self) -> None:
        """Let go of the connection."""
        ...


class HttpOut(Closeable):
    """Posts readings to `{base_url}/api/v1/readings`, at most batch_size in one request.

    Nothing is kept: after `DeliveryFailed` the caller posts the same readings again, which is safe, since the service
    knows them by source and sequence. Only the service's own receipt over all that was sent counts as acknowledged: a
    sign-in page of a Wi-Fi, another web server or a wrong address may answer 200 to anything. token: sent as
    `authorization: Bearer`. timeout_s: for each step of a request, and for its answer as a whole. now: the clock that
    dates the readings. client: an httpx2 client to use instead of an own one; closed with this object all the same.
    """

    def __init__(
        self,
        base_url: str,
        *,
        batch_size: int = 500,
        timeout_s: float = 10.0,
        token: str | None = None,
        client: httpx2.Client | None = None,
        monotonic: Callable[[], float] = time.monotonic,
        now: Callable[[], datetime] = lambda: datetime.now(UTC),
    ) -> None:
        require(
            base_url.startswith(("http://", "https://")), f"base_url {base_url!r}", "begin with http:// or https://"
        )
        require(batch_size >= 1, f"batch_size {batch_size}", "be 1 or more")
        require(timeout_s > 0.0, f"timeout_s {timeout_s}", "be > 0")
        self._base_url = base_url.rstrip("/")
        self._batch_size = batch_size
        # An answer is short: packed, a few kilobytes could unfold to gigabytes.
        self._headers = {"content-type": "application/json", "accept-encoding": "identity"}
        if token:
            self._headers["authorization"] = f"Bearer {token}"
        self._timeout_s, self._monotonic, self._now = timeout_s, monotonic, now
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
        self.post_readings(readings_to_json(batch), batch[0].sequence, batch[-1].sequence, len(batch))

    def post_readings(self, body: bytes, first: int, last: int, count: int) -> None:
        """Post a JSON list of readings that is written already, of these sequences. Raises as `post` does."""
        what = f"{count} readings, sequences {first} to {last},"
        self._post(PATH, body, what, lambda receipt: _counts(receipt) == count)

    def post_answer(self, body: bytes, sequence: int) -> None:
        """Post the JSON of one balancer's answer. Raises as `post` does."""
        self._post(ANSWERS_PATH, body, f"answer {sequence}", _is_stored_answer)

    def _post(self, path: str, body: bytes, what: str, receipts: Callable[[dict[str, Any]], bool]) -> None:
        """Post; return once the service acknowledged all of it: `receipts` says so of a JSON object it answered."""
        url = self._base_url + path
        answer = self._answer(url, body, what)
        if answer.media_type == _RECEIPT and answer.status in _TAKEN and receipts(answer.fields):
            return
        if answer.status >= 500 or answer.status in LATER:
            raise DeliveryFailed(f"{what} were not taken by {url} now (status {answer.status}): {answer.words()}")
        if answer.is_refusal():
            detail = answer.words()
            raise DeliveryRefused(
                f"{what} were refused by {url} (status {answer.status}): {detail}", status=answer.status, detail=detail
            )
        raise DeliveryFailed(
            f"what answers at {url} is no Drumtrue (status {answer.status}, {answer.media_type or 'no media type'}): "
            f"{what} are kept; is the address right, and does a sign-in page stand between? {answer.words()}".rstrip()
        )

    def _answer(self, url: str, body: bytes, what: str) -> _Answer:
        try:
            # By what the clock of this machine says now, the service knows how far it is off.
            headers = {**self._headers, "sent-at": self._now().isoformat()}
            with self._client.stream("POST", url, content=body, headers=headers) as response:
                media_type = response.headers.get("content-type", "").partition(";")[0].strip().lower()
                return _Answer(response.status_code, media_type, self._read(response))
        except (httpx2.HTTPError, httpx2.InvalidURL, httpx2.StreamError) as error:
            raise DeliveryFailed(
                f"{what} did not reach {url} ({type(error).__name__}: {error}): is the service running there?"
            ) from error

    def _read(self, response: httpx2.Response) -> bytes:
        """The answer, as it came; cut off where it is too long. Raises httpx2.ReadTimeout where it takes too long."""
        until, found = self._monotonic() + self._timeout_s, bytearray()
        for part in response.iter_raw():
            found += part
            if len(found) > MAX_ANSWER_BYTES:
                break
            if self._monotonic() > until:
                raise httpx2.ReadTimeout(f"no whole answer within {self._timeout_s:g} s")
        return bytes(found[:MAX_ANSWER_BYTES])


@dataclass(frozen=True, slots=True)
class _Answer:
    status: int
    media_type: str
    body: bytes

    @property
    def fields(self) -> dict[str, Any]:
        """The JSON object; empty where it is none, or was cut off."""
        try:
            found = json.loads(self.body)
        except (ValueError, RecursionError):
            return {}
        return found if isinstance(found, dict) else {}

    def is_refusal(self) -> bool:
        """Whether the service refuses what it was sent: a problem of ours has a code, other web servers' has none."""
        fields = self.fields
        return (
            400 <= self.status < 500
            and self.media_type == _PROBLEM
            and fields.get("status") == self.status
            and isinstance(fields.get("code"), str)
        )

    def words(self) -> str:
        """What it says, in one line: detail and advice of problem JSON (RFC 9457), else its text, shortened."""
        text = self.body.decode("utf-8", "replace")
        fields = self.fields
        said = fields.get("detail") or fields.get("title")
        if isinstance(said, str):
            advice = fields.get("advice")
            text = f"{said}; what to do: {advice}" if isinstance(advice, str) else said
        return " ".join(text.split())[:DETAIL_CHARS]


def _counts(receipt: dict[str, Any]) -> int:
    """How many readings a receipt is over; -1 for what is none."""
    accepted, duplicates = receipt.get("accepted"), receipt.get("duplicates")
    if type(accepted) is not int or type(duplicates) is not int or min(accepted, duplicates) < 0:
        return -1
    return accepted + duplicates


def _is_stored_answer(receipt: dict[str, Any]) -> bool:
    return isinstance(receipt.get("accepted"), bool) and isinstance(receipt.get("id"), str)
