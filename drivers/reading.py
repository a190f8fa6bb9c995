"""The one Reading type: on the wire, in a driver, in a recording."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True, slots=True)
class Reading:
    """One sensor at one moment, as its source states it.

    source, sequence: who measured, and a number that the source never uses twice. taken_at: aware, UTC.
    amplitude: 1x component in the sensor's declared quantity, unit and detection, >= 0. phase_deg: in the machine's
    phase sense; None where the source has no key-phasor. scatter: standard deviation of the 1x vector per real
    component, in the amplitude's unit. overall_rms: broadband value, same unit. session_id: None for a source that is
    bound to a machine.
    """

    source: str
    sequence: int
    taken_at: datetime
    sensor: str
    amplitude: float
    phase_deg: float | None = None
    speed_rpm: float | None = None
    scatter: float | None = None
    overall_rms: float | None = None
    session_id: str | None = None
