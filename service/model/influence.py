"""Influence coefficients kept from earlier sessions, with their covariance and history."""

from __future__ import annotations

from datetime import datetime

from service.model.base import Name, document

Vector = tuple[float, float]
"""Real and imaginary part."""


@document
class Coefficient:
    """Influence coefficient: change of a sensor's 1x vector for a gram at 0 degrees in a plane."""

    sensor: str
    """Sensor."""
    plane: str
    """Correction plane."""
    speed_rpm: float
    """Nominal speed, r/min."""
    amplitude_per_g: float
    """Amplitude per gram, in the sensor's unit."""
    phase_deg: float
    """Phase, degrees, in the machine's phase sense, for mass angles in the sense that agrees with it."""
    scatter_per_g: float | None
    """Standard deviation per real component; null where it cannot be known."""


@document
class InfluenceRow:
    """One sensor at one nominal speed."""

    sensor: str
    """Sensor."""
    speed_rpm: float
    """Nominal speed, r/min."""
    influence: tuple[Vector, ...]
    """Coefficient of each plane per g, internal sense: phase as lag, mass angle against the rotation."""
    covariance: tuple[tuple[Vector, ...], ...] | None
    """Hermitian covariance over the planes, per real component; null where it is not known."""


@document
class PlaneLearnedOn:
    """A correction plane when its coefficients were learned."""

    name: str
    """Correction plane."""
    radius_mm: float
    """Radius of its positions, mm: a mass acts by its unbalance."""
    axial_mm: float | None = None
    """Axial position, mm from the mass centre; null where it was not stated."""


@document
class SensorLearnedOn:
    """A sensor when its coefficients were learned."""

    name: str
    """Sensor."""
    quantity: str
    """What it measured."""
    unit: str
    """Unit of its amplitudes."""
    detection: str
    """Detection of its amplitudes."""
    axial_mm: float | None = None
    """Axial position, mm from the mass centre; null where it was not stated."""
    direction: str | None = None
    """Direction in which it measured; null where it was not stated."""


@document
class LearnedOn:
    """The machine as it was when its coefficients were learned; their angles and phases have no sense of their own."""

    rotation: str
    """Direction of rotation."""
    planes: tuple[PlaneLearnedOn, ...]
    """Correction planes."""
    sensors: tuple[SensorLearnedOn, ...]
    """Sensors."""


@document
class SavedInfluence:
    """Coefficients of a machine, as kept."""

    planes: tuple[str, ...]
    """Planes, in the order of each row."""
    rows: tuple[InfluenceRow, ...]
    """One row a sensor and speed."""
    sessions: int
    """How many sessions, or machines for a type, are in it."""
    learned_on: LearnedOn | None = None
    """What they were learned on; null in what older versions stored."""


@document
class RefusedUpdate:
    """A coefficient that was not updated: the new one was too far off."""

    sensor: str
    """Sensor."""
    plane: str
    """Correction plane."""
    change: float
    """Relative change of size."""
    turn_deg: float
    """Turn of the angle, degrees."""


@document
class LearnedInfluence:
    """What a machine's coefficients were after a session."""

    id: str
    """Identifier."""
    machine_id: str
    """Machine."""
    session_id: str
    """Session that taught it."""
    learned_at: datetime
    """When, UTC."""
    saved: SavedInfluence
    """The coefficients after it."""
    coefficients: tuple[tuple[Coefficient, ...], ...]
    """The same as amplitude per gram and phase in the machine's senses: [sensor][plane]."""
    refused: tuple[RefusedUpdate, ...]
    """Coefficients that were kept: no update above 50 % or 45 degrees; their whole row stays."""


@document
class LearnRequest:
    """Learn a machine's coefficients from a session."""

    session_id: Name
    """The session; its runs are fitted."""


@document
class TypicalInfluence:
    """Statistics of the coefficients of all machines of one type."""

    type: str
    """Type of machine."""
    machines: int
    """How many machines of it have coefficients."""
    typical: SavedInfluence
    """Their mean, and their spread as the covariance of the next machine."""
    coefficients: tuple[tuple[Coefficient, ...], ...]
    """The same as amplitude per gram and phase: [sensor][plane]."""


@document
class TrialMassSuggestion:
    """Trial mass for a plane."""

    plane: str
    """Correction plane."""
    mass_g: float
    """Suggested mass, g: the smallest that a rule gives."""
    rule: str
    """The rule that gave it: static_load, permissible_unbalance or earlier_coefficient."""
    force_n: float
    """Centrifugal force, N, at service speed."""
    angle_deg: float | None
    """Suggested angle, degrees, opposite to the unbalance by earlier coefficients; null without them."""
    candidates: dict[str, float]
    """What each rule gives, g."""
