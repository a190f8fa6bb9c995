"""Fixtures of the whole service: a database of its own for every test, a workshop over it.

The suites of storage, use cases and the API run on every engine of `tests.support.storage.engines`, the others on the
first of them.
"""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

# The service is imported by the processes that run tests, not by the one that hands them out.
if TYPE_CHECKING:
    from tests.support.http.workshop import Workshop
    from tests.support.storage.engines import Engine

# As the command does, before numpy is imported: threads of small matrices wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# The same examples in every run: a property that fails, fails for everybody.
settings.register_profile("drumtrue", derandomize=True, deadline=None)
settings.load_profile("drumtrue")

ON_EVERY_ENGINE = ("db", "usecases", "runtime", "api")
"""Folders of the suites that run on every engine."""
LONGEST = ("e2e/test_install.py", "e2e/test_faults.py", "e2e/test_can.py", "web/test_browser.py")
"""Files whose tests wait for processes for many seconds: begun last, one of them would run alone at the end."""
OBJECTS_BETWEEN_COLLECTIONS = 20_000


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin the longest first; everything else stays in its order."""
    items.sort(key=lambda item: not item.path.as_posix().endswith(LONGEST))


def pytest_collection_finish() -> None:
    """Keep what imports and collecting made out of the search for garbage: it lives to the end of the run.

    Searched again and again it took a twelfth of the processor time of the tests of the API.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run a test that asks for a database once on each engine that it is for."""
    if "engine" not in metafunc.fixturenames:
        return
    from tests.support.storage.engines import ENGINES

    folder = metafunc.definition.path.relative_to(Path(__file__).parent).parts[0]
    arithmetic = metafunc.definition.get_closest_marker("arithmetic") is not None
    every = folder in ON_EVERY_ENGINE and not arithmetic
    only = metafunc.definition.get_closest_marker("only")
    engines = only.args if only else ENGINES if every else ENGINES[:1]
    metafunc.parametrize("engine", engines, indirect=True, scope="session")


@pytest.fixture(scope="session")
def engine(request: pytest.FixtureRequest) -> Engine:
    """Where databases of the test's engine come from."""
    from tests.support.storage.engines import engine_named

    return engine_named(request.param)


@pytest.fixture
def empty_url(engine: Engine, tmp_path: Path) -> Iterator[str]:
    """Address of an empty database."""
    url = engine.fresh(tmp_path)
    yield url
    engine.drop(url)


@pytest.fixture
def url(engine: Engine, tmp_path: Path) -> Iterator[str]:
    """Address of a migrated database with nothing in it."""
    url = engine.migrated(tmp_path)
    yield url
    engine.drop(url)


@pytest.fixture
def shop(url: str) -> Iterator[Workshop]:
    """A workshop with a database of the test's own."""
    from tests.support.http.workshop import workshop

    with workshop(url) as opened:
        yield opened


@pytest.fixture(scope="module")
def shared_shop(engine: Engine, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workshop]:
    """A workshop that the tests of a module share: for those that store nothing, or do not mind."""
    from tests.support.http.workshop import workshop

    url = engine.migrated(tmp_path_factory.mktemp("shop"))
    with workshop(url) as opened:
        yield opened
    engine.drop(url)
