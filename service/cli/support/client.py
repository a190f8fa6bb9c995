"""The service seen from a command: JSON over HTTP, problems as errors as text."""

from __future__ import annotations

from typing import Any

import httpx2

from service.errors import DrumtrueError
from service.messages import Message

TIMEOUT_S = 150.0
"""Longer than the longest time limit of a plan."""


class Refused(DrumtrueError):
    """The service answered a request with a problem, or not at all."""

    code = "refused"


class Client:
    """Requests to one service; every answer that is no success raises `Refused` with what the service said."""

    def __init__(self, url: str, token: str | None = None) -> None:
        self.url = url.rstrip("/")
        headers = {"authorization": f"Bearer {token}"} if token else {}
        self._http = httpx2.Client(base_url=f"{self.url}/api/v1", timeout=TIMEOUT_S, headers=headers)

    def post(self, path: str, body: object) -> Any:
        """POST JSON."""
        return self._request("POST", path, body)

    def put(self, path: str, body: object) -> Any:
        """PUT JSON."""
        return self._request("PUT", path, body)

    def get(self, path: str) -> Any:
        """GET."""
        return self._request("GET", path, None)

    def find_or_create(self, path: str, body: dict[str, Any]) -> Any:
        """What is stored under the body's name, created where there is nothing yet."""
        try:
            return self.post(path, body)
        except Refused as refused:
            if refused.code != "name_taken":
                raise
        offset = 0
        while page := self.get(f"{path}?limit=200&offset={offset}"):
            for stored in page:
                if stored["name"] == body["name"]:
                    return stored
            offset += len(page)
        raise Refused(Message("refused.not_listed", path=path, name=body["name"]))

    def close(self) -> None:
        """Let go of the connection."""
        self._http.close()

    def _request(self, method: str, path: str, body: object) -> Any:
        try:
            answer = self._http.request(method, path, json=body)
        except httpx2.HTTPError as error:
            raise Refused(Message("no_answer", url=self.url, reason=error)) from error
        if answer.is_success:
            return answer.json()
        try:
            problem = answer.json()
        except ValueError:
            problem = {}
        raise Refused(
            Message(
                "refused.by_service" if problem.get("advice") else "refused",
                method=method,
                path=path,
                detail=problem.get("detail", answer.text[:200]),
                advice=problem.get("advice"),
            ),
            code=problem.get("code", str(answer.status_code)),
            field=problem.get("field"),
        )
