"""Report, machines, boxes, sessions and sources in a real browser: nothing wrong, nothing too small, nothing barred."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from playwright.sync_api import Browser

from tests.support.pages.browser import LYING, UPRIGHT, Bench, Service, Tablet


@dataclass
class Stocked:
    """A service with a machine balanced twice, and what its pages are called."""

    browser: Browser
    service: Service
    machine: str
    box: str
    session: str


@pytest.fixture(scope="module")
def stocked(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stocked]:
    service = Service(f"sqlite:///{tmp_path_factory.mktemp('pages') / 'drumtrue.db'}")
    bench = Bench(service)
    machine, box = bench.machine(), bench.box()
    for _ in range(2):
        session = balanced(bench, machine, box)
    yield Stocked(browser, service, machine, box, session)
    service.stop()


def balanced(bench: Bench, machine: str, box: str) -> str:
    """A session from as found to check run, of readings sent by the source."""
    session = bench.session(machine, box)
    run(bench, session, "initial", [])
    for plane in bench.spec.planes:
        run(bench, session, "trial", [{"plane": plane.name, "mass_g": 200.0, "angle_deg": 0.0}])
    correction = bench.ask("POST", f"/sessions/{session}/corrections", {"source": "fit"})["id"]
    request = {"correction_id": correction, "objective": "residual_vibration", "max_masses_per_plane": 2}
    plan = bench.ask("POST", f"/sessions/{session}/plans", request)
    bench.ask("POST", f"/plans/{plan['id']}/fitted", {})
    run(bench, session, "check", bench.masses_now(session))
    return session


def run(bench: Bench, session: str, kind: str, masses: list[dict[str, Any]]) -> None:
    taken = sorted(reading.taken_at for reading in bench.turn(masses))
    take = {"source": "drum", "from": taken[0].isoformat(), "to": taken[-1].isoformat()}
    bench.ask("POST", f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "take": take})


def pages(found: Stocked) -> dict[str, str]:
    """Addresses with words that the page has to show."""
    return {
        f"/sessions/{found.session}/report": "Balancing certificate",
        "/machines": "Combine 12",
        f"/machines/{found.machine}": "over the sessions",
        "/boxes": "Workshop box",
        f"/boxes/{found.box}": "Ledger",
        "/sessions?words=combine": "Combine 12",
        "/sources": "Readings a second",
        "/designs": "Published systems to begin with",
        "/designs/new?name=sixbar": "What this design does",
        "/designs/new?name=flywheel_literature": "This design breaks limits",
    }


@pytest.mark.parametrize(("viewport", "theme"), [(UPRIGHT, "light"), (LYING, "dark")])
def test_every_page_opens_cleanly_and_can_be_touched(stocked: Stocked, viewport: Any, theme: str) -> None:
    tablet = Tablet(stocked.browser, stocked.service.address, viewport=viewport)
    tablet.context.add_cookies(
        [{"name": "drumtrue_preferences", "value": f"theme={theme}", "url": stocked.service.address}]
    )
    try:
        for path, words in pages(stocked).items():
            tablet.open(path)
            tablet.page.get_by_text(words).first.wait_for(state="attached")
            assert tablet.serious() == [], path
            assert tablet.small_targets() == [], path
            assert tablet.overflow() <= 0, path
        assert tablet.errors == []
        assert tablet.elsewhere == []
    finally:
        tablet.close()


def test_pages_are_in_german_for_who_reads_german(stocked: Stocked) -> None:
    tablet = Tablet(stocked.browser, stocked.service.address, language="de-DE")
    try:
        for path, words in {
            f"/sessions/{stocked.session}/report": "Auswuchtprotokoll",
            f"/machines/{stocked.machine}": "über die Sitzungen",
            f"/boxes/{stocked.box}": "Buchungen",
            "/sources": "Messwerte je Sekunde",
        }.items():
            tablet.open(path)
            tablet.page.get_by_text(words).first.wait_for(state="attached")
        assert tablet.errors == []
    finally:
        tablet.close()


def test_the_report_prints_light_on_a_dark_tablet_and_leaves_out_buttons(stocked: Stocked) -> None:
    tablet = Tablet(stocked.browser, stocked.service.address)
    tablet.context.add_cookies(
        [{"name": "drumtrue_preferences", "value": "theme=dark", "url": stocked.service.address}]
    )
    try:
        tablet.open(f"/sessions/{stocked.session}/report")
        ink = "getComputedStyle(document.querySelector('.pic-title')).fill"
        dark = tablet.page.evaluate(ink)
        tablet.page.emulate_media(media="print")
        assert tablet.page.evaluate(ink) == "rgb(17, 24, 32)" != dark
        assert not tablet.page.locator(".actions").first.is_visible()
        assert tablet.page.locator(".signatures").is_visible()
    finally:
        tablet.close()
