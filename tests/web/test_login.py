"""Logging in and out, and forms that only pages of the service can have sent."""

from __future__ import annotations

import re
from typing import Any

import pytest
from fastapi.testclient import TestClient

from service.usecases.access import tokens
from service.usecases.access.login_throttle import MOST
from service.web import form_tokens
from tests.support.http.workshop import HERE, Workshop, application, problem_of
from tests.support.pages.posted import POSTED

HTML = {"accept": "text/html"}


def token_on(page: Any) -> str:
    """The token in the first form of a page."""
    found = re.search(r'name="form_token" value="([0-9a-f]{64})"', page.text)
    assert found is not None
    return found.group(1)


@pytest.fixture
def browser(shop: Workshop) -> TestClient:
    """A browser that sends what it is told and nothing else; tokens are needed."""
    return TestClient(application(), base_url=HERE, headers=HTML, follow_redirects=False)


def log_in(browser: TestClient, text: str, back: str = "/") -> Any:
    form = {"token": text, "back": back, "form_token": token_on(browser.get("/login"))}
    return browser.post("/login", data=form)


def test_who_is_not_logged_in_is_sent_there_and_back(shop: Workshop, browser: TestClient) -> None:
    _, text = tokens.create(shop.work, "tablet", ["technician"])
    sent = browser.get("/?x=1")
    assert (sent.status_code, sent.headers["location"]) == (303, "/login?back=%2F%3Fx%3D1")
    page = browser.get(sent.headers["location"])
    assert 'name="back" value="/?x=1"' in page.text
    answer = log_in(browser, f"  {text.upper()} ", "/?x=1")
    assert (answer.status_code, answer.headers["location"]) == (303, "/?x=1")
    cookie = answer.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=lax" in cookie
    assert "Secure" not in cookie
    assert text.rpartition("_")[2] not in cookie
    home = browser.get("/")
    assert home.status_code == 200
    assert "tablet" in home.text
    assert browser.get("/api/v1/machines").status_code == 200  # the page's own scripts ask the API
    assert log_in(browser, text, "https://other.example/").headers["location"] == "/"


def test_out_is_out_at_the_server_too(shop: Workshop, browser: TestClient) -> None:
    _, text = tokens.create(shop.work, "tablet", ["technician"])
    log_in(browser, text)
    kept = browser.cookies["drumtrue_login"]
    answer = browser.post("/logout", data={"form_token": token_on(browser.get("/"))})
    assert answer.headers["location"] == "/login"
    assert "drumtrue_login" not in browser.cookies
    browser.cookies.set("drumtrue_login", kept)
    assert browser.get("/").status_code == 303


def test_over_https_cookies_are_secure(shop: Workshop) -> None:
    _, text = tokens.create(shop.work, "tablet", ["technician"])
    browser = TestClient(application(), base_url="https://balance.example", headers=HTML, follow_redirects=False)
    page = browser.get("/login")
    assert "Secure" in page.headers["set-cookie"]
    answer = log_in(browser, text)
    assert answer.status_code == 303
    assert "Secure" in answer.headers["set-cookie"]


def test_a_wrong_token_is_told_and_not_shown_again_and_too_many_wait(shop: Workshop, browser: TestClient) -> None:
    _, text = tokens.create(shop.work, "tablet", ["technician"])
    wrong = text[:-4] + "0000"
    for _ in range(MOST):
        page = log_in(browser, wrong)
        assert page.status_code == 401
        assert wrong not in page.text
    assert "This token is not good" in page.text
    page = log_in(browser, wrong)
    assert page.status_code == 429
    assert page.headers["retry-after"] == "60"
    assert shop.count("login") == 0
    assert log_in(browser, text).status_code == 303


def test_a_page_that_a_scope_does_not_open_says_so(shop: Workshop, browser: TestClient) -> None:
    _, text = tokens.create(shop.work, "bridge 1", ["bridge"])
    log_in(browser, text)
    page = browser.get("/")
    assert page.status_code == 403
    assert "That is not open to you" in page.text


@pytest.mark.parametrize("path", POSTED)
def test_a_form_without_its_token_changes_nothing(shop: Workshop, browser: TestClient, path: str) -> None:
    """Every form of every page, also as it comes from a browser that does not tell the site it comes from."""
    other = TestClient(application(), base_url=HERE)
    stolen = token_on(other.get("/login", headers=HTML))
    browser.get("/login")
    before = shop.rows()
    for data in ({}, {"form_token": ""}, {"form_token": stolen}, {"form_token": "é"}):
        problem = browser.post(path, data=data, headers={"accept": "*/*"})
        problem_of(problem, 403, "form_token_wrong")
    assert shop.rows() == before


def test_a_script_may_send_the_token_as_a_header(shop: Workshop, browser: TestClient) -> None:
    token = token_on(browser.get("/"))
    answer = browser.post("/preferences", data={"theme": "dark"}, headers={form_tokens.HEADER: token})
    assert answer.status_code == 303
