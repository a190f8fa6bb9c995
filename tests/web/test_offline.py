"""Pages where the link does not hold: cut before each tap, the service killed in between, nothing lost or doubled."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.sync_api import Browser

from tests.support.pages.browser import Bench, Tablet

KEPT = ".waiting:visible"


@pytest.fixture
def installed(browser: Browser, bench: Bench) -> Iterator[Tablet]:
    """A tablet on which the pages are installed."""
    opened = Tablet(browser, bench.service.address, installed=True)
    opened.open("/")
    opened.page.evaluate("navigator.serviceWorker.ready")
    opened.page.wait_for_function("navigator.serviceWorker.controller !== null")
    yield opened
    opened.close()
    opened.link_was_cut()
    assert (opened.errors, opened.elsewhere) == ([], [])


@contextmanager
def away(bench: Bench) -> Iterator[None]:
    """The service is killed and started again."""
    bench.service.stop()
    yield
    bench.service.start()


@contextmanager
def unlinked(tablet: Tablet) -> Iterator[None]:
    """The tablet has no link."""
    tablet.context.set_offline(True)
    yield
    tablet.context.set_offline(False)


def test_the_installed_pages_open_without_any_network(installed: Tablet, bench: Bench) -> None:
    with away(bench):
        installed.page.goto("/", wait_until="domcontentloaded")
        installed.heading("Balance a drum")
        installed.page.get_by_text("This page is as it was at").wait_for()
        assert installed.overflow() <= 0
        assert installed.serious() == []
        installed.page.goto("/boxes/new", wait_until="domcontentloaded")
        installed.heading("No connection to the server")
        assert installed.serious() == []
    installed.heading("A new box")


def test_a_tablet_can_install_the_pages(installed: Tablet) -> None:
    told: dict[str, Any] = installed.page.evaluate(
        "fetch(document.querySelector('link[rel=manifest]').href).then((answer) => answer.json())"
    )
    assert (told["start_url"], told["display"]) == ("/", "standalone")
    sizes = installed.page.evaluate(
        """(icons) => Promise.all(icons.map((icon) => new Promise((resolve) => {
            const image = new Image();
            image.onload = () => resolve(`${image.naturalWidth}x${image.naturalHeight}`);
            image.src = icon.src;
        })))""",
        told["icons"],
    )
    assert sizes[1:] == [icon["sizes"] for icon in told["icons"][1:]]


READINGS = {
    "as found": ("3.15", "138", "5.62", "148"),
    "plane 1": ("2.24", "96", "4.91", "139"),
    "plane 2": ("2.62", "141", "3.05", "118"),
    "check": ("0.21", "60", "0.34", "80"),
}


def walk(tablet: Tablet, session: str, tap: Callable[[str], None]) -> None:
    """A whole session, typed; every touch of a button goes through `tap`."""
    tablet.open(f"/sessions/{session}")

    def typed(name: str) -> None:
        if tablet.page.locator("details.typed[open]").count() == 0:
            tablet.press("Type the run in")
        for field, text in zip(
            (f"readings[{i}].{part}" for i in (0, 1) for part in ("amplitude", "phase_deg")),
            READINGS[name],
            strict=True,
        ):
            tablet.fill(field, text)
        tap("Store this run")

    def stop(change: str) -> None:
        tablet.heading("Stop the machine and lock it")
        tablet.tick_all()
        tap("Locked, go on")
        tablet.page.get_by_role("button", name=change).wait_for()
        tap(change)
        tablet.heading("Before the drum turns again")
        tablet.tick_all()
        tap("Ready to run")

    tablet.heading("Run the drum as found")
    typed("as found")
    for plane in ("1", "2"):
        tablet.heading(f"Trial run in plane {plane}")
        tap("Stop the machine to bolt it on")
        stop("The mass is bolted on")
        tablet.heading("Run with the trial mass")
        typed(f"plane {plane}")
    tablet.heading("The runs are enough")
    tap("Compute")
    tablet.heading("What the drum needs")
    tap("Choose the pieces")
    tablet.heading("Find the best pieces")
    tap("Find the best")
    tablet.heading("The best choice from the box")
    tap("Fit this")
    stop("All is bolted on as shown")
    tablet.heading("Run the drum to check it")
    typed("check")
    tablet.press("Close the session")
    tap("Close it for good")
    tablet.heading("Finished")


def facts(bench: Bench, session: str) -> Any:
    """What a session's documents say, without keys and times."""
    return _without(bench.ask("GET", f"/sessions/{session}"))


def _without(value: Any) -> Any:
    if isinstance(value, dict):
        return {
            name: _without(one)
            for name, one in value.items()
            if name not in ("seconds", "evaluations", "version")
            and not name.endswith(("id", "_at", "until", "seed", "ids"))
        }
    return [_without(one) for one in value] if isinstance(value, list) else value


def test_cut_before_each_tap_the_session_ends_with_the_same_documents(installed: Tablet, bench: Bench) -> None:
    machine = bench.machine("Cut off")
    calm, cut = (bench.session(machine, bench.box(f"Box {name}")) for name in ("calm", "cut"))
    walk(installed, calm, installed.press)
    taps: list[str] = []

    def tap(words: str) -> None:
        killed = len(taps) % 4 == 0
        with away(bench) if killed else unlinked(installed):
            installed.press(words)
            waits = installed.page.locator(KEPT)
            waits.or_(installed.page.get_by_role("heading", name="No connection to the server")).first.wait_for()
            if killed and waits.count():  # the tablet dies too, and is opened again
                installed.page.goto(f"/sessions/{cut}", wait_until="domcontentloaded")
                waits.wait_for()
        taps.append(words)

    walk(installed, cut, tap)
    assert len(taps) >= 20, "each step, each safety list"
    assert facts(bench, cut) == facts(bench, calm)
