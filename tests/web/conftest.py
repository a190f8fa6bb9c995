"""A browser, a service and a simulated drum for each module of tests.

No browser outlives its module: while one is open, its event loop counts as running in every test of the process.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from tests.support.pages.browser import Bench, Service, Tablet, browsing


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """A browser; skips where none is installed."""
    with browsing() as opened:
        yield opened


@pytest.fixture(scope="module")
def bench(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """A service on a port with a drum beside it; after the browser, so that a skip costs nothing."""
    service = Service(f"sqlite:///{tmp_path_factory.mktemp('pages') / 'drumtrue.db'}")
    yield Bench(service)
    service.stop()


@pytest.fixture
def tablet(browser: Browser, bench: Bench) -> Iterator[Tablet]:
    """A tablet held upright; nothing may go wrong on it."""
    opened = Tablet(browser, bench.service.address)
    yield opened
    opened.close()
    assert opened.errors == []
    assert opened.elsewhere == []
