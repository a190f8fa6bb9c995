"""Where long work runs: here, on the cores of this machine, or on a Dask cluster (docs/decisions/batch-work.md).

All of them are `concurrent.futures` executors: work is a module's function with arguments that can be pickled, never a
path that only one machine has.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any

from service.errors import InvalidInput, Unavailable
from service.messages import Message

CONNECT_S = 5.0
"""Longer than a scheduler in the same building takes to answer."""


class Here(Executor):
    """Each call is made at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """The result is there when this returns; what the call raises is raised by the future."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as wrong:
            future.set_exception(wrong)
        return future


@contextmanager
def executor(workers: int | None = None, cluster: str | None = None) -> Iterator[Executor]:
    """Where to run.

    workers: processes on this machine, all cores by default; 1 is this process itself. cluster: address of a Dask
    scheduler (tcp://HOST:8786), whose workers have Drumtrue installed in the same version. Raises InvalidInput where
    Dask is not installed, Unavailable where no scheduler answers or it has no worker.
    """
    if cluster is not None:
        with _dask(cluster) as found:
            yield found
        return
    count = workers or os.cpu_count() or 1
    if count == 1:
        yield Here()
        return
    # A fresh process each: the numerics' threads and a forked lock do not go together.
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        yield pool


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise InvalidInput(Message("invalid_input.distributed_missing"), field="cluster", value=address) from None
    try:
        client: Any = Client(address, timeout=CONNECT_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as wrong:
        raise Unavailable(
            Message("unavailable.scheduler", address=address, reason=wrong), field="cluster", value=address
        ) from None
    try:
        _require_workers(client, address)
        # pure=False: two equal pieces of work are two pieces of work.
        yield client.get_executor(pure=False)
    finally:
        client.close()


def _require_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=CONNECT_S)
    except TimeoutError:
        raise Unavailable(Message("unavailable.workers", address=address), field="cluster", value=address) from None
