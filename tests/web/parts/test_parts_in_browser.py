"""Parts in a real browser: places described, weighed on the keypad, arranged, mounted behind a lock, one broken."""

from __future__ import annotations

from collections.abc import Iterator

import httpx2
import pytest
from playwright.sync_api import Browser, ViewportSize

from tests.support.pages.browser import LYING, UPRIGHT, Bench, Service, Tablet, browsing

PHONE: ViewportSize = {"width": 390, "height": 844}
LEFT = (3012, 2988, 3005, 2996, 3020, 2979)
RIGHT = (2991, 3008, 3011, 2987, 2994, 3015)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """A browser; skips where none is installed."""
    with browsing() as found:
        yield found


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """A service with a drum."""
    service = Service(f"sqlite:///{tmp_path_factory.mktemp('parts')}/drumtrue.db")
    yield Bench(service)
    service.stop()


def good_to_touch(tablet: Tablet, *, axe: bool = True) -> None:
    """Large enough for gloves, no wider than a phone or a tablet, readable."""
    for size in (LYING, PHONE, UPRIGHT):
        tablet.page.set_viewport_size(size)
        assert tablet.overflow() <= 0, (tablet.page.url, size)
        assert tablet.small_targets() == [], (tablet.page.url, size)
    if axe:
        assert tablet.serious() == [], tablet.page.url


def keyed(tablet: Tablet, name: str, text: str) -> None:
    """Type on the page's own keypad."""
    tablet.page.locator(f'[name="{name}"]').tap()
    for key in text:
        tablet.page.locator(f'.keypad [data-key="{key}"]').tap()


def places(tablet: Tablet) -> None:
    """Describe six places of bars."""
    tablet.press("Describe places of parts")
    tablet.heading("Where are the parts?")
    good_to_touch(tablet)
    for name, text in {"around": "6", "radius_mm": "310", "axial_mm": "-400", "axial_end_mm": "400"}.items():
        tablet.fill(name, text)
    tablet.press("Store the places")
    tablet.heading("rasp bars")


def weigh(tablet: Tablet) -> None:
    """One bar after the other, both ends; a mistyped one is told beside its field."""
    tablet.press("Weigh the parts")
    for number, (left, right) in enumerate(zip(LEFT, RIGHT, strict=True), 1):
        tablet.heading(f"Weigh the part in place {number}")
        if number == 1:
            good_to_touch(tablet)
            tablet.press("Next")
            tablet.page.locator(".field.wrong").first.wait_for()
            assert tablet.page.locator(".field.wrong").count() == 2
        keyed(tablet, "mass_left", str(left))
        keyed(tablet, "mass_right", str(right))
        tablet.press("Next" if number < len(LEFT) else "Done")
    tablet.heading("rasp bars")
    good_to_touch(tablet)


def answered(tablet: Tablet) -> None:
    """Wait for the page of an arrangement."""
    tablet.page.wait_for_url("**/arrangements/*", wait_until="domcontentloaded")
    tablet.heading("The best order")


def mount(tablet: Tablet) -> None:
    """Lock, move, release."""
    tablet.press("Mount the parts")
    tablet.heading("Stop the machine and lock it")
    good_to_touch(tablet)
    tablet.press("Locked, go on")
    tablet.page.get_by_text("Do this first, then tick it.").first.wait_for()
    tablet.tick_all()
    tablet.press("Locked, go on")
    tablet.heading("Move the parts")
    assert tablet.page.locator(".moves.numbered li").count() >= 2
    good_to_touch(tablet)
    tablet.press("All is mounted as shown")
    tablet.heading("Before the drum turns again")
    tablet.tick_all()
    tablet.press("Ready to run")
    tablet.heading("The order that is mounted")


def test_bars_from_the_scale_to_the_certificate_and_one_that_broke(browser: Browser, bench: Bench) -> None:
    tablet = Tablet(browser, bench.service.address)
    machine = bench.machine("Combine with bars")
    tablet.open(f"/machines/{machine}")
    places(tablet)
    weigh(tablet)
    tablet.press("Find the best order")
    tablet.heading("Find the best order")
    good_to_touch(tablet)
    tablet.page.get_by_role("button", name="Find the best order").tap()
    answered(tablet)
    assert tablet.page.get_by_text("Proved: no arrangement within the limits is better").count() == 1
    assert tablet.page.get_by_text("By the maker’s rule").count() == 1
    assert tablet.page.locator("svg.pic").count() == 2
    good_to_touch(tablet)
    made = tablet.page.url.rsplit("/", 1)[1]
    tablet.press("What each further move brings")
    tablet.heading("What each further move brings")
    good_to_touch(tablet)
    tablet.press("Back to the order")
    mount(tablet)
    tablet.page.context.add_cookies(
        [{"name": "drumtrue_preferences", "value": "theme=dark", "url": bench.service.address}]
    )
    tablet.press("Certificate")
    tablet.heading("Certificate of an arrangement of parts")
    good_to_touch(tablet)
    pdf = httpx2.get(f"{bench.service.address}/api/v1/arrangements/{made}/report.pdf", timeout=60)
    assert pdf.content.startswith(b"%PDF")
    stored = bench.ask("GET", f"/arrangements/{made}")
    assert (stored["state"], stored["mounted"]) == ("mounted", stored["arrangement"])
    assert stored["locked_at"] < stored["mounted_at"] < stored["released_at"]

    tablet.open(f"/machines/{machine}")
    good_to_touch(tablet)
    tablet.press("One broke")
    tablet.heading("Which one broke?")
    good_to_touch(tablet)
    tablet.page.locator(".chips a").nth(2).tap()
    tablet.heading("A new part for place 3")
    good_to_touch(tablet)
    tablet.fill("part", "7")
    keyed(tablet, "mass_left", "3075")
    keyed(tablet, "mass_right", "3060")
    tablet.press("What goes where?")
    answered(tablet)
    good_to_touch(tablet)
    found = bench.ask("GET", f"/arrangements/{tablet.page.url.rsplit('/', 1)[1]}")
    assert found["status"] == "optimal"
    assert found["moves_count"] <= 3
    assert found["new_parts_count"] == 1
    tablet.press("What mass should a part for place 3 have?")
    tablet.heading("The part to buy or to grind")
    good_to_touch(tablet)
    tablet.close()
    assert (tablet.errors, tablet.elsewhere) == ([], [])
