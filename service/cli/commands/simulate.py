"""`drumtrue simulate`: a simulated drum that sends its readings to a service."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from drivers.bridge.http import HttpOut, Outlet
from drivers.can.bus import parse_bus
from drivers.can.sender import CanOut
from drivers.clock import SystemClock
from drivers.simulator.control_server import ControlPort
from drivers.simulator.drum_driver import threshing_drum_example
from drivers.simulator.runner import run_simulation
from service.cli.support.can_options import mapping_of
from service.cli.support.client import Client
from service.cli.support.demo_machine import catalogue_of, machine_of
from service.cli.support.sources import Simulation
from service.errors import InvalidInput
from service.messages import Message


@dataclass(frozen=True)
class WayOut:
    """Where readings go: opened when the simulation starts, in batches of this many readings."""

    open: Callable[[], Outlet]
    batch_size: int


def out_to_http(url: str, token: str | None = None) -> WayOut:
    """To a service, with a token where it needs one."""
    return WayOut(lambda: HttpOut(url, token=token), batch_size=100)


def out_to_can(bus: str, mapping: Path | None, *, j1939: bool) -> WayOut:
    """Onto a CAN bus, each round at once; the drum's sensors are P and Q. Raises `InvalidSetting`."""
    address, messages = parse_bus(bus), mapping_of(mapping, "P,Q", "1,2", j1939=j1939)
    return WayOut(lambda: CanOut(address, messages), batch_size=1)


def simulate_until_stopped(
    url: str | None,
    token: str | None,
    out: WayOut,
    control: str,
    source: str,
    simulation: Simulation,
    rounds: int | None,
) -> None:
    """Send readings until SIGINT or SIGTERM, or for this many rounds; url: of the service to register the drum at.

    Raises what the service refuses.
    """
    port = _control_address(control)
    if url is not None:
        _register(url, token, source, simulation.seed)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    clock = SystemClock()
    # A sequence number is never used twice, not even by the next start: it counts on from the clock.
    first = int(clock.now().timestamp() * 1000)
    drum = simulation.driver(source, first, clock)
    run_simulation(
        drum,
        out.open(),
        stop=stop,
        batch_size=out.batch_size,
        control=None if port is None else ControlPort(drum, *port),
        rounds=rounds,
        report=lambda line: print(line, flush=True),
    )


def _register(url: str, token: str | None, source: str, seed: int) -> None:
    """Machine and box at the service, found or created, and the source bound to the machine."""
    client = Client(url, token)
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
        raise InvalidInput(Message("invalid_input.control_address", text=text), field="control", value=text)
    return host, int(port)
