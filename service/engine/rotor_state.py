"""What is on the rotor and what changes on it: asked here by API, pages, report and `solve` alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from service.engine import mapping
from service.engine.validation import hole_at, plane_index, same_angle
from service.model.machine import Machine, Plane
from service.model.plan import Change, Placement, Plan
from service.model.run import MassOnRotor, Run, RunOut
from service.model.session import AsFoundPiece
from service.model.stop import Stop

SAME_MASS_G = 0.05
"""Two statements of the mass of one piece differ by no more: a field balance reads a tenth of a gram."""
_NEVER = datetime.min.replace(tzinfo=UTC)


@dataclass(frozen=True)
class Drum:
    """What is stored of a drum: its runs, the plans stated fitted, and the stops in which masses were changed."""

    machine: Machine
    runs: tuple[Run, ...]
    run_out: tuple[RunOut, ...]
    plans: tuple[Plan, ...]
    stops: tuple[Stop, ...]
    as_found: tuple[AsFoundPiece, ...] = ()

    @property
    def fitted(self) -> Plan | None:
        """The plan whose masses are mounted."""
        return next((plan for plan in self.plans if plan.state == "fitted"), None)

    @property
    def good(self) -> tuple[Run, ...]:
        """Runs that are not excluded."""
        return tuple(run for run in self.runs if not run.excluded)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speeds, r/min, that limits are judged at: the service speed and each speed of an as-found run."""
        as_found = {run.nominal_speed_rpm for run in self.good if run.kind == "initial"}
        service = self.machine.service_speed_rpm
        return (service, *sorted(as_found - {service}))


@dataclass(frozen=True)
class Mounted:
    """Pieces on the rotor, and pieces of the as-found rotor that are off it."""

    on: tuple[Placement, ...]
    off: tuple[Placement, ...] = ()


def on_rotor(drum: Drum) -> tuple[MassOnRotor, ...]:
    """Return ALL masses on the rotor now, relative to the as-found rotor.

    Whatever was stated last counts: a run, a change of masses in a stop, or a plan stated fitted or taken off. A
    change made after run n comes before run n + 1; two changes between the same runs are ordered by their time.
    """
    stated: list[tuple[int, datetime, tuple[MassOnRotor, ...]]] = [(0, _NEVER, ())]
    if drum.runs:
        # A run has no time here: every change after it counts as later.
        stated.append((len(drum.runs), _NEVER, drum.runs[-1].masses))
    stated += [
        (stop.runs_before if stop.changed_after_run is None else stop.changed_after_run, stop.changed_at, stop.masses)
        for stop in drum.stops
        if stop.masses is not None and stop.changed_at is not None and not stop.cancelled
    ]
    stated += [
        (_changed_after(drum, plan), plan.changed_at or _NEVER, _left_by(plan))
        for plan in drum.plans
        if plan.state in ("fitted", "unfitted")
    ]
    # Of equal ones the latest in the list wins: a plan's state after the run that came before it.
    latest = max(range(len(stated)), key=lambda index: (*stated[index][:2], index))
    return stated[latest][2]


def mounted(drum: Drum) -> Mounted:
    """Return the pieces on the rotor now, each as it is known: a piece of the plan that is fitted with its weighing."""
    known = () if drum.fitted is None else (*(drum.fitted.fitted or ()), *drum.fitted.taken_off)
    return pieces_of(drum.machine, drum.as_found, on_rotor(drum), known)


def pieces_of(
    machine: Machine,
    as_found: Sequence[AsFoundPiece],
    masses: Iterable[MassOnRotor],
    known: Sequence[Placement],
) -> Mounted:
    """Recognise masses on the rotor as pieces.

    known: placements that a mass may be, recognised by place and by mass with its fastener. A negative mass is an
    as-found piece that is off; where no piece is recognised it is removed material, which cannot come back.
    """
    found = [as_found_placement(machine, piece) for piece in as_found]
    on, off = [], []
    for mass in masses:
        if mass.mass_g > 0.0:
            plane = machine.planes[plane_index(machine, mass.plane, "masses.plane")]
            on.append(_recognised(mass, known) or trial_piece(plane, mass.mass_g, mass.angle_deg))
        else:
            piece = _recognised(_turned(mass), found)
            if piece is not None:
                found.remove(piece)
                off.append(piece)
    return Mounted(tuple(on), tuple(off))


def changes(
    machine: Machine,
    as_found: Sequence[AsFoundPiece],
    present: Mounted,
    wanted: Sequence[Placement],
    off: Sequence[Placement] = (),
) -> tuple[Change, ...]:
    """Return what to remove, keep and add to get from the present pieces to the wanted ones.

    wanted: every piece that is to be on the rotor; off: as-found pieces that are to be off it. As-found pieces that
    must stay are no part of it, the others count where they sit. Pieces of one kind in one hole are alike.
    """
    movable = [as_found_placement(machine, piece) for piece in as_found if piece.may != "stay"]
    left = [*present.on, *_without(movable, present.off)]
    kept, added = [], []
    for piece in in_order(machine, (*wanted, *_without(movable, off))):
        match = next((one for one in left if same_piece(one, piece)), None)
        if match is None:
            added.append(Change(action="add", placement=piece))
        else:
            left.remove(match)
            kept.append(Change(action="keep", placement=match))
    removed = [Change(action="remove", placement=piece) for piece in in_order(machine, left)]
    return tuple(removed + kept + added)


def changes_to(drum: Drum, wanted: Sequence[Placement], off: Sequence[Placement] = ()) -> tuple[Change, ...]:
    """Return what to remove, keep and add to get from the rotor as it is now to the wanted pieces."""
    return changes(drum.machine, drum.as_found, mounted(drum), wanted, off)


def updated(drum: Drum, plan: Plan) -> tuple[Change, ...]:
    """Return what a plan changes on the rotor as it is now; of a plan that is or was fitted, what it was made with."""
    if plan.state not in ("proposed", "unfitted") or not plan.changes:
        return plan.changes
    return changes_to(drum, plan.placements, plan.taken_off)


def same_piece(one: Placement, other: Placement) -> bool:
    """Whether two placements may be one piece: same place, and the same stock mass or the same mass on the rotor."""
    if one.plane != other.plane or not same_angle(one.position_deg, other.position_deg):
        return False
    if one.from_box and other.from_box:
        return (one.mass_g, one.fastener_g) == (other.mass_g, other.fastener_g)
    return abs(mass_on_rotor_g(one) - mass_on_rotor_g(other)) <= SAME_MASS_G


def mass_on_rotor_g(piece: Placement) -> float:
    """Return the mass, g, that a piece has on the rotor: as weighed where it was, its fastener included."""
    return (piece.mass_g if piece.weighed_g is None else piece.weighed_g) + piece.fastener_g


def as_found_placement(machine: Machine, piece: AsFoundPiece) -> Placement:
    """Return an as-found piece where it sits."""
    plane = machine.planes[plane_index(machine, piece.plane, "on_rotor.plane")]
    return trial_piece(plane, piece.mass_g, piece.position_deg)


def trial_piece(plane: Plane, mass_g: float, angle_deg: float) -> Placement:
    """Return a mass that is from no box, at any angle."""
    place = hole_at(plane, angle_deg)
    return Placement(
        plane=plane.name,
        position_deg=angle_deg if place is None else plane.positions_deg[place.index],
        hole="" if place is None else place.label,
        mass_g=mass_g,
        from_box=False,
    )


def in_order(machine: Machine, placements: Sequence[Placement]) -> tuple[Placement, ...]:
    """Return placements as the technician walks round the drum: by plane, position, mass."""
    names = [plane.name for plane in machine.planes]
    return tuple(sorted(placements, key=lambda p: (names.index(p.plane), p.position_deg, p.mass_g)))


def _left_by(plan: Plan) -> tuple[MassOnRotor, ...]:
    return mapping.masses_on_rotor(plan) if plan.state == "fitted" else ()


def _changed_after(drum: Drum, plan: Plan) -> int:
    """After which run a plan was fitted or taken off. Of plans stored before this was kept: after the runs before."""
    if plan.changed_after_run is not None:
        return plan.changed_after_run
    fitted_last = plan.state == "fitted" and bool(drum.runs) and drum.runs[-1].kind in ("initial", "trial")
    return len(drum.runs) if fitted_last else 0


def _recognised(mass: MassOnRotor, known: Iterable[Placement]) -> Placement | None:
    for piece in known:
        here = piece.plane == mass.plane and same_angle(piece.position_deg, mass.angle_deg)
        if here and abs(mass_on_rotor_g(piece) - mass.mass_g) <= SAME_MASS_G:
            return piece
    return None


def _turned(mass: MassOnRotor) -> MassOnRotor:
    return MassOnRotor(plane=mass.plane, mass_g=-mass.mass_g, angle_deg=mass.angle_deg)


def _without(pieces: Sequence[Placement], gone: Iterable[Placement]) -> list[Placement]:
    left = list(pieces)
    for piece in gone:
        match = next((one for one in left if same_piece(one, piece)), None)
        if match is not None:
            left.remove(match)
    return left
