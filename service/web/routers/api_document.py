"""The API document as a page: every operation, who may do it, what goes in and comes out."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from service.web.rendering import PageDep

router = APIRouter()


@router.get("/docs")
def show_api_document(page: PageDep) -> HTMLResponse:
    """Rendered here and asking for nothing from elsewhere: it works in a shed without a network."""
    document = page.request.app.openapi()
    groups: dict[str, list[dict[str, Any]]] = {}
    for shown in _operations(document):
        groups.setdefault(shown["tag"], []).append(shown)
    return page.render("api_document.html", info=document["info"], groups=groups)


def _operations(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            body = operation.get("requestBody", {}).get("content", {}).get("application/json", {})
            yield {
                "tag": operation["tags"][0],
                "id": operation["operationId"],
                "method": method.upper(),
                "path": path,
                "description": operation["description"],
                "parameters": operation.get("parameters", []),
                "request": _text(body.get("example")),
                "responses": [
                    (
                        status,
                        answer["description"],
                        [_text(c.get("example")) for c in answer.get("content", {}).values()],
                    )
                    for status, answer in sorted(operation["responses"].items())
                ],
            }


def _text(example: Any) -> str | None:
    return example if example is None or isinstance(example, str) else json.dumps(example, indent=1, ensure_ascii=False)
