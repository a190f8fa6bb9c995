"""Plans: which stock masses go into which positions, and how good that is."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, Len

from service.model.base import MAX_LIST, AngleDeg, Name, NotNegative, Positive, Seed, Small, document
from service.model.correction import SensorVector
from service.model.message import MessageData
from service.model.run import MassOnRotor

ObjectiveName = Literal["residual_vibration", "components", "bearing_force", "robust"]
RobustAim = Literal["quantile_95", "probability_within_limits"]
RobustBase = Literal["residual_vibration", "bearing_force"]
NormName = Literal["sum", "max", "rms"]
Method = Literal["certified", "modified_jaya", "exact"]
Base = Literal["as_found", "present"]
PlanStatus = Literal["optimal", "within_uncertainty", "limit_reached", "heuristic", "infeasible"]
Mode = Literal["best", "fewest", "combine"]
PlanState = Literal["proposed", "fitted", "unfitted", "replaced"]


@document
class BlockedPosition:
    """A position that takes nothing."""

    plane: Name
    """Correction plane."""
    position_deg: AngleDeg
    """Angle of the position, degrees; one of the plane's positions."""


@document
class Robust:
    """What a plan must do well in spite of the uncertainty of the coefficients."""

    aim: RobustAim = "quantile_95"
    """quantile_95: the smallest value that the base objective stays below in 95 of 100 cases;
    probability_within_limits: the greatest probability that all limits are kept."""
    base: RobustBase = "residual_vibration"
    """residual_vibration: amplitudes over limits; bearing_force: Eq 5.14, its limit the machine's balance quality."""


@document
class PlanRequest:
    """Ask which stock masses to bolt into which positions."""

    correction_id: Name
    """The correction to realise."""
    objective: ObjectiveName
    """residual_vibration: predicted amplitude over limit; components: unbalance missed; bearing_force: Eq 5.14; robust:
    see `robust`."""
    norm: NormName | None = None
    """How residual_vibration joins the sensors: sum (default), max or rms of amplitude over limit."""
    weights: Annotated[tuple[Positive, ...], Len(1, 64)] | None = None
    """Further weight of each predicted vector, in their order; only with residual_vibration."""
    robust: Robust | None = None
    """What survives the uncertainty of the readings; only with objective robust, where null means its defaults."""
    mode: Mode = "best"
    """best: the smallest objective; fewest: the fewest masses whose objective is within `limit`, proved; combine: the
    fewest that do as well as those of all trims that are bolted on now, which may all come off."""
    limit: Positive | None = None
    """Limit of the objective for mode fewest, in its unit; default for residual_vibration: every sensor within its own
    limit (norm max, limit 1); for mode combine: the objective of the masses that are on now."""
    slack: NotNegative = 0.0
    """Fewer masses, then less mass, then the commonest stock are preferred within this much of the best objective."""
    alternatives: Annotated[int, Ge(0), Le(20)] = 0
    """How many further selections to offer, the next best ones, proved in order."""
    angle_tolerance_deg: Annotated[float, Ge(0), Le(30)] | None = None
    """How far, degrees, a piece may sit off its position; taken as its standard deviation in the intervals of
    `predicted`, and as a bound in `placement_spread`."""
    mass_tolerance_g: Annotated[float, Ge(0), Le(1000)] | None = None
    """Standard deviation, g, of a piece's mass, in the intervals of `predicted`."""
    method: Method = "certified"
    """certified: modified Jaya, then the exact search proves or improves it; or one of the two alone."""
    base: Base = "as_found"
    """as_found: all fitted masses may come off; present: they stay, and pieces are added to them."""
    even_if_within: bool = False
    """True: pieces are chosen even where the rotor as found is within its limits already, or the readings cannot tell
    the correction from none; false: then no pieces are proposed, and `message` says why."""
    max_masses_per_plane: Small | None = None
    """At most this many masses a plane; the machine's own limit holds as well."""
    blocked: Annotated[tuple[BlockedPosition, ...], MAX_LIST] = ()
    """Positions that take nothing."""
    seed: Seed = 1
    """Seed of the modified Jaya; the same seed gives the same answer."""
    time_limit_s: Annotated[float, Gt(0), Le(120)] = 10.0
    """Longest time, s, the solver may take; then the best selection so far is returned with its gap."""


@document
class Placement:
    """One stock mass in one position."""

    plane: str
    """Correction plane."""
    position_deg: float
    """Angle of the position, degrees, in the machine's angle sense."""
    hole: str
    """Label of the position as on the drum; its number from the mark where no labels are given."""
    mass_g: float
    """Mass of the piece by the catalogue, g."""
    fastener_g: float = 0.0
    """Mass of its fastener, g, which counts as well."""
    weighed_g: float | None = None
    """What the piece was weighed at, g, if it was."""
    from_box: bool = True
    """False: a piece of the as-found rotor, moved here."""


@document
class Change:
    """What to do at one position to get from the masses on the rotor to the plan."""

    action: Literal["add", "remove", "keep"]
    """add, remove or keep."""
    placement: Placement
    """The piece and its position."""


@document
class Offer:
    """A selection with its proof."""

    status: PlanStatus
    """optimal: proved, nothing in the box does better (in a front: nothing of as few masses; mode fewest: fewer do not
    meet the limit, and nothing of as few does better); within_uncertainty: better by no more than can be measured;
    limit_reached: the time was over; heuristic: nothing is proved; infeasible: see `reason`."""
    message: str
    """The status in a sentence."""
    reason: str | None
    """Why there is no selection, and what would help; null where there is one."""
    placements: tuple[Placement, ...]
    """The final state of the rotor: every stock mass on it."""
    taken_off: tuple[Placement, ...]
    """Pieces of the as-found rotor that come off or move elsewhere."""
    objective_value: float | None
    """Objective of the placements, in the objective's unit; null without a selection."""
    lower_bound: float | None
    """Proved: no selection has a smaller objective; in a front and with mode fewest, none of as few masses."""
    gap: float | None
    """Objective minus lower bound; null where nothing is proved."""
    slack_proved: bool | None = None
    """Whether fewest masses, then least mass, are proved among all within `slack`; false: the time was over before, see
    `message`; null without slack."""
    message_data: MessageData | None = None
    """`message` as key and parameters, for other languages and units; null in plans made before this was kept."""
    reason_data: MessageData | None = None
    """`reason` as key and parameters; null where there is none, and in plans made before this was kept."""


@document
class FrontPoint:
    """The best selection of at most this many masses in all."""

    pieces: int
    """Masses in all planes together, kept ones included; as-found pieces that must stay are not counted."""
    offer: Offer
    """The selection."""
    other_box: str | None = None
    """Name of the box that the plan was made from, where the session has another one now; null: the session's own."""


@document
class StockChange:
    """Pieces that the box does not hold, or that it might."""

    mass_g: Positive
    """Mass of one piece by the catalogue, g."""
    pieces: Annotated[int, Ge(1), Le(1_000_000)] = 1
    """How many."""


@document
class WhatIfRequest:
    """Ask what the plan would be under other circumstances; nothing is stored."""

    missing: Annotated[tuple[StockChange, ...], MAX_LIST] = ()
    """Pieces that cannot be found."""
    bought: Annotated[tuple[StockChange, ...], MAX_LIST] = ()
    """Pieces that might be bought."""
    blocked: Annotated[tuple[BlockedPosition, ...], MAX_LIST] = ()
    """Further positions that take nothing."""


@document
class WhatIf:
    """The plan under other circumstances, beside the plan as it is."""

    offer: Offer
    """The selection under those circumstances."""
    objective_value: float | None
    """Objective of the plan as it is."""
    objective_unit: str
    """Unit of both."""
    worse_by: float | None
    """Objective under those circumstances minus that of the plan; negative: better."""
    other_box: str | None = None
    """Name of the box that the plan was made from, where the session has another one now; null: the session's own."""


@document
class BearingForces:
    """Reactions of a rigid rotor on its two bearings at service speed."""

    bearings: tuple[str, ...]
    """Names of the bearings."""
    before: tuple[float, ...]
    """Reaction amplitude, N, without correction masses."""
    after: tuple[float, ...]
    """Reaction amplitude, N, with the placements."""


@document
class MethodResult:
    """What one method found by itself."""

    method: Method
    """Method."""
    status: PlanStatus
    """How it ended."""
    objective_value: float | None
    """Objective of its selection; null without one."""
    lower_bound: float | None
    """What it proved; null where it proves nothing."""
    evaluations: int
    """Selections looked at."""
    seconds: float
    """Time taken, s."""


@document
class PlanInputs:
    """What else the answer depends on, so that it can be found again."""

    counts: tuple[int | None, ...]
    """Pieces of each catalogue item that the session could have; null: unlimited."""
    present: tuple[Placement, ...]
    """Pieces of the plan that is fitted."""
    present_off: tuple[Placement, ...] = ()
    """Pieces of the as-found rotor that are off it now."""
    version: str
    """Version of Drumtrue."""
    catalogue_id: str | None = None
    """The box of stock masses; null where it is not stored."""
    on_rotor: tuple[MassOnRotor, ...] | None = None
    """ALL masses on the rotor when the plan was made, relative to the as-found rotor; null: before this was kept."""


@document
class Plan:
    """A selection of stock masses, and what is proved of it."""

    id: str
    """Identifier."""
    number: int
    """1, 2, 3 ... in the order of the session."""
    session_id: str
    """The session it belongs to."""
    correction_id: str
    """The correction it realises."""
    request: PlanRequest
    """What was asked for."""
    inputs: PlanInputs
    """What else the answer depends on."""
    status: PlanStatus
    """optimal: proved, nothing in the box does better (in a front: nothing of as few masses; mode fewest: fewer do not
    meet the limit, and nothing of as few does better); within_uncertainty: better by no more than can be measured;
    limit_reached: the time was over; heuristic: nothing is proved; infeasible: see `reason`."""
    message: str
    """The status in a sentence."""
    reason: str | None
    """Why there is no selection; null where there is one."""
    placements: tuple[Placement, ...]
    """The final state of the rotor: every stock mass on it."""
    taken_off: tuple[Placement, ...]
    """Pieces of the as-found rotor that come off or move elsewhere."""
    changes: tuple[Change, ...]
    """What to add, remove and keep."""
    objective_value: float | None
    """Objective of the placements, in `objective_unit`; null without a selection."""
    objective_unit: str
    """g.mm for components; 1 for residual_vibration (over limit), bearing_force (share of the reactions) and robust
    (95 % quantile of these, or the probability that a limit is broken)."""
    lower_bound: float | None
    """Proved: no selection has a smaller objective (mode fewest: none of as few masses); null without proof."""
    gap: float | None
    """Objective minus lower bound; null where nothing is proved."""
    objective_scatter: float | None
    """Standard deviation of the objective that the fit's scatter brings; null where it cannot be known."""
    predicted: tuple[SensorVector, ...]
    """Vibration to expect with the placements; empty without influence coefficients."""
    bearing_forces_n: BearingForces | None
    """Reactions before and after, N; null where the geometry is not known."""
    per_method: tuple[MethodResult, ...]
    """What each method found."""
    placement_spread: float | None
    """Most that the objective can change where pieces sit off by the angle tolerance; null without one."""
    alternatives: tuple[Offer, ...]
    """Further selections, best first."""
    evaluations: int
    """Selections looked at in all."""
    seconds: float
    """Time taken, s."""
    seed: int
    """Seed used."""
    created_at: datetime
    """When, UTC."""
    state: PlanState = "proposed"
    """proposed, fitted, replaced by a later fitted plan, or unfitted (taken off again)."""
    stale: bool = False
    """True: a run was added or excluded since."""
    fitted: tuple[Placement, ...] | None = None
    """What was really fitted; null until then."""
    changed_after_run: int | None = None
    """How many runs the session had when the plan was last stated fitted or taken off: later runs are of the drum as it
    was left then. Null: never, or before this was kept."""
    changed_at: datetime | None = None
    """When the plan was last stated fitted or taken off, UTC. Null: never, or before this was kept."""
    probability_within: float | None = None
    """How probable it is, by the errors of the coefficients, that every limit is kept: each sensor's for vibration, the
    machine's balance quality for unbalance and bearing force. Null: no limits, or the scatter of the readings is
    unknown."""
    probability_best: float | None = None
    """How probable it is, by the same errors, that no other selection has a smaller objective; null where the
    selections are too many to list for every case, or the scatter is unknown."""
    version: int = 1
    """Counts the changes of the plan; its ETag."""
    reserved_until: datetime | None = None
    """Until when its pieces are held in the box, UTC; null: nothing is held for it."""
    slack_proved: bool | None = None
    """Whether fewest masses, then least mass, are proved among all within `slack`; false: the time was over before, see
    `message`; null without slack."""
    message_data: MessageData | None = None
    """`message` as key and parameters, for other languages and units; null in plans made before this was kept."""
    reason_data: MessageData | None = None
    """`reason` as key and parameters; null where there is none, and in plans made before this was kept."""


@document
class ActualPlacement:
    """A piece as it was really fitted."""

    plane: Name
    """Correction plane."""
    position_deg: AngleDeg
    """Angle of the position, degrees; one of the plane's positions."""
    mass_g: Positive
    """Mass of the piece by the catalogue, g: which piece it is."""
    weighed_g: Positive | None = None
    """What the piece weighed, g, without its fastener."""


@document
class FittedRequest:
    """State that a plan is bolted on."""

    actual: Annotated[tuple[ActualPlacement, ...], MAX_LIST] | None = None
    """What was really fitted from the box, where it differs from the plan; as-found pieces are not stated."""
    accept_stale: bool = False
    """True: fit a plan although a run was added or excluded since."""
