"""Versions of sessions and plans: who decided on an older one is told, and shown the newer."""

from __future__ import annotations

from typing import Any

import pytest

from service.app import PREFIX
from tests.api.test_openapi import operations
from tests.support.http.workshop import DRUM, Workshop, application, problem_of

RUN = {"kind": "initial", "readings": DRUM.readings()}
OF_SESSION: dict[str, tuple[str, str, Any]] = {
    "change_session": ("PATCH", "/sessions/{session}", {"note": "mine"}),
    "add_run": ("POST", "/sessions/{session}/runs", RUN),
    "change_run": ("PATCH", "/sessions/{session}/runs/{run}", {"excluded": True, "reason": "typo"}),
    "add_correction": ("POST", "/sessions/{session}/corrections", {"source": "fit"}),
    "add_plan": ("POST", "/sessions/{session}/plans", {"correction_id": "{correction}", "objective": "components"}),
}
OF_PLAN: dict[str, tuple[str, str, Any]] = {
    "reserve_plan": ("POST", "/plans/{plan}/reserve", {}),
    "release_plan": ("POST", "/plans/{plan}/release", None),
    "fit_plan": ("POST", "/plans/{plan}/fitted", {}),
    "unfit_plan": ("POST", "/plans/{plan}/unfit", None),
}
CHANGES = OF_SESSION | OF_PLAN


class Seen:
    """A session with a plan, and who asks for changes of them."""

    def __init__(self, shop: Workshop) -> None:
        self.shop = shop
        self.session = shop.session()
        plan = shop.planned(self.session)
        run = shop.get(f"/sessions/{self.session}")["runs"][0]["id"]
        self.names = {
            "session": self.session,
            "plan": plan["id"],
            "run": run,
            "correction": plan["correction_id"],
        }

    def etag(self, name: str) -> str:
        """The version that a change of this name is decided on."""
        path = "/sessions/{session}" if name in OF_SESSION else "/plans/{plan}"
        answer = self.shop.client.get(PREFIX + path.format(**self.names))
        assert answer.headers["etag"] == f'"{answer.json()["version"]}"'
        return str(answer.headers["etag"])

    def ask(self, name: str, etag: str | None) -> Any:
        """The answer to a change, decided on this version."""
        method, path, body = CHANGES[name]
        if isinstance(body, dict) and "correction_id" in body:
            body = {**body, "correction_id": self.names["correction"]}
        headers = {} if etag is None else {"if-match": etag}
        return self.shop.client.request(method, PREFIX + path.format(**self.names), json=body, headers=headers)

    def by_somebody_else(self) -> None:
        """A change of session and plan meanwhile."""
        self.shop.post(f"/plans/{self.names['plan']}/reserve", {})


@pytest.fixture
def seen(shop: Workshop) -> Seen:
    return Seen(shop)


def test_every_change_of_a_session_or_plan_takes_a_version() -> None:
    of_designs = {"change_design_study"}  # tests/api/designs
    takes = {
        name
        for name, operation in operations(application().openapi())
        if any(parameter["name"] == "If-Match" for parameter in operation.get("parameters", ()))
    }
    assert takes - of_designs == set(CHANGES)


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_decided_on_an_older_version_is_refused_and_shown_the_newer(seen: Seen, name: str) -> None:
    if name == "unfit_plan":
        seen.ask("fit_plan", None)
    old = seen.etag(name)
    if name == "unfit_plan":
        seen.ask("unfit_plan", None)
        seen.ask("fit_plan", None)
    else:
        seen.by_somebody_else()
    rows = seen.shop.rows()
    problem = problem_of(seen.ask(name, old), 412, "version_stale")
    assert seen.shop.rows() == rows
    present = seen.etag(name)
    assert present != old
    assert f'"{problem["current"]["version"]}"' == present
    assert problem["current"] == seen.shop.get(
        ("/sessions/{session}" if name in OF_SESSION else "/plans/{plan}").format(**seen.names)
    )
    assert seen.ask(name, present).is_success


@pytest.mark.parametrize("name", CHANGES)
@pytest.mark.parametrize("etag", [None, "*"])
def test_older_clients_need_not_say_what_they_saw(seen: Seen, name: str, etag: str | None) -> None:
    if name == "unfit_plan":
        seen.ask("fit_plan", None)
    assert seen.ask(name, etag).is_success


@pytest.mark.parametrize("etag", ["1", 'W/"1"', '"x"', '"0"', '"1", "2"', ""])
def test_what_is_no_version_is_refused(seen: Seen, etag: str) -> None:
    problem_of(seen.ask("change_session", etag), 422, "invalid_input")


def test_answers_bear_the_version_they_made(seen: Seen) -> None:
    for name in ("change_session", "reserve_plan", "fit_plan"):
        answer = seen.ask(name, None)
        assert answer.headers["etag"] == f'"{answer.json()["version"]}"' == seen.etag(name)
    headers = {"idempotency-key": "k"}
    path = f"{PREFIX}/plans/{seen.names['plan']}/unfit"
    tags = {seen.shop.client.post(path, headers=headers).headers["etag"] for _ in range(2)}
    assert tags == {seen.etag("unfit_plan")}


@pytest.mark.parametrize("name", ["add_run", "add_correction", "add_plan", "reserve_plan", "change_run"])
def test_a_session_counts_what_changes_in_it(seen: Seen, name: str) -> None:
    before = seen.etag("change_session")
    assert seen.ask(name, None).is_success
    assert seen.etag("change_session") != before
