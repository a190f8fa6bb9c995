"""Corrections: influence coefficients, continuous masses, predictions, diagnostics."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len

from db.documents.base import Name, document
from db.documents.run import MassOnRotor

CorrectionSource = Literal["fit", "balancer"]
Severity = Literal["info", "warning", "error"]


@document
class CorrectionRequest:
    """Ask for the continuous correction masses."""

    source: CorrectionSource
    """fit: least squares over all runs that are not excluded; balancer: an answer that a balancer computed."""
    method: Literal["least_squares"] | None = None
    """How the masses follow from the influence coefficients; only with `fit`."""
    masses: Annotated[tuple[MassOnRotor, ...], Len(1, 64)] | None = None
    """The balancer's answer: the total to have on the as-found rotor, trial masses off."""
    answer_id: Name | None = None
    """Or the identifier of a stored balancer answer."""


@document
class Interval:
    """An interval, in the unit of the value it belongs to."""

    low: float
    """Lower end."""
    high: float
    """Upper end."""
    confidence: float
    """Share of such intervals that hold the true value."""


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
class SensorVector:
    """1x vector of a sensor, measured or predicted."""

    sensor: str
    """Sensor."""
    speed_rpm: float
    """Nominal speed, r/min."""
    amplitude: float
    """1x amplitude in the sensor's quantity, unit and detection."""
    phase_deg: float
    """Phase, degrees, in the machine's phase sense."""
    scatter: float | None = None
    """Standard deviation per real component of the vector; null where it cannot be known."""
    interval: Interval | None = None
    """Interval of the amplitude; null where it cannot be known."""
    limit: float | None = None
    """The limit that applies, in the sensor's unit; null without one."""


@document
class PlaneMass:
    """Continuous correction mass of a plane."""

    plane: str
    """Correction plane."""
    mass_g: float
    """Mass, g: the total to have on the as-found rotor."""
    angle_deg: float
    """Angle, degrees, in the machine's angle sense."""
    unbalance_gmm: float
    """Mass times radius, g.mm."""
    interval: Interval | None = None
    """Interval of the mass, g; null where it cannot be known."""
    angle_interval: Interval | None = None
    """Interval of the angle, degrees about `angle_deg`; null where it cannot be known."""


@document
class Diagnostic:
    """Something the technician should know."""

    code: str
    """Stable code."""
    severity: Severity
    """info, warning or error."""
    message: str
    """What was seen, with its value."""
    advice: str
    """What to do."""


@document
class Correction:
    """Continuous correction masses and where they come from."""

    id: str
    """Identifier."""
    number: int
    """1, 2, 3 ... in the order of the session."""
    request: CorrectionRequest
    """What was asked for."""
    runs: tuple[int, ...]
    """Numbers of the runs that entered the fit."""
    influence: tuple[tuple[Coefficient, ...], ...]
    """[sensor][plane]; a further block of rows for each further speed. Empty for a balancer's answer."""
    initial: tuple[SensorVector, ...]
    """Vibration of the as-found rotor, as fitted."""
    corrections: tuple[PlaneMass, ...]
    """The TOTAL to have on the as-found rotor, trial masses off; one mass a plane."""
    trim: tuple[PlaneMass, ...]
    """That total minus what was on the rotor in the latest run."""
    predicted: tuple[SensorVector, ...]
    """Vibration to expect with the corrections fitted exactly."""
    diagnostics: tuple[Diagnostic, ...]
    """What the technician should know, worst first."""
    stale: bool = False
    """True: a run was added or excluded since."""
