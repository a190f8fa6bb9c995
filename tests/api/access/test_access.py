"""Every operation tried by those who may not: without a token, with each wrong scope, revoked, expired, unknown."""

from __future__ import annotations

import json
import re
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from fastapi.routing import iter_route_contexts

from service.api.auth import OPEN_S, Guard
from service.api.permissions import OPERATIONS
from service.errors import Unauthorized
from service.model.access import SCOPES, Scope
from service.model.base import read_json
from service.model.machine import Machine
from service.model.session import SessionRequest
from service.usecases.access import logins, tokens
from service.usecases.access.login_throttle import MOST, WINDOW_S, LoginThrottle
from service.usecases.access.tokens import Principal
from service.usecases.machines import machines
from service.usecases.sessions import sessions
from tests.support.http.workshop import JSON, StopWatch, Workshop, application, machine_body, problem_of, workshop

REFUSED = (401, 403, 429)


@dataclass(frozen=True)
class Route:
    """One way to ask for an operation."""

    name: str
    method: str
    path: str

    def __str__(self) -> str:
        return f"{self.method} {self.path}"


def routes() -> Iterator[Route]:
    """All there are, with x for every name in a path."""
    for one in iter_route_contexts(application().routes):
        path = re.sub(r"{[^}]*}", "x", one.path or "")
        for method in sorted(one.methods or {"GET"}):
            yield Route(one.name or "", method, path)


ROUTES = tuple(routes())
GUARDED = tuple(route for route in ROUTES if OPERATIONS.get(route.name) is not None)


@dataclass(frozen=True)
class Guarded:
    """A workshop where tokens are needed; by_scope: a token of each scope alone."""

    shop: Workshop
    by_scope: dict[Scope, str]
    revoked: str
    expired: str

    def ask(self, route: Route, token: str | None, **headers: str) -> Any:
        """The answer to a request whose body nobody would take."""
        stated = {} if token is None else {"authorization": f"Bearer {token}"}
        return self.shop.client.request(
            route.method, route.path, headers=JSON | stated | headers, content=b"{", follow_redirects=False
        )


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    with workshop(f"sqlite:///{tmp_path_factory.mktemp('access') / 'drumtrue.db'}") as shop:
        minutes = iter(range(0, 10_000_000, 100))
        application().state.attempts = LoginThrottle(lambda: float(next(minutes)))  # nobody is ever too fast
        by_scope = {scope: tokens.create(shop.work, scope, [scope])[1] for scope in SCOPES}
        revoked = tokens.create(shop.work, "revoked", SCOPES)[1]
        tokens.revoke(shop.work, "revoked")
        expired = tokens.create(shop.work, "expired", SCOPES, shop.work.now() + timedelta(seconds=2))[1]
        shop.now.clock.advance(10.0)
        yield Guarded(shop, by_scope, revoked, expired)


def test_every_route_has_an_entry_and_every_entry_a_route() -> None:
    names = {route.name for route in ROUTES}
    missing = names - set(OPERATIONS)
    assert not missing, f"say in service/api/permissions.py who may do {sorted(missing)}; until then nobody may"


def test_no_two_operations_share_a_name() -> None:
    """An entry is found by name: a page named like an operation of the API would get its scopes."""
    places: dict[str, set[Any]] = {}
    for one in iter_route_contexts(application().routes):
        places.setdefault(one.name or "", set()).add(one.endpoint)
    assert {name for name, endpoints in places.items() if len(endpoints) > 1} == set()


def test_every_operation_of_the_api_that_needs_a_token_says_so() -> None:
    for methods in application().openapi()["paths"].values():
        for operation in methods.values():
            needed = OPERATIONS[operation["operationId"]] is not None
            assert ("security" in operation) == needed == ({"401", "403", "429"} <= operation["responses"].keys())


@pytest.mark.parametrize("route", GUARDED, ids=str)
def test_without_a_good_token_nothing_is_done(guarded: Guarded, route: Route) -> None:
    before = guarded.shop.rows()
    for token, code in (
        (None, "token_missing"),
        ("", "token_missing"),
        (guarded.revoked, "token_revoked"),
        (guarded.expired, "token_expired"),
        ("dt_00000000_" + 32 * "0", "token_unknown"),
        (guarded.by_scope["admin"][:-1], "token_unknown"),
        ("é", "token_unknown"),
    ):
        if token == "é":
            headers = {b"authorization": "Bearer é".encode()}
            answer = guarded.shop.client.request(route.method, route.path, headers=headers)
        else:
            answer = guarded.ask(route, token)
        problem_of(answer, 401, code) if route.method != "HEAD" else None
        assert answer.headers["www-authenticate"] == "Bearer"
    wrong = guarded.by_scope["admin"][:-4] + "0000"
    problem_of(guarded.ask(route, wrong), 401, "token_unknown")
    assert guarded.shop.rows() == before


@pytest.mark.parametrize("route", GUARDED, ids=str)
def test_each_scope_does_what_it_may_and_no_more(guarded: Guarded, route: Route) -> None:
    allowed = OPERATIONS[route.name]
    assert allowed is not None
    before = guarded.shop.rows()
    for scope, token in guarded.by_scope.items():
        answer = guarded.ask(route, token)
        if scope in allowed:
            # A page's form wants its token too: to be asked for it is to be let through by scope.
            form = answer.status_code == 403 and answer.json()["code"] == "form_token_wrong"
            assert form or answer.status_code not in REFUSED, answer.text
        else:
            assert scope in problem_of(answer, 403, "scope_missing")["detail"]
    assert guarded.shop.rows() == before


def test_a_bridge_can_send_and_nothing_else() -> None:
    may = {name for name, scopes in OPERATIONS.items() if scopes is not None and "bridge" in scopes}
    assert may == {"add_readings", "add_answer", "add_block"}


@pytest.mark.parametrize("route", [r for r in ROUTES if OPERATIONS.get(r.name, frozenset()) is None], ids=str)
def test_what_is_no_secret_needs_no_token(guarded: Guarded, route: Route) -> None:
    assert guarded.ask(route, None, **{"sec-fetch-site": "same-origin"}).status_code != 401


def test_an_operation_that_is_not_named_is_refused(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.api.auth.OPERATIONS", {})
    assert "list_machines" in shop.refused("GET", "/machines", None, 403, "forbidden")["detail"]


def test_an_address_that_is_none_is_told_to_those_who_may_know(guarded: Guarded) -> None:
    nowhere, wrong_way = Route("", "GET", "/api/v1/nowhere"), Route("", "PUT", "/api/v1/machines")
    for route in (nowhere, wrong_way, Route("", "GET", "/api/v1/../../etc/passwd"), Route("", "GET", "//machines")):
        problem_of(guarded.ask(route, None), 401, "token_missing")
    problem_of(guarded.ask(nowhere, guarded.by_scope["read"]), 404, "not_found")
    refused = guarded.ask(wrong_way, guarded.by_scope["read"])
    problem_of(refused, 405, "method_not_allowed")
    assert refused.headers["allow"] == "GET, POST"


def test_nothing_is_needed_until_a_token_is_created_then_always(shop: Workshop) -> None:
    shop.ask("GET", "/machines")
    tokens.create(shop.work, "first", ["read"])
    shop.watch.seconds += OPEN_S
    shop.refused("GET", "/machines", None, 401, "token_missing")
    tokens.revoke(shop.work, "first")
    shop.refused("GET", "/machines", None, 401, "token_missing")


@pytest.mark.parametrize("name", ["balance.example", "10.0.0.7", "localhost.example", ""])
def test_without_tokens_only_this_machine_is_answered(shop: Workshop, name: str) -> None:
    """A page elsewhere may let its own name point to this machine; then the browser counts it as the same site."""
    answer = shop.client.get("/api/v1/machines", headers={"host": name})
    problem_of(answer, 401, "token_missing")


def test_without_tokens_what_a_proxy_forwards_is_not_answered(shop: Workshop) -> None:
    problem_of(shop.client.get("/api/v1/machines", headers={"x-forwarded-for": "10.0.0.7"}), 401, "token_missing")


@pytest.mark.parametrize("host", ["localhost", "localhost:8000", "127.0.0.1:8000", "[::1]:8000"])
def test_this_machine_has_several_names(shop: Workshop, host: str) -> None:
    assert shop.client.get("/api/v1/machines", headers={"host": host}).is_success


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://elsewhere.example"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site", "origin": "http://localhost:9000"},
    ],
    ids=str,
)
def test_what_another_site_makes_a_browser_send_is_refused(shop: Workshop, headers: dict[str, str]) -> None:
    answer = shop.client.post("/api/v1/machines", json=machine_body(), headers=headers)
    problem_of(answer, 403, "cross_site")
    assert shop.get("/machines") == []


@pytest.mark.parametrize("headers", [{"origin": "http://localhost"}, {"sec-fetch-site": "same-origin"}], ids=str)
def test_what_its_own_pages_send_is_taken(shop: Workshop, headers: dict[str, str]) -> None:
    assert shop.client.post("/api/v1/machines", json=machine_body(), headers=headers).is_success


def test_a_login_serves_until_it_or_its_token_ends(shop: Workshop) -> None:
    _, text = tokens.create(shop.work, "tablet", ["technician"])
    path = "/api/v1/machines"

    def asked(secret: str) -> int:
        status: int = shop.client.get(path, headers={"cookie": f"drumtrue_login={secret}"}).status_code
        return status

    first, second, third = (logins.log_in(shop.work, text) for _ in range(3))
    assert [asked(secret) for secret in (first, second, "guessed")] == [200, 200, 401]
    logins.log_out(shop.work, first)
    assert [asked(secret) for secret in (first, second)] == [401, 200]
    shop.now.clock.advance(logins.LASTS.total_seconds())
    assert asked(second) == 401
    third = logins.log_in(shop.work, text)
    assert shop.count("login") == 1  # those that were over are forgotten
    tokens.revoke(shop.work, "tablet")
    assert asked(third) == 401
    assert shop.count("login") == 0


def test_a_stream_ends_with_its_token(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Revoked after the first event: the second, which is due, is not sent."""

    async def at_once(*_: object) -> AsyncIterator[None]:
        while True:
            yield

    monkeypatch.setattr("service.api.routers.live.news", at_once)
    monkeypatch.setattr("service.api.routers.live.BEAT_S", 0.0)
    monkeypatch.setattr("service.api.auth.LOOK_AGAIN_S", 0.0)
    _, text = tokens.create(shop.work, "tablet", ["read"])
    session = sessions.open_on(shop.work, SessionRequest(machine_id=machine_in(shop))).id
    admit, looks = Guard._identify, []

    def identify(guard: Guard, request: Any) -> Principal:
        looks.append(request)
        if len(looks) == 3:  # for the request, for the first event, for the second
            tokens.revoke(shop.work, "tablet")
        return admit(guard, request)

    monkeypatch.setattr(Guard, "_identify", identify)
    path = f"/api/v1/sessions/{session}/live"
    answer = shop.client.get(path, headers={"authorization": f"Bearer {text}"})
    assert answer.status_code == 200
    assert answer.text.count("event: live") == 1
    assert ": still there" not in answer.text
    assert len(looks) == 3


def machine_in(shop: Workshop) -> str:
    """A machine, stored without asking the guard."""
    return machines.create(shop.work, read_json(Machine, json.dumps(machine_body()))).id


def test_too_many_bad_tokens_from_one_address_wait(shop: Workshop) -> None:
    tokens.create(shop.work, "bridge 1", ["read"])
    watch = StopWatch()
    application().state.attempts = LoginThrottle(watch)

    def ask(text: str) -> Any:
        return shop.client.get("/api/v1/machines", headers={"authorization": f"Bearer {text}"})

    for number in range(MOST):
        watch.seconds = float(number)
        assert ask(f"dt_0000000{number}_" + 32 * "0").status_code == 401
    answer = ask("dt_00000000_" + 32 * "0")
    problem_of(answer, 429, "too_many_attempts")
    assert answer.headers["retry-after"] == str(int(WINDOW_S) - MOST + 1)
    watch.seconds = WINDOW_S
    assert ask("dt_00000000_" + 32 * "0").status_code == 401


def test_a_good_token_always_passes_whatever_others_try_for_it_or_from_its_address(shop: Workshop) -> None:
    _, good = tokens.create(shop.work, "bridge 1", ["read"])
    watch = StopWatch()
    application().state.attempts = LoginThrottle(watch)

    def ask(text: str) -> int:
        return int(shop.client.get("/api/v1/machines", headers={"authorization": f"Bearer {text}"}).status_code)

    guesses = [good[: good.rindex("_") + 1] + f"{number:032}" for number in range(0, 1000, 50)]
    for number, text in enumerate([*guesses, *(f"nonsense {n}" for n in range(20))]):
        watch.seconds = 0.06 * number  # 1,000 a minute
        assert ask(text) in (401, 429)
        assert ask(good) == 200


def test_too_many_guesses_at_one_token_wait_whatever_their_address() -> None:
    watch = StopWatch()
    attempts = LoginThrottle(watch)

    def guess(address: str, text: str) -> str:
        def refuse() -> None:
            raise tokens.unknown()

        try:
            attempts.guarded(address, text, refuse)
        except Unauthorized as refused:
            return refused.code
        except Exception as refused:
            return type(refused).__name__
        return "taken"

    def text(number: int) -> str:
        return f"dt_aaaaaaaa_{number:032d}"

    assert {guess(f"10.0.0.{n}", text(n)) for n in range(MOST)} == {"token_unknown"}
    assert guess("10.0.1.1", text(99)) == "TooManyAttempts"
    assert guess("10.0.1.1", "dt_bbbbbbbb_" + 32 * "0") == "token_unknown"
    assert {guess(f"2001:db8::{n:x}", f"x{n}") for n in range(MOST)} == {"token_unknown"}
    assert guess("2001:db8::ffff", "y") == "TooManyAttempts"  # one network, however many addresses it has
    assert guess("2001:db8:0:1::1", "y") == "token_unknown"


def test_secrets_are_stored_and_told_nowhere(
    shop: Workshop, tmp_path: Path, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    """Probe: after use, neither token nor cookie stands in a table, a file of the database, a log or an answer."""
    caplog.set_level(0)
    _, token = tokens.create(shop.work, "tablet", ["technician"])
    cookie = logins.log_in(shop.work, token)
    answers = [
        shop.client.post("/api/v1/machines", json=machine_body(), headers={"authorization": f"Bearer {token}"}),
        shop.client.post("/api/v1/machines", content=b"{", headers={"authorization": f"Bearer {token}"} | JSON),
        shop.client.get("/api/v1/machines", headers={"cookie": f"drumtrue_login={cookie}"}),
        shop.client.get("/api/v1/nowhere", headers={"authorization": f"Bearer {token}"}),
        shop.client.get("/api/v1/machines", headers={"authorization": f"Bearer {token[:-1]}0"}),
    ]
    said = capsys.readouterr()
    texts = [repr(shop.rows()), caplog.text, said.out, said.err, *(answer.text for answer in answers)]
    files = [path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()]
    assert files or not shop.work.database.embedded
    for secret in (token, token.rpartition("_")[2], cookie):
        assert not any(secret in text for text in texts)
        assert not any(secret.encode() in contents for contents in files)
