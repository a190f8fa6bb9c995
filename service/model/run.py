"""Runs, readings as stated in them, and answers of a balancer."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from service.model.base import (
    MAX_LIST,
    AngleDeg,
    Finite,
    Moment,
    Name,
    NotNegative,
    Positive,
    Reason,
    Scatter,
    Sequence,
    document,
)
from service.model.diagnostic import Diagnostic
from service.model.findings import Findings

RunKind = Literal["initial", "trial", "check", "correction"]


@document
class MassOnRotor:
    """A mass on the rotor relative to the as-found rotor; removed or drilled material is negative."""

    plane: Name
    """Correction plane."""
    mass_g: Finite
    """Mass, g; negative where mass was taken off."""
    angle_deg: AngleDeg
    """Angle, degrees from the key-phasor mark in the machine's angle sense; any angle."""


@document
class RunReading:
    """What one sensor said in a run."""

    sensor: Name
    """Sensor of the session's machine."""
    amplitude: NotNegative
    """1x amplitude in the sensor's quantity, unit and detection."""
    phase_deg: AngleDeg | None
    """Phase, degrees, in the machine's phase sense; null where there was no key-phasor."""
    speed_rpm: Positive | None = None
    """Speed, r/min, at which it was taken."""
    scatter: Scatter | None = None
    """Standard deviation of the 1x vector per real component, of the mean if averaged; in the amplitude's unit."""
    overall_rms: NotNegative | None = None
    """Broadband value beside the 1x amplitude, rms, in the sensor's unit."""
    findings: Findings | None = None
    """What the signal chain found beside it, where it was measured from blocks of waveforms."""


@document
class Take:
    """A run taken from the stored readings of a source between two times."""

    source: Name
    """The source that measured."""
    since: Annotated[Moment, Field(alias="from")]
    """First moment, RFC 3339."""
    until: Annotated[Moment, Field(alias="to")]
    """Last moment, RFC 3339."""
    received_from: Moment | None = None
    """Only readings that the service received then or later, RFC 3339: a source's clock may have been set meanwhile."""


@document
class RunRequest:
    """A run to store: all masses on the rotor during it, and what the sensors said."""

    kind: RunKind
    """initial (as found), trial, check (after a fitted plan), correction (any other run with correction masses)."""
    masses: Annotated[tuple[MassOnRotor, ...], MAX_LIST] | None = None
    """ALL masses on the rotor, relative to the as-found rotor; a check run defaults to the fitted plan."""
    readings: Annotated[tuple[RunReading, ...], Len(1, 1000)] | None = None
    """What the sensors said, one reading a sensor; or use `take`."""
    take: Take | None = None
    """Take the run from stored readings instead: averaged as vectors, with their scatter."""
    nominal_speed_rpm: Positive | None = None
    """Speed, r/min, the run was meant to have; default: the service speed."""
    supersedes: Name | None = None
    """Identifier of a mistyped run that this one replaces; that run is kept, excluded."""


@document
class RunPatch:
    """Exclude a mistyped run, or take it in again; a run is never erased."""

    excluded: bool
    """True: the run no longer enters the fit."""
    reason: Reason
    """Why."""


@document
class Run:
    """A stored run."""

    id: str
    """Identifier."""
    number: int
    """1, 2, 3 ... in the order of the session."""
    kind: RunKind
    """Kind of run."""
    masses: tuple[MassOnRotor, ...]
    """ALL masses on the rotor during the run, relative to the as-found rotor; g and degrees."""
    readings: tuple[RunReading, ...]
    """What the sensors said."""
    nominal_speed_rpm: float
    """Speed, r/min, the run was meant to have."""
    taken_at: datetime
    """When it was stored, UTC."""
    excluded: bool = False
    """True: it does not enter the fit."""
    reason: str | None = None
    """Why it was excluded or taken in again."""
    warnings: tuple[Diagnostic, ...] = ()
    """What the technician should know of its masses."""


@document
class RunOut:
    """Run-out vector of a sensor, subtracted from every reading of it."""

    sensor: Name
    """Sensor of the machine."""
    amplitude: NotNegative
    """Amplitude in the sensor's unit."""
    phase_deg: AngleDeg
    """Phase, degrees, in the machine's phase sense."""


@document
class BalancerAnswer:
    """Continuous correction masses that a field balancer computed."""

    source: Name
    """The balancer."""
    sequence: Sequence
    """A number the source never uses twice."""
    taken_at: Moment
    """When, RFC 3339."""
    session_id: str | None = None
    """Session; without it the session open on the machine that the source is bound to."""
    masses: Annotated[tuple[MassOnRotor, ...], Len(1, 64)]
    """Masses to add to the as-found rotor, trial masses off; one a plane."""
