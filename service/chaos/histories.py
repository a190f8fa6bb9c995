"""Rounds of requests that several clients make at once, written down to be checked afterwards."""

from __future__ import annotations

import itertools
import random
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from service import bootstrap
from service.chaos.history_checks import Event, check
from service.chaos.history_round import Round
from service.chaos.instances import Instance
from service.chaos.server import own_server
from service.settings import Settings

BETWEEN_KILLS_S = (2.0, 8.0)

Say = Callable[[str], None]


@dataclass(frozen=True)
class HistoryOptions:
    """requests: how many are made in all. replicas: services over the one database. kills: whether they are killed."""

    requests: int
    engine: str
    replicas: int
    kills: bool
    seed: int = 1


@dataclass
class Found:
    """requests: made and checked. statuses: how often each was answered; 0: no answer. kills: of a service."""

    requests: int = 0
    kills: int = 0
    statuses: dict[int, int] = field(default_factory=dict)
    wrong: list[str] = field(default_factory=list)


def run(options: HistoryOptions, say: Say) -> Found:
    """Rounds until this many requests were made, or something is wrong."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="drumtrue-histories-")))
        server = stack.enter_context(own_server()) if options.engine == "postgresql" else None
        url = server.url if server else f"sqlite:///{folder / 'drumtrue.db'}"
        bootstrap.migrate_database(Settings(database_url=url))
        instances = [Instance(url, folder / f"service-{number}.log") for number in range(options.replicas)]
        for one in instances:
            stack.callback(one.stop)
            one.start()
        found, rng = Found(), random.Random(options.seed)
        killing = stack.enter_context(_killing(instances, rng, found)) if options.kills else None
        for number in itertools.count(1):
            groups = Round([one.url for one in instances], number, random.Random(rng.random()), options.kills).events()
            for events in groups.values():
                found.wrong += check(events, killed=options.kills)
                _count(found, events)
            say(f"[{found.requests}/{options.requests}] round {number}, {found.kills} kills, {len(found.wrong)} wrong")
            if found.requests >= options.requests or found.wrong or (killing is not None and not killing.is_alive()):
                return found
    raise AssertionError


def _count(found: Found, events: Sequence[Event]) -> None:
    found.requests += len(events)
    for event in events:
        found.statuses[event.status or 0] = found.statuses.get(event.status or 0, 0) + 1


@contextmanager
def _killing(instances: Sequence[Instance], rng: random.Random, found: Found) -> Iterator[threading.Thread]:
    """For the length of a block services are killed, one after the other, and started again."""
    over, moments = threading.Event(), random.Random(rng.random())

    def kill() -> None:
        while not over.wait(moments.uniform(*BETWEEN_KILLS_S)):
            one = moments.choice(instances)
            one.kill()
            one.start()
            found.kills += 1

    thread = threading.Thread(target=kill, name="kills")
    thread.start()
    try:
        yield thread
    finally:
        over.set()
        thread.join()
