"""The linkage on a design page moves lightly, and not at all for whoever asked for less motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import pytest
from playwright.sync_api import Browser, Page

from tests.support.pages.browser import Service

A_FRAME_MS = 8.0
PHONE = {"width": 390, "height": 800}
PATH = "/designs/new?name=sixbar"
FRAMES = """
async () => {
  const next = () => new Promise((done) => requestAnimationFrame(done));
  for (let k = 0; k < 40; k += 1) await next();
}
"""
PLACE = "document.querySelector('g.moving circle:nth-of-type(3)').getAttribute('cx')"


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    found = Service(f"sqlite:///{tmp_path_factory.mktemp('motion') / 'drumtrue.db'}")
    yield found
    found.stop()


def opened(browser: Browser, service: Service, motion: Literal["reduce", "no-preference"]) -> Page:
    page = browser.new_page(viewport=PHONE, reduced_motion=motion, base_url=service.address)  # type: ignore[arg-type]
    page.goto(PATH, wait_until="domcontentloaded")
    page.locator("[data-play]").wait_for()
    return page


def test_a_frame_takes_few_milliseconds_of_script_and_style(browser: Browser, service: Service) -> None:
    page = opened(browser, service, "no-preference")
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")

    def spent() -> float:
        values = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
        return 1e3 * float(values["ScriptDuration"] + values["RecalcStyleDuration"])

    before, place = spent(), page.evaluate(PLACE)
    page.evaluate(FRAMES)
    assert page.evaluate(PLACE) != place
    assert (spent() - before) / 40 < A_FRAME_MS
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    page.close()


def test_less_motion_is_respected_and_the_angle_can_be_set_by_hand(browser: Browser, service: Service) -> None:
    page = opened(browser, service, "reduce")
    place = page.evaluate(PLACE)
    page.evaluate(FRAMES)
    assert page.evaluate(PLACE) == place
    page.locator("[data-angle]").fill("60")
    assert page.evaluate(PLACE) != place
    page.close()
