"""The service, or an endpoint that does nothing, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager


def served(database_url: str) -> AbstractContextManager[str]:
    """The service over this database, on a free port; yields its address."""
    return _address_of("service", "serve", "--port", "0", "--database-url", database_url)


def served_nothing() -> AbstractContextManager[str]:
    """An endpoint that reads a body and answers, on a free port; yields its address."""
    return _address_of("service.bench.load.noop")


@contextmanager
def _address_of(module: str, *arguments: str) -> Iterator[str]:
    process = subprocess.Popen(  # noqa: S603
        [sys.executable, "-m", module, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None  # noqa: S101
        yield next(word for word in process.stdout.readline().split() if word.startswith("http://"))
    finally:
        process.terminate()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()
