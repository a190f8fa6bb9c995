"""The faults, one after the other, on a service under load."""

from __future__ import annotations

import random
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from service import bootstrap
from service.chaos.crew import Crew
from service.chaos.field_bridge import OFFSETS_S
from service.chaos.gate import Gate
from service.chaos.instances import Instance, faketime
from service.chaos.judging import Judgement, judge
from service.chaos.network import held_connections, hung_database, shown_as_present
from service.chaos.old_database import OldDatabases
from service.chaos.server import Server, own_server
from service.errors import InvalidInput
from service.messages import Message
from service.settings import Settings

PATIENCE_S = 600.0
"""How long everybody may take to end what was begun, once no fault is done any more."""
ROOM_BYTES = 200_000
"""By how much the largest file may still grow when the disk is made to be full."""
SHORT_S = 1.5
"""How long a full disk, or a wrong clock, is worked with."""
FAULTS = (
    "kill",
    "cut",
    "restart",
    "hung_database",
    "disk_full",
    "clock_back",
    "wrong_clock",
    "portal",
    "half_answers",
    "held_connections",
    "killed_migration",
)
ON_A_SERVER = ("cut", "restart", "hung_database")

Say = Callable[[str], None]


@dataclass(frozen=True)
class CampaignOptions:
    """kills: kill -9 of a service. others: how often each of the other faults is done. within_s: longest pause between.

    replicas: services over the one database. only: no other faults than these, besides kills; empty: all. slack_s: by
    how much answers may come later than a machine gives them that has no other load.
    """

    kills: int
    others: int
    engine: str
    replicas: int
    bridges: int = 2
    technicians: int = 3
    seed: int = 1
    within_s: float = 1.0
    only: tuple[str, ...] = ()
    slack_s: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """done: how often each fault was done. not_done: why a fault was not. interrupted: requests without an answer."""

    done: dict[str, int]
    not_done: dict[str, str]
    interrupted: int
    judgement: Judgement


def run(wishes: CampaignOptions, say: Say) -> Outcome:
    """The whole campaign. Raises InvalidInput where it cannot be done as wished."""
    if wishes.replicas > 1 and wishes.engine == "sqlite":
        raise InvalidInput(
            Message("invalid_input.replicas", replicas=wishes.replicas), field="replicas", value=wishes.replicas
        )
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="drumtrue-chaos-")))
        server = stack.enter_context(own_server()) if wishes.engine == "postgresql" else None
        url = server.url if server else f"sqlite:///{folder / 'drumtrue.db'}"
        settings = Settings(database_url=url)
        bootstrap.migrate_database(settings)
        instances = [Instance(url, folder / f"service-{number}.log") for number in range(wishes.replicas)]
        stack.enter_context(_running(instances))
        rng = random.Random(wishes.seed)
        gates = [(Gate(one.port, rng), Gate(one.port, rng)) for one in instances]
        for gate in (gate for pair in gates for gate in pair):
            stack.callback(gate.close)
        crew = Crew(
            [crew_gate.url for crew_gate, _ in gates],
            wishes.bridges,
            wishes.technicians,
            wishes.seed,
            field_urls=[field_gate.url for _, field_gate in gates],
            spools=folder,
        )
        stack.callback(crew.release)  # whatever ends the campaign, its threads must not outlive it
        site = _Site(instances, server, crew, gates, folder, rng, wishes, say)
        done, not_done = site.campaign()
        crew.finish(PATIENCE_S)
        judgement = judge(settings, instances[0].url, crew)
    return Outcome(done, not_done, crew.interrupted, judgement)


@contextmanager
def _running(instances: Sequence[Instance]) -> Iterator[None]:
    try:
        for one in instances:
            one.start()
        yield
    finally:
        for one in instances:
            one.stop()


@dataclass
class _Site:
    instances: list[Instance]
    server: Server | None
    crew: Crew
    gates: list[tuple[Gate, Gate]]
    """Of each instance: that of the crew, and that of the product's own bridge."""
    folder: Path
    rng: random.Random
    wishes: CampaignOptions
    say: Say
    old: OldDatabases | None = None

    def campaign(self) -> tuple[dict[str, int], dict[str, str]]:
        """Faults in random order; how often each was done, and why some could not be."""
        wishes, not_done = self.wishes, self._impossible()
        order = ["kill"] * wishes.kills
        wanted = [name for name in FAULTS[1:] if name not in not_done and name in (wishes.only or FAULTS)]
        order += [name for name in wanted for _ in range(wishes.others)]
        self.rng.shuffle(order)
        self.crew.start()
        done: Counter[str] = Counter()
        for number, name in enumerate(order, 1):
            self._let_work()
            getattr(self, f"_{name}")()
            done[name] += 1
            self.say(f"[{number}/{len(order)}] {name}: {self.crew.promised()} promises kept in mind")
            if self.crew.failures:
                break
        return dict(done), not_done

    def _impossible(self) -> dict[str, str]:
        """Faults that cannot be done here, and why."""
        found: dict[str, str] = {}
        if self.server is None:
            found |= dict.fromkeys(ON_A_SERVER, "SQLite has no server")
        else:
            found["disk_full"] = "the disk that fills up would be the PostgreSQL server's, which is not the product"
        if shutil.which("prlimit") is None:
            found["disk_full"] = "no prlimit: a file's size cannot be limited"
        if faketime() is None:
            found["clock_back"] = "libfaketime is not installed"
        return found

    def _let_work(self) -> None:
        """Until something more was acknowledged, and a random moment longer: that moment is what is tried."""
        before, end = self.crew.promised(), time.monotonic() + PATIENCE_S
        while self.crew.promised() == before and not self.crew.failures and time.monotonic() < end:
            time.sleep(0.01)
        time.sleep(self.rng.uniform(0.0, self.wishes.within_s))

    def _kill(self) -> None:
        one = self.rng.choice(self.instances)
        one.kill()
        one.start()

    def _cut(self) -> None:
        if self.server is not None:
            self.server.cut()

    def _restart(self) -> None:
        if self.server is not None:
            self.server.restart()

    def _hung_database(self) -> None:
        if self.server is not None:
            self.crew.failures += hung_database(self.server, self.instances, self.wishes.slack_s)

    def _held_connections(self) -> None:
        self.crew.failures += held_connections(self.rng.choice(self.instances), self.wishes.slack_s)

    def _wrong_clock(self) -> None:
        """Of the source: what it sends from now on is dated by it."""
        self.crew.field.next_offset_s = self.rng.choice((0.0, *OFFSETS_S))
        self._let_work()
        self.crew.failures += shown_as_present(self.rng.choice(self.instances), self.crew.watched)

    def _portal(self) -> None:
        for _, gate in self.gates:
            gate.become("portal")
        time.sleep(SHORT_S)
        for _, gate in self.gates:
            gate.become("open")

    def _half_answers(self) -> None:
        gates = self.rng.choice(self.gates)
        for gate in gates:
            gate.become("half_answers")
        time.sleep(SHORT_S)
        for gate in gates:
            gate.become("open")

    def _killed_migration(self) -> None:
        self.old = self.old or OldDatabases(self.folder, self.server, self.rng)
        self.crew.failures += self.old.killed()

    def _disk_full(self) -> None:
        largest = max(path.stat().st_size for path in self.folder.glob("drumtrue.db*"))
        self._for_a_while(file_size_limit=largest + ROOM_BYTES)

    def _clock_back(self) -> None:
        self._for_a_while(clock=self.rng.choice(("-1h", "-1d", "-400d")))

    def _for_a_while(self, *, file_size_limit: int | None = None, clock: str | None = None) -> None:
        """Start one service again under a limit, let it work, and start it again without."""
        one = self.rng.choice(self.instances)
        one.stop()
        one.start(file_size_limit=file_size_limit, clock=clock)
        time.sleep(SHORT_S)
        one.kill()
        one.start()
