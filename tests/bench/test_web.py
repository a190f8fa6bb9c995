"""The measurement of the pages, on a few sessions: what it asks for is there, light, and from this server alone."""

from __future__ import annotations

from service.bench.web import AIM_BYTES, STEPS, measure


def test_every_page_is_light_and_asks_for_nothing_from_elsewhere() -> None:
    measured = measure(stored=3, repeats=1)
    assert {f"/sessions/{{id}}/step/{step}" for step in STEPS} <= {page.path for page in measured}
    assert len(measured) >= 17
    for page in measured:
        assert 1000 < page.size < AIM_BYTES, page
        assert not page.elsewhere, page
