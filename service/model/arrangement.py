"""Arrangements: which weighed part is mounted in which place, what that leaves, and what is proved of it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, Len
from pydantic import Field

from service.model.base import AngleDeg, Finite, Name, NotNegative, Positive, Seed, Text, document
from service.model.correction import Interval, SensorVector
from service.model.machine import AngleSense
from service.model.message import MessageData
from service.model.parts import MAX_PLACES, Mass, Place
from service.model.plan import Placement, PlanStatus

ArrangementObjective = Literal["unbalance", "bearing_force", "residual_vibration"]
ArrangementNorm = Literal["sum", "max", "rms"]
Use = Literal["parts", "box", "both"]
May = Literal["stay", "move", "gone"]
OffsetName = Literal["measured", "in_balance_with_old"]
MAX_PARTS = 300


@document
class PartToArrange:
    """A part that is or may be mounted, or that was taken off (`may: gone`)."""

    id: Name
    """What is written on the part, unique."""
    mass_g: Mass = None
    """Mass, g; or the two masses read at its ends, g; null for a part that stays and was not weighed."""
    moment_g_mm: float | None = None
    """Reading of a moment scale, g.mm, in place of mass times radius."""
    kind: Name | None = None
    """Kind; it fits where the place has the same kind or none."""
    set: Name | None = None
    """Parts of one set are mounted all or none."""
    present: Name | None = None
    """Label of the place it is mounted in now; of a part that is gone, the place it was in; null: not mounted."""
    may: May | None = None
    """stay: remains where it is; move (default for a weighed part): may go anywhere it fits, or off; gone: taken off,
    it only counts for the offset. A part without mass stays."""
    new: bool = False
    """Whether it counts as a new part."""


@document
class GroupDifference:
    """A maker's rule: greatest difference of the masses within a group of places."""

    group: Name
    """Group of places."""
    max_difference_g: NotNegative
    """Greatest difference, g."""


@document
class PlaneUnbalance:
    """Unbalance in a plane."""

    plane: Name | Annotated[int, Ge(1), Le(2)]
    """Correction plane by its name; without a machine 1 or 2."""
    unbalance_g_mm: NotNegative
    """Unbalance, g.mm."""
    angle_deg: AngleDeg
    """Angle, degrees, in the machine's angle sense."""


@document
class ArrangementRequest:
    """Ask which part goes into which place."""

    machine_id: Name | None = None
    """The machine: its planes, senses, sets of places; parts mounted become part of its history."""
    session_id: Name | None = None
    """The session, whose copy of the machine and box are used; it brings the machine."""
    correction_id: Name | None = None
    """The correction whose left unbalance is the offset `measured`, and whose coefficients predict the vibration."""
    angle_sense: AngleSense | None = None
    """Sense of the angles without a machine; default against_rotation."""
    places: Annotated[tuple[Place, ...], Len(1, MAX_PLACES)] | None = None
    """The places; or `set`."""
    set: Name | None = None
    """Name of one of the machine's sets of places."""
    parts: Annotated[tuple[PartToArrange, ...], Len(1, MAX_PARTS)]
    """The parts, those taken off included where their masses count."""
    group_limits: Annotated[tuple[GroupDifference, ...], Len(0, 50)] = ()
    """Greatest differences of masses within groups of places."""
    planes_axial_mm: Annotated[tuple[Finite, ...], Len(2, 2)] | None = None
    """Axial positions, mm, of the two planes that unbalance is stated in, without a machine; null: one plane."""
    offset: OffsetName | Annotated[tuple[PlaneUnbalance, ...], Len(0, 16)] | None = None
    """Unbalance of all but the parts: null, none; a list, that of the bare drum; measured: what the correction says is
    left with the present arrangement; in_balance_with_old: the drum was in balance with the parts that were mounted."""
    objective: ArrangementObjective = "unbalance"
    """unbalance, g.mm; bearing_force: reactions over those now (Eq 5.14); residual_vibration: amplitude over limit."""
    norm: ArrangementNorm | None = None
    """How planes, or sensors, are joined: sum (default), max, or rms, the root of the mean square."""
    mode: Literal["best", "fewest_moves"] = "best"
    """best: the least objective; fewest_moves: the fewest moves, then new parts, then the least objective, with an
    objective of at most `limit`."""
    use: Use = "parts"
    """What may change: parts; box: stock masses in holes alone; both."""
    catalogue_id: Name | None = None
    """Box of stock masses for box and both; default: the session's."""
    limit: Positive | None = None
    """Limit of the objective for fewest_moves, in its unit."""
    max_moves: Annotated[int, Ge(0), Le(MAX_PLACES)] | None = None
    """At most this many places whose part changes."""
    max_new_parts: Annotated[int, Ge(0), Le(MAX_PARTS)] | None = None
    """At most this many new parts."""
    max_masses_per_plane: Annotated[int, Ge(1), Le(6)] | None = None
    """At most this many stock masses a plane, with use box and both; the machine's own limit holds as well."""
    scale_resolution_g: Annotated[float, Gt(0), Le(1e5)] | None = None
    """Resolution of the scale, g; a reading has the standard deviation resolution / sqrt(12)."""
    time_limit_s: Annotated[float, Gt(0), Le(120)] = 10.0
    """Longest time, s; then the best arrangement so far is returned with its gap."""
    seed: Seed = 1
    """Seed of the local search; the same seed gives the same answer."""


@document
class Mounted:
    """A part in a place."""

    place: str
    """Label of the place."""
    part: str | None
    """Part; null: the place is empty."""


@document
class Move:
    """One part that changes its place."""

    part: str
    """Part."""
    leaves: Annotated[str | None, Field(alias="from")]
    """Place it is in now; null: not mounted."""
    to: str | None
    """Place it goes to; null: off the drum."""


@document
class PlaneResidual:
    """Unbalance that is left in a plane."""

    plane: str
    """Correction plane; without a machine 1 or 2."""
    unbalance_g_mm: float
    """Unbalance, g.mm."""
    angle_deg: float
    """Angle, degrees, in the machine's angle sense."""
    interval: Interval | None = None
    """Interval of the unbalance from the scale and the measurement; null where neither is known."""


@document
class MakersRule:
    """What the maker's rule, heaviest parts opposite, would give."""

    objective_value: float
    """Objective, in the unit of the answer."""
    arrangement: tuple[Mounted, ...]
    """Parts in places."""


@document
class ArrangementOffer:
    """An arrangement with what is proved of it."""

    status: PlanStatus
    """optimal: proved, no arrangement does better; within_uncertainty: none is better by more than the scale can tell;
    limit_reached: the time was over; infeasible: see `reason`."""
    message: str
    """The status in a sentence."""
    message_data: MessageData | None = None
    """`message` as data; null in documents of earlier releases."""
    code: str | None
    """Stable name of what `reason` or `message` tells besides; null: nothing."""
    reason: str | None
    """Why there is no arrangement; null where there is one."""
    reason_data: MessageData | None = None
    """`reason` as data; null where there is none."""
    arrangement: tuple[Mounted, ...]
    """The part of every place; empty without an arrangement."""
    moves: tuple[Move, ...]
    """Parts that change their place, in an order that needs one free place at most."""
    moves_count: int
    """Places whose part changes."""
    new_parts_count: int
    """New parts mounted."""
    moves_bound: int | None
    """Proved: no fewer moves meet the limit; null but for mode fewest_moves."""
    objective_value: float | None
    """Objective, in `objective_unit`; null without an arrangement."""
    lower_bound: float | None
    """Proved: no arrangement has a smaller objective (mode fewest_moves: whatever its moves)."""
    gap: float | None
    """Objective minus lower bound."""
    objective_scatter: float | None
    """Standard deviation of the objective from the scale; null where its resolution is not stated."""
    residual: tuple[PlaneResidual, ...]
    """Unbalance left in the planes."""
    predicted: tuple[SensorVector, ...] = ()
    """Vibration to expect; empty without influence coefficients."""
    placements: tuple[Placement, ...] | None = None
    """Stock masses to bolt on besides; null where the box is not used."""


@document
class Arrangement:
    """An arrangement of parts as it is stored."""

    id: str
    """Identifier."""
    machine_id: str | None
    """The machine; null without one."""
    session_id: str | None
    """The session; null without one."""
    request: ArrangementRequest
    """What was asked for."""
    places: tuple[Place, ...]
    """The places, as they were then."""
    status: PlanStatus
    """As of the offer."""
    message: str
    """The status in a sentence."""
    message_data: MessageData | None = None
    """`message` as data; null in documents of earlier releases."""
    code: str | None
    """Stable name of what `reason` or `message` tells besides; null: nothing."""
    reason: str | None
    """Why there is no arrangement; null where there is one."""
    reason_data: MessageData | None = None
    """`reason` as data; null where there is none."""
    arrangement: tuple[Mounted, ...]
    """The part of every place; empty without an arrangement."""
    moves: tuple[Move, ...]
    """Parts that change their place, in an order that needs one free place at most."""
    moves_count: int
    """Places whose part changes."""
    new_parts_count: int
    """New parts mounted."""
    moves_bound: int | None
    """Proved: no fewer moves meet the limit; null but for mode fewest_moves."""
    objective_value: float | None
    """Objective, in `objective_unit`; null without an arrangement."""
    objective_unit: str
    """g.mm for unbalance; 1 for residual_vibration (over limit) and bearing_force (share of the reactions)."""
    lower_bound: float | None
    """Proved: no arrangement has a smaller objective."""
    gap: float | None
    """Objective minus lower bound."""
    objective_scatter: float | None
    """Standard deviation of the objective from the scale; null where its resolution is not stated."""
    residual: tuple[PlaneResidual, ...]
    """Unbalance left in the planes."""
    predicted: tuple[SensorVector, ...]
    """Vibration to expect; empty without influence coefficients."""
    placements: tuple[Placement, ...] | None
    """Stock masses to bolt on besides; null where the box is not used."""
    makers_rule: MakersRule | None
    """What the maker's rule would give; null: see `makers_rule_reason`."""
    makers_rule_reason: str | None
    """Why the maker's rule gives nothing; null where it does."""
    makers_rule_reason_data: MessageData | None = None
    """`makers_rule_reason` as data; null where there is none."""
    objective_now: float | None
    """Objective with the present arrangement; null where it is incomplete."""
    evaluations: int
    """Arrangements looked at."""
    seconds: float
    """Time taken, s."""
    seed: int
    """Seed used."""
    created_at: datetime
    """When, UTC."""
    state: Literal["proposed", "mounted"] = "proposed"
    """proposed, or mounted: see `mounted`."""
    locked_at: datetime | None = None
    """When the drum was reported locked to move parts, UTC; null: not reported."""
    mounted: tuple[Mounted, ...] | None = None
    """What was really mounted where; null until then."""
    mounted_at: datetime | None = None
    """When it was stated mounted, UTC."""
    mounted_residual: tuple[PlaneResidual, ...] | None = None
    """Unbalance left with what was really mounted."""
    released_at: datetime | None = None
    """When the drum was reported ready to run after that, UTC; null: not reported."""


@document
class ArrangementPoint:
    """The best arrangement of at most this many moves."""

    moves: int
    """Places whose part may change at most."""
    offer: ArrangementOffer
    """The arrangement."""


@document
class ArrangementWhatIf:
    """Ask what the arrangement would be under other circumstances; nothing is stored."""

    missing: Annotated[tuple[Name, ...], Len(0, MAX_PARTS)] = ()
    """Parts that cannot be used, such as broken ones; one that is mounted counts as gone."""
    shelf: Annotated[tuple[PartToArrange, ...], Len(0, MAX_PARTS)] = ()
    """Further parts that might be mounted."""
    stay: Annotated[tuple[Name, ...], Len(0, MAX_PARTS)] = ()
    """Parts that are to stay where they are."""
    max_moves: Annotated[int, Ge(0), Le(MAX_PLACES)] | None = None
    """Another limit of moves."""
    replace: Name | None = None
    """A place: state the mass that a part there should have, all others staying where they are, and which of the parts
    not mounted comes nearest."""


@document
class Replacement:
    """The part that a place should have."""

    place: str
    """Place."""
    mass_g: float
    """Mass, g, that the part should have, both ends together and alike; 0 where even the lightest is too heavy."""
    objective_value: float
    """Objective with it."""
    best_on_shelf: str | None
    """Of the parts that are not mounted and fit, the best one; null: there is none."""
    shelf_objective_value: float | None
    """Objective with that one."""


@document
class ArrangementAnswer:
    """The arrangement under other circumstances, next to the one as it is."""

    offer: ArrangementOffer
    """The arrangement under those circumstances."""
    objective_value: float | None
    """Objective of the arrangement as it is."""
    objective_unit: str
    """Unit of both."""
    worse_by: float | None
    """Objective under those circumstances minus that of the arrangement; negative: better."""
    replacement: Replacement | None = None
    """The part that the place asked for should have."""


@document
class MountedRequest:
    """State what was mounted where."""

    actual: Annotated[tuple[Mounted, ...], Len(0, MAX_PLACES)] | None = None
    """Places whose part differs from the arrangement's, with the part that is really there."""
    note: Text | None = None
    """A remark for the history."""
