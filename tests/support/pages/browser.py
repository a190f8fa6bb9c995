"""A real browser on a real service: a tablet held upright, touched, with the simulated drum beside it."""

from __future__ import annotations

import re
import shutil
import socket
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

import httpx2
import pytest
import uvicorn
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Page,
    Request,
    ViewportSize,
    sync_playwright,
)

from drivers.clock import ManualClock
from drivers.reading_json import reading_to_dict
from drivers.simulator.drum_driver import SimulatedDrum
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.spec import FittedMass
from service import bootstrap
from service.app import create_app
from service.cli.support.demo_machine import catalogue_of, machine_of
from service.settings import Settings

UPRIGHT: ViewportSize = {"width": 768, "height": 1024}
LYING: ViewportSize = {"width": 1280, "height": 800}
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
NAMES = ("chromium", "chromium-browser", "google-chrome")
PATIENCE_MS = 60_000
READINGS = 12
APART_S = 0.02
"""Quicker than life: only what was taken since the session was opened is live."""


def chromium() -> str:
    """The browser's program; skips the test where there is none."""
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"no browser is installed (looked for {', '.join(NAMES)}); on Debian: apt-get install chromium")
    return found


@contextmanager
def browsing() -> Iterator[Browser]:
    """A browser without a window."""
    program = chromium()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


class Service:
    """The service on one port, with one database; it can be stopped and started again."""

    def __init__(self, url: str) -> None:
        self.settings = Settings(database_url=url, loopback=True)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = int(free.getsockname()[1])
        self.address = f"http://127.0.0.1:{self.port}"
        self.start()

    def start(self) -> None:
        """Listen; comes back once requests are answered."""
        listener = socket.socket()
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", self.port))
        listener.listen(64)
        self._work = bootstrap.build_work(self.settings)
        app = create_app(self.settings, self._work)
        config = uvicorn.Config(app, log_level="error", access_log=False, timeout_graceful_shutdown=5)
        self._server = server = uvicorn.Server(config)
        app.state.ending = lambda: server.should_exit  # as when it is served for real: streams end in order
        self._thread = threading.Thread(target=self._server.run, kwargs={"sockets": [listener]}, daemon=True)
        self._thread.start()
        httpx2.get(f"{self.address}/health", timeout=30).raise_for_status()

    def stop(self) -> None:
        """Stop, as at a restart: the port is closed, the database stays."""
        self._server.should_exit = True
        self._thread.join(20)
        self._work.database.close()


@dataclass
class Bench:
    """A simulated drum whose readings the service gets, and what the API says for the tests' own use."""

    service: Service
    seed: int = 7
    clock: ManualClock = field(default_factory=lambda: ManualClock(datetime.now(UTC)))

    def __post_init__(self) -> None:
        self.spec = threshing_drum_example(self.seed)
        self.drum = SimulatedDrum(self.spec, seed=self.seed, clock=self.clock, source="drum")
        self.drum.__enter__()

    def ask(self, method: str, path: str, body: object = None) -> Any:
        """The answer of the API."""
        answer = httpx2.request(method, f"{self.service.address}/api/v1{path}", json=body, timeout=60)
        assert answer.is_success, answer.text
        return answer.json()

    def machine(self, name: str = "Combine 12", **changes: Any) -> str:
        """A stored machine for the drum, with its source mounted on it."""
        machine = self.ask("POST", "/machines", {**machine_of(self.spec, name, limit_mm_s=0.5), **changes})
        self.mount(machine["id"])
        return str(machine["id"])

    def mount(self, machine: str) -> None:
        """Its readings are of this machine from now on."""
        self.ask("PUT", "/sources/drum", {"machine_id": machine})

    def box(self, name: str = "Workshop box") -> str:
        """A stored box."""
        return str(self.ask("POST", "/catalogues", catalogue_of(name))["id"])

    def session(self, machine: str | None = None, box: str | None = None) -> str:
        """An open session."""
        body = {"machine_id": machine or self.machine(), "catalogue_id": box or self.box()}
        return str(self.ask("POST", "/sessions", body)["id"])

    def turn(self, masses: Iterable[Mapping[str, Any]] = (), *, old: bool = False) -> list[Any]:
        """Let the drum run with these masses: its newest readings are sent, the last one taken now."""
        self.drum.fit_masses(FittedMass(m["plane"], m["mass_g"], m["angle_deg"]) for m in masses)
        wanted = datetime.now(UTC).timestamp() - (3600.0 if old else 0.0) - APART_S * READINGS
        self.clock.advance(max(wanted - self.clock.now().timestamp(), 0.0))
        readings = []
        for _ in range(READINGS):
            self.clock.advance(APART_S)
            readings += self.drum.measure(1)
        self.ask("POST", "/readings", [reading_to_dict(reading) for reading in readings])
        return readings

    def masses_now(self, session: str) -> list[dict[str, Any]]:
        """The masses of the plan that is fitted."""
        document = self.ask("GET", f"/sessions/{session}")
        plan = next(p for p in document["plans"] if p["id"] == document["fitted_plan_id"])
        return [
            {"plane": p["plane"], "mass_g": p["mass_g"] + p["fastener_g"], "angle_deg": p["position_deg"]}
            for p in plan["fitted"]
        ]


class Tablet:
    """One tablet: a page, and everything that went wrong on it; installed: with a service worker."""

    def __init__(
        self,
        browser: Browser,
        address: str,
        *,
        viewport: ViewportSize = UPRIGHT,
        language: str = "en-GB",
        installed: bool = False,
    ) -> None:
        self.address = address
        self.context: BrowserContext = browser.new_context(
            viewport=viewport,
            has_touch=True,
            locale=language,
            reduced_motion="reduce",
            base_url=address,
            service_workers="allow" if installed else "block",
        )
        self.context.set_default_timeout(PATIENCE_MS)
        self.page: Page = self.context.new_page()
        self.errors: list[str] = []
        self.elsewhere: list[str] = []
        self.page.on("console", self._said)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", self._asked)

    def open(self, path: str) -> None:
        """Go to a page; an open stream of events would keep the network busy for ever."""
        self.page.goto(path, wait_until="domcontentloaded")

    def heading(self, text: str) -> None:
        """Wait for the page with this heading."""
        self.page.get_by_role("heading", level=1, name=text, exact=False).wait_for()

    def press(self, text: str) -> None:
        """Touch a button or a link that is one."""
        self.page.locator("button:visible, a:visible, summary:visible").filter(has_text=text).first.tap()

    def tick_all(self) -> None:
        """Tick every box of a stop."""
        for box in self.page.locator(".lock input[type=checkbox]").all():
            box.check()

    def fill(self, name: str, text: str) -> None:
        """Type into a field by its name."""
        self.page.locator(f'[name="{name}"]:visible').first.fill(text)

    def small_targets(self) -> list[str]:
        """What can be touched and is less than 44 px wide or high, words within a sentence excepted."""
        found: list[str] = self.page.evaluate(_SMALL)
        return found

    def serious(self) -> list[str]:
        """What axe-core finds serious or worse."""
        axe = Path(str(files("axe_core_python"))) / "axe.min.js"
        # Evaluated, not put into the page: its content policy lets no script in but our own.
        self.page.evaluate(axe.read_text(encoding="utf-8"))
        found = self.page.evaluate("async () => (await axe.run(document, {resultTypes: ['violations']})).violations")
        return [
            f"{one['id']}: {node['html'][:160]}"
            for one in found
            if one["impact"] in ("serious", "critical")
            for node in one["nodes"]
        ]

    def overflow(self) -> int:
        """By how much the page is wider than the tablet."""
        return int(self.page.evaluate("document.documentElement.scrollWidth - innerWidth"))

    def link_was_cut(self) -> None:
        """Forget what the browser noted of requests without a server: the test cut the link itself."""
        self.errors = [error for error in self.errors if "net::ERR_" not in error]

    def close(self) -> None:
        """Put it away."""
        self.context.close()

    def _said(self, message: ConsoleMessage) -> None:
        # The browser notes every form that is refused with 409 or 422: the page says why, beside the field.
        # Playwright notes each time that it keeps the service worker out.
        refused = re.search(r"status of (409|422) |Service Worker registration blocked", message.text)
        if message.type in ("error", "warning") and not refused:
            self.errors.append(message.text)

    def _asked(self, request: Request) -> None:
        if not request.url.startswith((self.address, "data:")):
            self.elsewhere.append(request.url)


_SMALL = """() => [...document.querySelectorAll('a, button, input:not([type=hidden]), select, summary, textarea')]
  .map((one) => [one, one.closest('label') ?? one])
  .filter(([one, target]) => one.checkVisibility() && !one.closest('.skip, .hide') && one.tabIndex >= 0)
  .map(([one, target]) => [one, target.getBoundingClientRect()])
  .filter(([one, box]) => box.width > 0 && (box.width < 44 || box.height < 44))
  .map(([one, box]) => `${one.outerHTML.slice(0, 120)} is ${Math.round(box.width)} x ${Math.round(box.height)}`)"""
