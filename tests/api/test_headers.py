"""Headers that make a browser refuse what it must: on every kind of answer."""

from __future__ import annotations

import pytest

from service.api.headers import DEFAULTS
from tests.support.http.workshop import Workshop, machine_body

HTML = {"accept": "text/html"}


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        ("/api/v1/machines", {}, 200),
        ("/api/v1/machines/none", {}, 404),
        ("/api/v1/nowhere", {}, 404),
        ("/api/v1/machines", {"host": "other.example"}, 401),
        ("/health", {}, 200),
        ("/openapi.json", {}, 200),
        ("/docs", HTML, 200),
        ("/", HTML, 200),
        ("/nowhere", HTML, 404),
        ("/favicon.ico", {}, 200),
    ],
)
def test_every_answer_has_them(shared_shop: Workshop, path: str, headers: dict[str, str], status: int) -> None:
    answer = shared_shop.client.get(path, headers=headers)
    assert answer.status_code == status
    assert set(DEFAULTS) <= set(answer.headers)
    policy = answer.headers["content-security-policy"]
    assert "unsafe" not in policy
    assert "http" not in policy
    assert "frame-ancestors 'none'" in policy
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["x-frame-options"] == "DENY"
    assert "access-control-allow-origin" not in answer.headers


def test_the_api_document_is_a_page_of_its_own_without_scripts_in_it(shared_shop: Workshop) -> None:
    page = shared_shop.client.get("/docs", headers=HTML).text
    assert "POST /api/v1/readings" in page
    assert "Scope: admin or bridge or technician." in page
    assert "http://" not in page.replace("http://www.w3.org", "").replace("http://127.0.0.1", "")


def test_names_that_are_markup_are_shown_and_not_run(shop: Workshop) -> None:
    """Probe: what is stored is data for the API and text on a page."""
    name = "<script>alert(1)</script>\"'><img src=x onerror=alert(1)>"
    machine = shop.post("/machines", machine_body(name))["id"]
    assert shop.get(f"/machines/{machine}")["name"] == name
    shop.session(machine)
    page = shop.client.get("/", headers=HTML)
    assert page.status_code == 200
    assert "<script>alert" not in page.text
    assert "<img src=x" not in page.text
    assert "&lt;script&gt;alert(1)" in page.text


@pytest.mark.parametrize(
    "name", ["..", "../../etc/passwd", "%2e%2e%2f%2e%2e%2fetc%2fpasswd", "..%5c..%5cboot.ini", "a%00b"]
)
@pytest.mark.parametrize("place", ["/api/v1/sessions/{}", "/api/v1/plans/{}/front", "/static/x/{}", "/static/{}/x"])
def test_no_name_leads_out_of_its_place(shared_shop: Workshop, place: str, name: str) -> None:
    answer = shared_shop.client.get(place.format(name))
    assert answer.status_code in (404, 422)
    assert "root:" not in answer.text
