"""A balancer that talks on the bus until its input closes: each reading another one, so that any can be told apart."""

from __future__ import annotations

import select
import sys
import time
from datetime import UTC, datetime

from drivers.can.bus import BusAddress, open_bus
from drivers.can.mapping_file import standard_mapping
from drivers.can.sender import FrameEncoder
from drivers.reading import Reading

STEPS = 50_000
"""Amplitudes of 0.001 mm/s, then the next tenth of a degree."""


def identity(amplitude: float, phase_deg: float) -> int:
    """Which of the readings it is."""
    return round(phase_deg * 10.0) * STEPS + round(amplitude * 1000.0)


def main(rate: int) -> None:
    """Send so many readings of sensor P a second; print how many in all."""
    bus, encoder = open_bus(BusAddress("udp_multicast")), FrameEncoder(standard_mapping(("P",)))
    begun, sent = time.perf_counter(), 0
    while not select.select([sys.stdin], [], [], 0.0)[0]:
        due = int((time.perf_counter() - begun) * rate)
        for number in range(sent, due):
            tenths, steps = divmod(number, STEPS)
            bus.send(encoder.reading(Reading("x", 1, datetime.now(UTC), "P", 0.001 * steps, 0.1 * tenths))[-1])
        sent = due
        time.sleep(0.001)
    bus.shutdown()
    print(sent, flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
