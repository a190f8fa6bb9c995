"""The report of a session: what a certificate and a before/after table are made from."""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from service.model.base import document
from service.model.correction import Tolerance
from service.model.diagnostic import Diagnostic
from service.model.influence import Coefficient
from service.model.machine import Machine
from service.model.message import MessageData
from service.model.plan import BearingForces, Placement, PlanStatus
from service.model.run import MassOnRotor
from service.model.session import SessionSummary

Zone = Literal["A", "B", "C", "D"]
Outcome = Literal["unchecked", "above_limit", "grade_not_reached", "partly_judged", "nothing_asked", "reached"]


@document
class BeforeAfter:
    """A sensor before and after balancing."""

    sensor: str
    """Sensor."""
    unit: str
    """Unit and detection of the amplitudes, such as mm/s rms."""
    speed_rpm: float
    """Nominal speed, r/min."""
    before: float
    """1x amplitude of the as-found rotor: first initial run, run-out subtracted."""
    after: float | None
    """1x amplitude of the latest check run of the masses that are on the drum now; null before one."""
    reduction: float | None
    """1 - after / before; null where it cannot be known, as where the two were measured at different speeds."""
    limit: float | None
    """Limit that applies; null without one."""
    within_limit: bool | None
    """Whether `after` is within the limit; null where it cannot be known."""
    zone_before: Zone | None = None
    """Zone of ISO 20816-3 before, by the broadband velocity; null unless the machine states its group."""
    zone_after: Zone | None = None
    """Zone after; null as above."""
    before_rpm: float | None = None
    """Speed measured with `before`, r/min; null where none was."""
    after_rpm: float | None = None
    """Speed measured with `after`, r/min; null where none was."""


@document
class Verdict:
    """What is known of the drum as it is now, compared with what was asked for."""

    outcome: Outcome
    """unchecked: not measured as it is now at every speed and by every sensor with a limit; above_limit;
    grade_not_reached; partly_judged: vibration within its limits, balance quality asked for and not judged;
    nothing_asked: measured, no limit and no grade stated; reached: all that was asked for."""
    check_runs: tuple[int, ...]
    """Numbers of the check runs that measured the drum as it is now."""
    unjudged: tuple[Diagnostic, ...]
    """What was asked for and could not be judged, each with its reason."""
    above: tuple[str, ...]
    """Sensors above their limit, with the speed where there are several."""


@document
class PlaneLoad:
    """What is bolted into a plane, of all trims together."""

    plane: str
    """Correction plane."""
    pieces: tuple[Placement, ...]
    """The pieces, round the drum."""
    carried_g: float
    """Their mass in all, fasteners included, g."""
    as_one: MassOnRotor
    """The one mass that does what they do together: g and degrees; without what was taken off the as-found rotor."""
    saved: float
    """Share of `carried_g` that one such mass would save: what the pieces pull against each other. Plan mode combine
    replaces the pieces by the fewest stock masses that do as well."""


@document
class Report:
    """The report of a session."""

    session: SessionSummary
    """The session."""
    version: str
    """Version of Drumtrue."""
    written_at: datetime
    """When the report was written, UTC."""
    machine: Machine
    """The machine with its conventions."""
    conventions: tuple[str, ...]
    """The conventions as text."""
    runs: int
    """Runs stored."""
    excluded_runs: tuple[int, ...]
    """Numbers of the runs that were excluded."""
    before_after: tuple[BeforeAfter, ...]
    """Each sensor before and after."""
    fitted: tuple[Placement, ...]
    """The stock masses on the drum."""
    planes: tuple[PlaneLoad, ...]
    """Each plane with the pieces of all trims, and the one mass they come to; empty without a fitted plan."""
    plan_status: PlanStatus | None
    """What was proved of the plan that is fitted; null without one."""
    plan_gap: float | None
    """How much better, at most, another selection could be, in `plan_unit`; null where nothing is proved."""
    plan_unit: str | None
    """Unit of the gap."""
    bearing_forces_n: BearingForces | None
    """Reactions before and after, N; null where the geometry is not known."""
    tolerance: Tolerance | None
    """Balance quality by ISO 21940-11 of the rotor as it is now, from all runs; null where it cannot be known."""
    tolerance_missing: str | None
    """Why `tolerance` is null although the machine states a grade; null otherwise."""
    influence: tuple[tuple[Coefficient, ...], ...]
    """Influence coefficients from all runs; empty where they do not determine them."""
    diagnostics: tuple[Diagnostic, ...]
    """What the runs say of themselves, worst first."""
    verdict: Verdict
    """Whether what was asked for is reached by the drum as it is now."""
    tolerance_missing_data: MessageData | None = None
    """`tolerance_missing` as data."""
    plan_probability_within: float | None = None
    """How probable it was, by the errors of the coefficients, that the plan that is fitted keeps every limit; null
    without limits, or where those errors are unknown."""
