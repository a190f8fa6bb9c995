"""The API document: problems as what they are, and an example for every operation."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

from fastapi import FastAPI

from service.api.permissions import OPERATIONS
from service.api.problems import MEDIA_TYPE

DESCRIPTION = """\
From vibration readings to the stock masses to bolt on.

Every number is meant in the conventions of its machine: mass angles in degrees from the key-phasor mark in
`angle_sense`, phases in degrees in `phase_sense`, amplitudes of the 1x component in each sensor's quantity, unit and
detection. Masses in g, radii and axial positions in mm, unbalance in g.mm, forces in N, speeds in r/min, times in UTC.
"""


TOKEN = {
    "type": "http",
    "scheme": "bearer",
    "description": "From `drumtrue token create`. Not needed on the machine itself as long as no token was created.",
}
REFUSALS = {
    "401": "A token is needed, or the one that was sent is not good (any more).",
    "403": "The token's scopes do not allow it, or another site sent the request.",
    "429": "Too many tokens that are not good: `Retry-After` says how many seconds to wait.",
}


def install(app: FastAPI) -> None:
    """Finish the document that FastAPI makes."""
    plain = app.openapi

    def finished() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = plain()
            for operations in document["paths"].values():
                for operation in operations.values():
                    _finish(operation)
                    _guard(operation)
            document["components"]["securitySchemes"] = {"token": TOKEN}
            schemas = document["components"]["schemas"]
            schemas.pop("HTTPValidationError", None)
            schemas.pop("ValidationError", None)
        return app.openapi_schema or {}

    app.openapi = finished  # type: ignore[method-assign]


def _guard(operation: dict[str, Any]) -> None:
    """Say who may do the operation, and how others are refused."""
    allowed = OPERATIONS[operation["operationId"]]
    if allowed is None:
        return
    scopes = " or ".join(sorted(allowed))
    operation["security"] = [{"token": []}]
    operation["description"] += f"\n\nScope: {scopes}."
    schema = {"$ref": "#/components/schemas/Problem"}
    for status, words in REFUSALS.items():
        operation["responses"][status] = {"description": words, "content": {MEDIA_TYPE: {"schema": schema}}}


@cache
def examples() -> dict[str, Any]:
    """Example of each operation: {operation: {request?, response}}, recorded from a session that really ran."""
    text = files("service.api").joinpath("examples.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def _is_problem(content: dict[str, Any]) -> bool:
    return content.get("schema") == {"$ref": "#/components/schemas/Problem"}


def _finish(operation: dict[str, Any]) -> None:
    example = examples().get(operation["operationId"], {})
    for status, response in operation["responses"].items():
        content = response.get("content", {})
        if _is_problem(content.get("application/json", {})):
            content[MEDIA_TYPE] = content.pop("application/json")
        elif status.startswith("2") and "response" in example:
            for shown in content.values():
                shown["example"] = example["response"]
    if "requestBody" in operation and "request" in example:
        operation["requestBody"]["content"]["application/json"]["example"] = example["request"]
