"""The frame of the pages: files, errors in words, choices of the reader."""

from __future__ import annotations

import re

import pytest

from service.web import assets
from tests.support.http.workshop import Workshop
from tests.web.test_german_pages import english as foreign

HTML = {"accept": "text/html"}


def test_errors_are_pages_for_a_reader_and_problems_for_a_program(shared_shop: Workshop) -> None:
    page = shared_shop.client.get("/no/such/page", headers=HTML)
    assert page.status_code == 404
    assert "This page does not exist" in page.text
    assert "Diese Seite gibt es nicht" in shared_shop.client.get("/x", headers={**HTML, "accept-language": "de"}).text
    for path, headers in (("/api/v1/machines/x", HTML), ("/no/such/page", {})):
        answer = shared_shop.client.get(path, headers=headers)
        assert answer.headers["content-type"] == "application/problem+json"
        assert answer.status_code == 404
    wrong = shared_shop.client.delete("/", headers=HTML)
    assert (wrong.status_code, "does not take that" in wrong.text) == (405, True)


@pytest.mark.parametrize(
    ("path", "english", "german", "onward"),
    [
        ("/sessions/none", "There is no such session", "Diese Sitzung gibt es nicht", "/sessions"),
        ("/sessions/no%20ne🙂", "There is no such session", "Diese Sitzung gibt es nicht", "/sessions"),
        ("/sessions/none/report", "There is no such session", "Diese Sitzung gibt es nicht", "/sessions"),
        ("/sessions/none/plans/x/front", "There is no such session", "Diese Sitzung gibt es nicht", "/sessions"),
        ("/sessions/{session}/plans/x/front", "There is no such plan", "Diesen Plan", "/sessions/{session}/step/plan"),
        ("/machines/none", "There is no such machine", "Diese Maschine gibt es nicht", "/machines"),
        ("/machines/" + "x" * 99 + "/edit", "There is no such machine", "Diese Maschine gibt es nicht", "/machines"),
        ("/boxes/a.b", "There is no such box", "Diesen Kasten gibt es nicht", "/boxes"),
        ("/boxes/none", "There is no such box", "Diesen Kasten gibt es nicht", "/boxes"),
    ],
)
def test_what_is_not_stored_is_said_by_name_with_a_way_onward(
    shared_shop: Workshop, path: str, english: str, german: str, onward: str
) -> None:
    named = {"session": shared_shop.session()} if "{" in path else {}
    for language, words in (("en", english), ("de", german)):
        page = shared_shop.client.get(path.format(**named), headers={**HTML, "accept-language": language})
        assert page.status_code == 404
        assert words in page.text
        assert f'<a class="button" href="{onward.format(**named)}">' in page.text
    assert foreign(page.text) == []
    assert shared_shop.client.get(onward.format(**named), headers=HTML).status_code == 200


def test_files_are_kept_for_good_under_their_digest_only(shared_shop: Workshop) -> None:
    page = shared_shop.client.get("/", headers=HTML)
    named = re.findall(r'(?:href|src)="(/static/[^"]+)"', page.text)
    assert len(named) >= 4
    for path in named:
        answer = shared_shop.client.get(path)
        assert answer.status_code == 200
        assert "immutable" in answer.headers["cache-control"]
    old = shared_shop.client.get("/static/000000000000/base.css")
    assert (old.status_code, old.headers["cache-control"]) == (200, "no-cache")
    again = shared_shop.client.get("/static/000000000000/base.css", headers={"if-none-match": old.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    for path in ("/static/x/../pages.py", "/static/x/%2e%2e/pages.py", "/static/x/none.css"):
        assert shared_shop.client.get(path).status_code == 404
    assert shared_shop.client.get("/favicon.ico").headers["content-type"] == "image/svg+xml"


def test_modules_name_no_address_outside() -> None:
    for name, contents in assets.files().items():
        found = re.findall(rb"https?://[^\s\"')]+", contents)
        assert set(found) <= {b"http://www.w3.org/2000/svg"}, name


def test_choices_are_kept_in_a_cookie_and_the_reader_comes_back(shared_shop: Workshop) -> None:
    client = shared_shop.client
    try:
        sent = {"language": "de", "theme": "dark", "mass": "oz", "nonsense": "x", "back": "/preferences?back=/"}
        answer = client.post("/preferences", data=sent, headers=HTML, follow_redirects=False)
        assert (answer.status_code, answer.headers["location"]) == (303, "/preferences?back=/")
        page = client.get("/preferences", headers=HTML).text
        assert '<html lang="de" data-theme="dark">' in page
        assert 'value="oz" checked' in page
    finally:
        client.cookies.clear()


@pytest.mark.parametrize("back", ["//other.example/", "https://other.example/", "/\\other.example", "x", "/a b", ""])
def test_nobody_is_sent_elsewhere(shared_shop: Workshop, back: str) -> None:
    answer = shared_shop.client.post("/preferences", data={"back": back}, follow_redirects=False)
    assert answer.headers["location"] == "/"
    shared_shop.client.cookies.clear()


def test_a_page_asks_for_nothing_from_elsewhere(shared_shop: Workshop) -> None:
    answer = shared_shop.client.get("/", headers=HTML)
    assert "default-src 'self'" in answer.headers["content-security-policy"]
    assert not re.findall(r'(?:href|src|action)="(?!/)', answer.text.replace('href="#main"', ""))
    assert "style=" not in answer.text
    assert "<script>" not in answer.text
