"""Fixtures of the whole service: a database of its own for every test, a workshop over it.

The suites of storage, use cases and the API run on every engine of `tests.engines`, the others on the first of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.api.workshop import Workshop, workshop
from tests.engines import ENGINES, Engine, engine_named

# The same examples in every run: a property that fails, fails for everybody.
settings.register_profile("drumtrue", derandomize=True, deadline=None)
settings.load_profile("drumtrue")

ON_EVERY_ENGINE = ("db", "usecases", "api")
"""Folders of the suites that run on every engine."""


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run a test that asks for a database once on each engine that it is for."""
    if "engine" not in metafunc.fixturenames:
        return
    folder = metafunc.definition.path.relative_to(Path(__file__).parent).parts[0]
    arithmetic = metafunc.definition.get_closest_marker("arithmetic") is not None
    every = folder in ON_EVERY_ENGINE and not arithmetic
    metafunc.parametrize("engine", ENGINES if every else ENGINES[:1], indirect=True, scope="session")


@pytest.fixture(scope="session")
def engine(request: pytest.FixtureRequest) -> Engine:
    """Where databases of the test's engine come from."""
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
    with workshop(url) as opened:
        yield opened


@pytest.fixture(scope="module")
def shared_shop(engine: Engine, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workshop]:
    """A workshop that the tests of a module share: for those that store nothing, or do not mind."""
    url = engine.migrated(tmp_path_factory.mktemp("shop"))
    with workshop(url) as opened:
        yield opened
    engine.drop(url)
