"""Corrections: influence coefficients, continuous masses, predictions, diagnostics."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le, Len

from db.documents.base import Name, Positive, document
from db.documents.run import MassOnRotor

CorrectionMethod = Literal["least_squares", "weighted", "minimax"]
CorrectionSource = Literal["fit", "balancer"]
Severity = Literal["info", "warning", "error"]


@document
class CorrectionRequest:
    """Ask for the continuous correction masses."""

    source: CorrectionSource
    """fit: least squares over all runs that are not excluded; balancer: an answer that a balancer computed."""
    method: CorrectionMethod | None = None
    """How the masses follow from the influence coefficients; only with `fit`. least_squares (default): all sensors
    count alike; weighted: each by its limit; minimax: the greatest amplitude over limit becomes smallest."""
    damping: Annotated[float, Ge(0), Le(10)] | None = None
    """Damping of the least squares, as a share of the greatest singular value; for planes that buck each other."""
    max_mass_g: Positive | None = None
    """Greatest continuous mass, g, in each plane."""
    planes: Annotated[tuple[Name, ...], Len(1, 8)] | None = None
    """Correct in these planes only; the others keep what the latest run had in them."""
    mounted_later: Annotated[tuple[MassOnRotor, ...], Len(1, 64)] | None = None
    """Parts mounted after balancing, at the plane's radius: the drum is to run well with them."""
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
class FitQuality:
    """How well the runs determine the influence coefficients, and how near the method came to its aim."""

    condition: float | None
    """Condition number of the coefficients, columns scaled to length 1; null where planes are dependent."""
    significance: tuple[float, ...]
    """Darlow's significance of each plane, 0 to 1; at most 0.2 marks a plane that does what others do."""
    degrees_of_freedom: tuple[int, ...]
    """Real degrees of freedom left for each predicted vector; 0: the runs just determine it."""
    objective_value: float
    """What the method made small: root of the sum of squares, or greatest, of the weighted amplitudes."""
    lower_bound: float
    """No admissible masses come below it."""


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
    runs: tuple[int, ...] = ()
    """Numbers of the runs it is about; empty: all."""
    planes: tuple[str, ...] = ()
    """Planes it is about; empty: all."""
    sensors: tuple[str, ...] = ()
    """Sensors it is about; empty: all."""


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
    quality: FitQuality | None
    """How well the runs determine the influence coefficients; null for a balancer's answer."""
    diagnostics: tuple[Diagnostic, ...]
    """What the technician should know, worst first."""
    stale: bool = False
    """True: a run was added or excluded since."""
