"""The API document: frozen, every operation with its units and an example that is what the service answers today.

After a change that is meant: `python -m tests.api.record_examples`, then `python -m tests.api.test_openapi`, which
rewrites tests/golden/openapi.json; review both differences before they are stored.
"""

from __future__ import annotations

import copy
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_type_hints

import pytest
from fastapi.responses import StreamingResponse
from fastapi.routing import APIRoute

from service.api import routers
from service.api.openapi import examples
from service.api.strict_json import StrictRoute
from service.model.base import adapter
from service.model.design_run import DesignRunNow
from service.usecases.sessions.live import Live
from tests.api import record_examples
from tests.support.http.workshop import Workshop, application

GOLDEN = Path(__file__).parents[1] / "golden" / "openapi.json"
UNITS = re.compile(r"\b(mm|g|g\.mm|kg|degrees|r/min|N|s|UTC|pieces|[Uu]nits?)\b")
CLOSE = 1e-9
EVENT = "event: live\ndata: "
VARYING = frozenset({"evaluations", "version", "hash"})
"""What differs from one computer or version to the next without being another answer."""


def document() -> Any:
    """The document as it is served, without what other tests look after: examples and version."""
    served = copy.deepcopy(application().openapi())
    served["info"]["version"] = "0"
    for _, operation in operations(served):
        for part in (operation.get("requestBody", {}), *operation["responses"].values()):
            for content in part.get("content", {}).values():
                content.pop("example", None)
    return served


def operations(served: Any) -> Iterator[tuple[str, Any]]:
    """Name and operation."""
    for methods in served["paths"].values():
        for operation in methods.values():
            yield operation["operationId"], operation


NAMES = [name for name, _ in operations(application().openapi())]


def test_the_document_is_served(shop: Workshop) -> None:
    answer = shop.client.get("/openapi.json")
    assert answer.status_code == 200
    assert answer.json() == json.loads(json.dumps(application().openapi()))


def test_the_document_is_the_frozen_one() -> None:
    assert document() == json.loads(GOLDEN.read_text(encoding="utf-8")), __doc__


def test_operations_have_names_of_their_own() -> None:
    assert len(set(NAMES)) == len(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_every_operation_has_units_and_an_example(name: str) -> None:
    operation = dict(operations(application().openapi()))[name]
    assert UNITS.search(operation["description"]), f"{name}: say the units"
    if "requestBody" in operation:
        assert "example" in operation["requestBody"]["content"]["application/json"], record_examples.__doc__
    success = next(answer for status, answer in operation["responses"].items() if status.startswith("2"))
    assert all("example" in shown for shown in success["content"].values()), record_examples.__doc__


def test_every_problem_is_declared_as_one() -> None:
    for name, operation in operations(application().openapi()):
        for status, answer in operation["responses"].items():
            if status.startswith("4"):
                assert list(answer["content"]) == ["application/problem+json"], name


def test_every_field_is_described() -> None:
    for name, schema in application().openapi()["components"]["schemas"].items():
        for field, entry in schema.get("properties", {}).items():
            assert entry.get("description"), f"{name}.{field}: say what it is, with its unit"


def test_examples_are_what_the_service_answers_today() -> None:
    recorded = record_examples.record()
    assert set(recorded) == set(examples()) == set(NAMES)
    for name, example in recorded.items():
        for part, now in example.items():
            difference = next(differences(examples()[name][part], now, f"{name}.{part}"), None)
            assert difference is None, f"{difference}\n{record_examples.__doc__}"


STREAMS: dict[str, tuple[str, Any]] = {"follow": ("live", Live), "follow_design_run": ("progress", DesignRunNow)}
"""Event and document of each operation that answers with a stream."""


@pytest.mark.parametrize("name", NAMES)
def test_examples_are_of_their_types(name: str) -> None:
    route = next(route for route in routes() if route.name == name)
    example = examples()[name]
    answered: Any = get_type_hints(route.endpoint, include_extras=True)["return"]
    if answered is StreamingResponse:
        kind, data = example["response"].strip().split("\n")
        event, told = STREAMS[name]
        assert kind == f"event: {event}"
        adapter(told).validate_json(data.removeprefix("data: "))
    else:
        adapter(answered).validate_json(json.dumps(example["response"]))
    assert ("request" in example) == (route.body_field is not None)
    if route.body_field is not None:
        sent: Any = route.body_field.field_info.annotation
        adapter(sent).validate_json(json.dumps(example["request"]))
        assert isinstance(route, StrictRoute)


def routes() -> Iterator[APIRoute]:
    """The routes of every router."""
    for module in vars(routers).values():
        for route in getattr(getattr(module, "router", None), "routes", ()):
            assert isinstance(route, APIRoute)
            yield route


def differences(stored: Any, now: Any, where: str) -> Iterator[str]:
    """Where two examples differ by more than rounding."""
    if where.rpartition(".")[2] in VARYING:
        return
    if isinstance(stored, dict) and isinstance(now, dict) and stored.keys() == now.keys():
        for key in stored:
            yield from differences(stored[key], now[key], f"{where}.{key}")
    elif isinstance(stored, list) and isinstance(now, list) and len(stored) == len(now):
        for index, pair in enumerate(zip(stored, now, strict=True)):
            yield from differences(*pair, f"{where}[{index}]")
    elif isinstance(stored, float) and isinstance(now, float | int):
        if not math.isclose(stored, now, rel_tol=CLOSE, abs_tol=CLOSE):
            yield f"{where}: {stored} -> {now}"
    elif isinstance(stored, str) and isinstance(now, str) and stored.startswith(EVENT) and now.startswith(EVENT):
        yield from differences(json.loads(stored.removeprefix(EVENT)), json.loads(now.removeprefix(EVENT)), where)
    elif stored != now:
        yield f"{where}: {stored!r} -> {now!r}"


if __name__ == "__main__":
    GOLDEN.write_text(json.dumps(document(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
