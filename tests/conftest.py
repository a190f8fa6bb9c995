"""Fixtures of the whole service: a database of its own for every test, a workshop over it.

To run the same tests on another engine, give `ENGINES` a further name and `fresh_database` an address for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.api.workshop import Workshop, workshop

# The same examples in every run: a property that fails, fails for everybody.
settings.register_profile("drumtrue", derandomize=True, deadline=None)
settings.load_profile("drumtrue")

ENGINES = ("sqlite",)


def fresh_database(engine: str, folder: Path) -> str:
    """Address of a database of this engine without any table."""
    assert engine == "sqlite"
    return f"sqlite:///{folder / 'drumtrue.db'}"


@pytest.fixture(params=ENGINES)
def empty_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Address of an empty database."""
    return fresh_database(request.param, tmp_path)


@pytest.fixture
def shop(empty_url: str) -> Iterator[Workshop]:
    """A workshop with a database of the test's own."""
    with workshop(empty_url) as opened:
        yield opened


@pytest.fixture(scope="module", params=ENGINES)
def shared_shop(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workshop]:
    """A workshop that the tests of a module share: for those that store nothing, or do not mind."""
    with workshop(fresh_database(request.param, tmp_path_factory.mktemp("shop"))) as opened:
        yield opened
