"""The running simulation: paced by the clock, bounded, stopped cleanly, deaf to a service that is away."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import httpx2
import pytest

from drivers.clock import ManualClock
from drivers.errors import DeliveryFailed, DeliveryRefused, InvalidSetting
from drivers.reading import Reading
from drivers.simulator.control_server import ControlPort
from drivers.simulator.drum_driver import Faults, SimulatedDrum, threshing_drum_example
from drivers.simulator.runner import Totals, run_simulation


class Service:
    """An outlet that takes readings, is away for its first calls, or refuses all."""

    def __init__(self, *, away: int = 0, refuses: bool = False) -> None:
        self.away, self.refuses = away, refuses
        self.batches: list[list[Reading]] = []
        self.most_waiting = 0
        self.closed = False

    def post(self, readings: Sequence[Reading]) -> int:
        self.most_waiting = max(self.most_waiting, len(readings))
        if self.refuses:
            raise DeliveryRefused("refused", status=422, detail="unknown sensor")
        if self.away > 0:
            self.away -= 1
            raise DeliveryFailed("away.")
        self.batches.append(list(readings))
        return len(readings)

    def close(self) -> None:
        self.closed = True


def drum(interval_s: float = 0.1) -> SimulatedDrum:
    return SimulatedDrum(threshing_drum_example(), seed=1, clock=ManualClock(), interval_s=interval_s)


def test_rounds_are_posted_in_batches_by_number() -> None:
    source, service = drum(), Service()
    totals = run_simulation(source, service, stop=threading.Event(), batch_size=6, batch_s=60.0, rounds=10)
    assert totals == Totals(rounds=10, posted=20, retries=0, unsent=0)
    assert [len(batch) for batch in service.batches] == [6, 6, 6, 2]
    assert [one.sequence for batch in service.batches for one in batch] == list(range(1, 21))
    assert service.closed
    assert source.health().state == "closed"


def test_rounds_are_posted_in_batches_by_time() -> None:
    service = Service()
    run_simulation(drum(interval_s=0.5), service, stop=threading.Event(), batch_size=500, batch_s=1.0, rounds=6)
    assert [len(batch) for batch in service.batches] == [6, 6]
    taken = [one.taken_at for batch in service.batches for one in batch]
    assert (taken[-1] - taken[0]).total_seconds() == 2.5


def test_while_the_service_is_away_the_drum_is_not_read_and_nothing_is_lost_or_doubled() -> None:
    source, service, lines = drum(), Service(away=4), list[str]()
    start = source.clock.now()
    totals = run_simulation(source, service, stop=threading.Event(), batch_size=2, rounds=5, report=lines.append)
    assert (totals.posted, totals.retries, totals.unsent) == (10, 4, 0)
    assert [one.sequence for batch in service.batches for one in batch] == list(range(1, 11))
    assert service.most_waiting == 2
    assert (source.clock.now() - start).total_seconds() == pytest.approx(4 * 0.1 + 1 + 2 + 4 + 8)
    assert "Next attempt in 8 s." in "\n".join(lines)


def test_a_refused_batch_ends_it_and_everything_is_closed() -> None:
    source, service = drum(), Service(refuses=True)
    port = ControlPort(source)
    with pytest.raises(DeliveryRefused):
        run_simulation(source, service, stop=threading.Event(), control=port, batch_size=1)
    assert service.closed
    assert source.health().state == "closed"
    port.open()
    port.close()


def test_a_stop_ends_it_with_what_waited_posted() -> None:
    stop, service = threading.Event(), Service()
    lines: list[str] = []

    def report(line: str) -> None:
        lines.append(line)
        if len(service.batches) == 3:
            stop.set()

    totals = run_simulation(drum(), service, stop=stop, batch_size=2, report=report)
    assert (totals.rounds, totals.posted, totals.unsent) == (3, 6, 0)
    assert lines[-1] == "stopped after 6 readings"


def test_a_stop_while_the_service_is_away_says_what_was_not_sent() -> None:
    stop = threading.Event()
    totals = run_simulation(
        drum(), Service(away=1000), stop=stop, batch_size=2, report=lambda line: stop.set() if "8 s" in line else None
    )
    assert (totals.posted, totals.retries, totals.unsent) == (0, 4, 2)


def test_a_stop_before_the_start_reads_nothing() -> None:
    stop, service = threading.Event(), Service()
    stop.set()
    assert run_simulation(drum(), service, stop=stop) == Totals()
    assert service.batches == []


def test_a_drum_that_gives_nothing_can_be_stopped_too() -> None:
    source, service = drum(), Service()
    source.set_faults(Faults(silent=("P", "Q")))
    assert run_simulation(source, service, stop=threading.Event(), rounds=20) == Totals(rounds=20)
    assert source.health().missed == 40


def test_masses_bolted_on_through_the_control_port_show_in_the_readings() -> None:
    source, service, urls = drum(), Service(), list[str]()

    def report(line: str) -> None:
        if line.startswith("control port "):
            urls.append(line.removeprefix("control port "))
        elif len(service.batches) == 1:
            piece = {"plane": "1", "mass_g": 300, "angle_deg": 280}
            assert httpx2.put(f"{urls[0]}/masses", json=[piece], trust_env=False).status_code == 200

    run_simulation(
        source, service, stop=threading.Event(), control=ControlPort(source), batch_size=2, rounds=2, report=report
    )
    before, after = (batch[0].amplitude for batch in service.batches)
    assert after < 0.5 * before


def test_bad_options_are_refused() -> None:
    for options in ({"batch_size": 0}, {"batch_s": -1.0}):
        with pytest.raises(InvalidSetting):
            run_simulation(drum(), Service(), stop=threading.Event(), **options)
