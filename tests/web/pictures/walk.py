"""A session walked through in a browser, with a picture at each page: for the documents, or of all to look at."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, ViewportSize

from tests.support.pages.browser import LYING, UPRIGHT, Bench, Service, Tablet, browsing

TALLEST = 1400
"""Of a picture in the documents, px."""
IN_DOCUMENTS = ("live", "lock", "trial", "correction", "plan", "finish")
GERMAN_DARK = "language=de&theme=dark"
GRAMS, ANGLE = '[name="masses.mass_g"]', '[name="masses.angle_deg"]'
TAKE = "[data-take]:enabled"
RUN = {"readings[0].amplitude": "3.11", "readings[0].phase_deg": "400", "readings[1].amplitude": "🙂"}
Keep = Callable[[Path, bytes], None]


@contextmanager
def walker() -> Iterator[Walk]:
    """A browser on a service with a drum beside it."""
    with tempfile.TemporaryDirectory() as place, browsing() as browser:
        service = Service(f"sqlite:///{place}/drumtrue.db")
        try:
            yield Walk(browser, Bench(service))
        finally:
            service.stop()


@dataclass
class Walk:
    """The way through the pages; `shown` is called with the name of each, while the tablet shows it."""

    browser: Browser
    bench: Bench

    def everything(self, folder: Path) -> None:
        """Every page as NAME-upright.png and NAME-lying.png."""
        tablet = Tablet(self.browser, self.bench.service.address)

        def keep(name: str) -> None:
            for size, way in ((LYING, "lying"), (UPRIGHT, "upright")):
                tablet.page.set_viewport_size(size)
                tablet.page.screenshot(path=folder / f"{name}-{way}.png", full_page=True)

        session = self.session(tablet, keep)
        self.workshop(tablet, session, keep)
        tablet.close()

    def for_documents(self, folder: Path, keep: Keep) -> None:
        """The pages that the documents show."""
        tablet = Tablet(self.browser, self.bench.service.address)

        def shown(name: str) -> None:
            if name in IN_DOCUMENTS:
                keep(folder / f"{name}.png", _clip(tablet, UPRIGHT))
            if name == "plan":
                tablet.page.set_viewport_size(LYING)
                _prefer(tablet, GERMAN_DARK)
                keep(folder / "plan-german-dark.png", _clip(tablet, LYING))
                tablet.page.set_viewport_size(UPRIGHT)
                _prefer(tablet, "")

        self.session(tablet, shown)
        tablet.close()

    # ------------------------------------------------------------ the pages of a session
    def session(self, tablet: Tablet, shown: Callable[[str], None]) -> str:
        """From as found to the report of one session; its identifier."""
        machine = self.bench.machine(
            "Combine 12", seen_from="pulley side", balance_grade_mm_s=25.0, vibration_limit_mm_s=1.5
        )
        session = self.bench.session(machine, self.bench.box("Workshop box"))
        tablet.open(f"/sessions/{session}")
        shown("silent")
        self._refused(tablet, shown)
        self._live(tablet, [])
        shown("live")
        tablet.page.locator(TAKE).tap()
        for plane in self.bench.spec.planes:
            self._trial(tablet, plane.name, shown if plane is self.bench.spec.planes[0] else lambda _name: None)
        tablet.heading("The runs are enough")
        shown("compute")
        tablet.press("Compute")
        tablet.heading("What the drum needs")
        shown("correction")
        tablet.press("Choose the pieces")
        tablet.heading("Find the best pieces")
        shown("aim")
        tablet.press("Find the best")
        tablet.heading("The best choice from the box")
        shown("plan")
        self._opened(tablet, shown, "plan-opened")
        self._overtaken(tablet, session, shown)
        tablet.open(f"/sessions/{session}")
        tablet.press("Fit this")
        _stop(tablet)
        tablet.heading("Change the masses")
        shown("change")
        self._opened(tablet, shown, "change-opened")
        tablet.press("All is bolted on as shown")
        tablet.heading("Before the drum turns again")
        shown("release")
        _go(tablet)
        self._live(tablet, self.bench.masses_now(session))
        shown("check")
        tablet.page.locator(TAKE).tap()
        tablet.page.locator(".before-after").wait_for()
        shown("finish")
        return session

    def _refused(self, tablet: Tablet, shown: Callable[[str], None]) -> None:
        if tablet.page.locator("details.typed[open]").count() == 0:
            tablet.press("Type the run in")
        for name, text in RUN.items():
            tablet.fill(name, text)
        tablet.press("Store this run")
        tablet.page.locator(".field.wrong").first.wait_for()
        shown("bad-typing")
        tablet.page.evaluate("localStorage.clear()")
        tablet.page.reload(wait_until="domcontentloaded")

    def _overtaken(self, tablet: Tablet, session: str, shown: Callable[[str], None]) -> None:
        """A form that came too late."""
        tablet.open(f"/sessions/{session}/step/trial")
        tablet.page.evaluate("for (const one of document.querySelectorAll('[name=stamp]')) one.value = 'old'")
        tablet.press("Trial mass in plane")
        tablet.page.locator("[data-kept]").wait_for()
        shown("overtaken")

    def _trial(self, tablet: Tablet, plane: str, shown: Callable[[str], None]) -> None:
        tablet.heading(f"Trial run in plane {plane}")
        shown("advice")
        tablet.press("Stop the machine to bolt it on")
        tablet.heading("Stop the machine and lock it")
        shown("lock")
        _stop(tablet)
        tablet.heading("Bolt the trial mass into plane")
        shown("trial")
        grams, angle = (float(tablet.page.input_value(field)) for field in (GRAMS, ANGLE))
        tablet.press("The mass is bolted on")
        _go(tablet)
        tablet.heading("Run with the trial mass")
        shown("trial-silent")
        self._live(tablet, [{"plane": plane, "mass_g": grams, "angle_deg": angle}])
        shown("trial-live")
        tablet.page.locator(TAKE).tap()

    def _live(self, tablet: Tablet, masses: list[dict[str, Any]]) -> None:
        """Wait until the drum has been steady long enough to be taken, and the needles stand."""
        tablet.page.locator("[data-take]").wait_for()
        while tablet.page.locator(TAKE).count() == 0:
            self.bench.turn(masses)
            tablet.page.wait_for_timeout(700)
        tablet.page.wait_for_timeout(400)

    def _opened(self, tablet: Tablet, shown: Callable[[str], None], name: str) -> None:
        """The page with everything unfolded."""
        tablet.page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        shown(name)

    # ------------------------------------------------------------ all others
    def workshop(self, tablet: Tablet, session: str, shown: Callable[[str], None]) -> None:
        """Every page that is not the next step of a session."""
        document = self.bench.ask("GET", f"/sessions/{session}")
        machine, box, plan = document["machine_id"], document["catalogue_id"], document["plans"][-1]["id"]
        pages = {
            "home": "/",
            "sessions": "/sessions",
            "session-new": "/sessions/new",
            "machines": "/machines",
            "machine": f"/machines/{machine}",
            "machine-edit": f"/machines/{machine}/edit",
            "boxes": "/boxes",
            "box": f"/boxes/{box}",
            "box-new": "/boxes/new",
            "sources": "/sources",
            "preferences": "/preferences",
            "login": "/login",
            "api": "/docs",
            "missing": "/sessions/none",
            "runs": f"/sessions/{session}/runs",
            "front": f"/sessions/{session}/plans/{plan}/front",
            "fitted": f"/sessions/{session}/step/fit",
            "checked": f"/sessions/{session}/step/check",
            "looking-back": f"/sessions/{session}/step/trial",
            "report": f"/sessions/{session}/report",
        }
        for name, path in pages.items():
            tablet.open(path)
            shown(name)
        tablet.open("/sessions/new")
        tablet.press("Pieces on the drum, run-out")
        tablet.heading("Which machine?")
        shown("session-new-known")
        tablet.context.add_cookies(
            [{"name": "drumtrue_preferences", "value": GERMAN_DARK + "&mass=oz&length=in", "url": tablet.address}]
        )
        for name in ("machine", "machine-edit", "box", "sources", "report", "runs", "looking-back", "missing"):
            tablet.open(pages[name])
            shown(f"{name}-german-dark")


def _stop(tablet: Tablet) -> None:
    tablet.heading("Stop the machine and lock it")
    tablet.tick_all()
    tablet.press("Locked, go on")


def _go(tablet: Tablet) -> None:
    tablet.heading("Before the drum turns again")
    tablet.tick_all()
    tablet.press("Ready to run")


def _prefer(tablet: Tablet, choices: str) -> None:
    """Show the page again in this language and light."""
    tablet.context.add_cookies([{"name": "drumtrue_preferences", "value": choices, "url": tablet.address}])
    tablet.page.reload(wait_until="domcontentloaded")


def _clip(tablet: Tablet, held: ViewportSize) -> bytes:
    """The page as tall as it is, up to a measure."""
    tall = int(tablet.page.evaluate("document.documentElement.scrollHeight"))
    clip = {"x": 0, "y": 0, "width": held["width"], "height": min(max(tall, held["height"]), TALLEST)}
    return tablet.page.screenshot(full_page=True, clip=clip)  # type: ignore[arg-type]
