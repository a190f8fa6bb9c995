"""`drumtrue simulate`: a simulated drum that sends its readings to a service."""

from __future__ import annotations

import signal
import threading

from drivers.clock import SystemClock
from drivers.control import ControlPort
from drivers.http_out import HttpOut
from drivers.simulate import run_simulation
from drivers.simulated import SimulatedDrum, threshing_drum_example
from service.cli.client import Client
from service.cli.hardware import catalogue_of, machine_of
from service.errors import InvalidInput


def simulate_until_stopped(
    url: str, control: str, source: str, seed: int, interval_s: float, rounds: int | None, *, register: bool
) -> None:
    """Send readings until SIGINT or SIGTERM, or for so many rounds. Raises what the service refuses."""
    spec = threshing_drum_example(seed)
    port = _control_address(control)
    if register:
        _register(url, source, seed)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    clock = SystemClock()
    # A sequence number is never used twice, not even by the next start: it counts on from the clock.
    first = int(clock.now().timestamp() * 1000)
    drum = SimulatedDrum(spec, seed=seed, clock=clock, source=source, sequence_start=first, interval_s=interval_s)
    run_simulation(
        drum,
        HttpOut(url),
        stop=stop,
        control=None if port is None else ControlPort(drum, *port),
        rounds=rounds,
        report=lambda line: print(line, flush=True),
    )


def _register(url: str, source: str, seed: int) -> None:
    """Machine and box at the service, found or created, and the source bound to the machine."""
    client = Client(url)
    try:
        name = f"Simulated drum {seed}"
        machine = client.find_or_create("/machines", machine_of(threshing_drum_example(seed), name))
        box = client.find_or_create("/catalogues", catalogue_of("Stock masses of the simulated drums"))
        client.put(f"/sources/{source}", {"machine_id": machine["id"]})
        print(f"machine {machine['id']} ({name}), catalogue {box['id']}, source {source!r}", flush=True)
    finally:
        client.close()


def _control_address(text: str) -> tuple[str, int] | None:
    if not text:
        return None
    host, _, port = text.rpartition(":")
    if not host or not port.isdigit() or int(port) > 65535:
        raise InvalidInput(
            f"{text!r} is no address", field="control", value=text, advice="state HOST:PORT, such as 127.0.0.1:8100"
        )
    return host, int(port)
