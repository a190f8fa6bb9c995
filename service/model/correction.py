"""Corrections: influence coefficients, continuous masses, predictions, diagnostics."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le, Len

from service.model.base import Name, Positive, document
from service.model.diagnostic import Diagnostic
from service.model.influence import Coefficient, SavedInfluence
from service.model.message import MessageData
from service.model.run import MassOnRotor, Run

Assumption = Literal["rigid_rotor", "no_bow"]
CorrectionMethod = Literal["least_squares", "weighted", "minimax", "static_couple"]
CorrectionSource = Literal["fit", "balancer", "saved_influence", "amplitude_only"]


@document
class CorrectionRequest:
    """Ask for the continuous correction masses."""

    source: CorrectionSource
    """fit: all runs that are not excluded; balancer: an answer that a balancer computed; saved_influence: the machine's
    coefficients and the latest run; amplitude_only: runs without phase."""
    method: CorrectionMethod | None = None
    """How the masses follow from the coefficients. least_squares (default): all sensors count alike, those of
    different quantity, unit or detection by the vibration velocity in mm/s rms that they mean; weighted: each by its
    limit; minimax: the greatest amplitude over limit becomes smallest; static_couple: two planes, a sensor
    at each end, static and couple part by themselves."""
    damping: Annotated[float, Ge(0), Le(10)] | None = None
    """Damping of the least squares, as a share of the greatest singular value; for planes that buck each other."""
    max_mass_g: Positive | None = None
    """Greatest continuous mass, g, in each plane."""
    planes: Annotated[tuple[Name, ...], Len(1, 8)] | None = None
    """Correct in these planes only; the others keep what the latest run had in them."""
    mounted_later: Annotated[tuple[MassOnRotor, ...], Len(1, 64)] | None = None
    """Parts mounted after balancing, at the plane's radius: the drum is to run well with them."""
    earlier_sessions: Annotated[tuple[Name, ...], Len(1, 20)] | None = None
    """Earlier sessions of the same machine whose runs enter the fit; each keeps an as-found vibration of its own."""
    influence_of: Literal["machine", "type"] | None = None
    """Whose coefficients saved_influence takes: the machine's own (default), or the mean of its type."""
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
    """Interval of the amplitude of the true vector; null where it cannot be known."""
    limit: float | None = None
    """The limit that applies, in the sensor's unit; null without one."""
    reading_interval: Interval | None = None
    """Interval of the amplitude that the next run will read: the true vector, its repeatability and the scatter of a
    reading; null where it cannot be known."""


@document
class Ellipse:
    """Region of a mass vector's tip that holds the true one, centred on the vector."""

    major_g: float
    """Longer semi-axis, g."""
    minor_g: float
    """Shorter semi-axis, g."""
    angle_deg: float
    """Angle of the longer axis, degrees, in the machine's angle sense."""
    confidence: float
    """Share of such regions that hold the true vector."""


@document
class StaticCouple:
    """Masses of two planes taken apart: static plus couple gives the masses."""

    static: tuple[PlaneMass, ...]
    """Static part: its resultant at the mass centre."""
    couple: tuple[PlaneMass, ...]
    """Couple part: no resultant."""
    unbalance_gmm: float
    """Resultant unbalance, g.mm."""
    moment_gmm2: float
    """Moment about the mass centre, g.mm2."""


@document
class BearingTolerance:
    """Residual unbalance in a bearing plane."""

    bearing: str
    """Bearing."""
    permissible_gmm: float
    """Permissible residual unbalance, g.mm."""
    residual_gmm: float
    """Residual unbalance of the rotor as it was in the latest run, g.mm."""


@document
class Tolerance:
    """Balance quality by ISO 21940-11, of the rotor as it was in the latest run."""

    grade_mm_s: float
    """Balance quality grade asked for, mm/s."""
    permissible_gmm: float
    """Permissible residual unbalance U_per, g.mm."""
    specific_um: float
    """Permissible specific unbalance e_per, um."""
    bearings: tuple[BearingTolerance, ...]
    """Allocated to the bearing planes."""
    grade_reached_mm_s: float
    """Grade reached, mm/s."""
    interval: Interval | None
    """Interval of the grade reached; null where it cannot be known."""
    within: bool
    """Whether the grade reached is within the grade asked for."""
    surely: bool
    """Deprecated: whether the upper end of the interval is within the grade too; it holds under `assumptions` only."""
    assumptions: tuple[Assumption, ...] = ()
    """What the figures assume and the runs do not show: rigid_rotor: the rotor does not bend at its speed; no_bow: all
    vibration at the speed of rotation comes from unbalance, nothing of it from a bow, run-out or the drive."""


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
    ellipse: Ellipse | None = None
    """Region that holds the true vector; null where it cannot be known."""


@document
class Repeatability:
    """How well the machine repeats its vibration from start to start, as the intervals take it."""

    share: float
    """Standard deviation of a 1x vector from start to start, as a share of its amplitude, both components together."""
    source: Literal["stated", "learned", "default"]
    """stated of the machine; learned from runs of the same masses; or the usual value."""
    degrees_of_freedom: int | None
    """Real degrees of freedom of the runs it was learned from; null where it was not."""


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
    static_couple: StaticCouple | None
    """The corrections taken apart; null but for two planes with the mass centre between them."""
    tolerance: Tolerance | None
    """Balance quality of the rotor in the latest run; null without grade, rotor mass, bearings or coefficients."""
    alternatives: tuple[tuple[PlaneMass, ...], ...]
    """Other corrections that explain amplitudes without phase as well."""
    saved_influence: SavedInfluence | None
    """The coefficients that a correction of source saved_influence took."""
    earlier_runs: tuple[tuple[Run, ...], ...]
    """Runs of the earlier sessions that entered the fit, a tuple a session."""
    diagnostics: tuple[Diagnostic, ...]
    """What the technician should know, worst first."""
    on_rotor: tuple[MassOnRotor, ...] | None = None
    """ALL masses on the rotor when it was asked for, which `trim` is counted from; null: those of the latest run."""
    stale: bool = False
    """True: a run was added or excluded since."""
    tolerance_missing: str | None = None
    """Why `tolerance` is null although the machine states a grade; null otherwise."""
    tolerance_missing_data: MessageData | None = None
    """`tolerance_missing` as data."""
    repeatability: Repeatability | None = None
    """What the intervals take for the repeatability of the machine; null for a balancer's answer."""
