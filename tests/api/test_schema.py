"""The API document, tried by schemathesis: whatever keeps it or breaks it is answered as it says, and never with a 5xx.

Half of the requests name things that are stored. `make fuzz` tries many more than the suite does.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from schemathesis import GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.python import asgi
from schemathesis.specs.openapi import checks

from service.app import create_app
from service.settings import Settings
from service.usecases.access import tokens
from tests.support.http.workshop import HERE, Workshop, application, workshop


def without_security() -> dict[str, Any]:
    """The document without tokens: every request carries a good one, those that do not are tried in test_access."""
    document = copy.deepcopy(application().openapi())
    for methods in document["paths"].values():
        for operation in methods.values():
            operation.pop("security", None)
    return document


EXAMPLES = int(os.environ.get("DRUMTRUE_FUZZ_EXAMPLES", "3"))
"""Requests of each operation that keep the document, and as many that break it."""
CHECKS = [
    not_a_server_error,
    checks.status_code_conformance,
    checks.content_type_conformance,
    checks.response_headers_conformance,
    checks.response_schema_conformance,
    checks.negative_data_rejection,
]
SCHEMA: Any = schemathesis.openapi.from_dict(without_security())
OPERATIONS: dict[str, Any] = {found.ok().label: found.ok() for found in SCHEMA.get_all_operations()}


@dataclass(frozen=True)
class Tried:
    """The service as schemathesis asks it, and identifiers of what is stored."""

    client: Any
    stored: dict[str, str]


@pytest.fixture(scope="module")
def tried(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tried]:
    url = f"sqlite:///{tmp_path_factory.mktemp('schema') / 'drumtrue.db'}"
    with workshop(url) as shop:
        known = stored(shop)
        _, token = tokens.create(shop.work, "schemathesis", ["admin"])
        app: Any = create_app(Settings(database_url=url), shop.work)
        with asgi.get_client(app) as client:
            client.headers["authorization"] = f"Bearer {token}"
            yield Tried(client, known)


def stored(shop: Workshop) -> dict[str, str]:
    """A value for each parameter in a path."""
    machine, box = shop.machine(), shop.box()
    session = shop.session(machine, box)
    plan = shop.planned(session)
    shop.ask("PUT", "/sources/bridge", {"machine_id": machine})
    return {
        "correction_id": shop.get(f"/sessions/{session}")["corrections"][0]["id"],
        "machine_id": machine,
        "catalogue_id": box,
        "session_id": session,
        "run_id": shop.get(f"/sessions/{session}")["runs"][0]["id"],
        "plan_id": plan["id"],
        "source": "bridge",
    }


def changes_last(label: str) -> tuple[bool, str]:
    """Sorts by method and path; one of the changes closes the session."""
    return label.startswith("PATCH"), label


LABELS: list[str] = sorted(map(str, OPERATIONS), key=changes_last)


@pytest.mark.parametrize("label", LABELS)
def test_is_answered_as_the_document_says(tried: Tried, label: str) -> None:
    operation = OPERATIONS[label]
    _try(tried, operation, GenerationMode.POSITIVE)
    if {"parameters", "requestBody"} & operation.definition.raw.keys():  # else there is nothing to break
        _try(tried, operation, GenerationMode.NEGATIVE)


def _try(tried: Tried, operation: Any, mode: GenerationMode) -> None:
    @seed(7)
    @settings(
        max_examples=EXAMPLES,
        database=None,
        phases=[Phase.explicit, Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(case=operation.as_strategy(generation_mode=mode), known=st.booleans())
    def ask(case: Any, known: bool) -> None:
        if known and mode is GenerationMode.POSITIVE:
            for part in (case.path_parameters, case.body):
                if isinstance(part, dict):
                    part.update({name: tried.stored[name] for name in part.keys() & tried.stored.keys()})
        if operation.path.endswith("/live"):
            case.query = {**(case.query or {}), "events": 1} if mode is GenerationMode.POSITIVE else case.query
        case.validate_response(case.call(session=tried.client, base_url=HERE), checks=CHECKS)

    ask()
