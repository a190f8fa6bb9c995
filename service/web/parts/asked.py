"""The form that asks which part goes where, and the request that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from service.model.arrangement import ArrangementObjective, ArrangementRequest, May, PartToArrange
from service.model.machine import StoredMachine
from service.model.parts import Mass, PartRecord, Place, PlaceSet
from service.runtime.context import AppContext
from service.usecases.sessions import sessions
from service.web.forms import Form
from service.web.language import N_
from service.web.parts.scale import read_mass, weighed
from service.web.rendering import Page

BARE, OLD, MEASURED = "bare", "old", "measured"
MAX_SESSIONS = 10
TIME_LIMIT_S = 8.0
AIMS = {"best": N_("the best order"), "fewest_moves": N_("the fewest moves within a limit")}
USES = {"parts": N_("parts alone"), "both": N_("parts and masses from the box")}
NEW_PART = N_("This number is already on another part.")


@dataclass(frozen=True)
class Basis:
    """A session whose measurement an arrangement can start from."""

    session_id: str
    correction_id: str
    name: str
    vibration: bool


def measured_with(work: AppContext, machine: StoredMachine) -> list[Basis]:
    """Sessions of the machine with a correction that is not out of date, newest first."""
    out = []
    for session in sessions.find(work, MAX_SESSIONS, 0, machine_id=machine.id):
        whole = sessions.get(work, session.id)
        last = next((one for one in reversed(whole.corrections) if not one.stale), None)
        if last is not None:
            day = f"{whole.created_at:%Y-%m-%d %H:%M}"
            out.append(Basis(whole.id, last.id, day, vibration=bool(last.influence)))
    return out


def starts(bases: Sequence[Basis], records: Sequence[PartRecord], places: Sequence[Place]) -> str:
    """What a form begins with: in balance before where a part is not weighed, else a bare drum."""
    mounted = {one.place: one for one in records if one.place is not None}
    whole = all(place.label in mounted for place in places)
    if bases and whole:
        return f"{MEASURED}:{bases[0].correction_id}"
    return OLD if whole and not all(weighed(one) for one in mounted.values()) else BARE


def read(
    page: Page, form: Form, machine: StoredMachine, found: PlaceSet, records: Sequence[PartRecord]
) -> ArrangementRequest | None:
    """The request that was typed; None where a field is wrong."""
    bases = {f"{MEASURED}:{one.correction_id}": one for one in measured_with(page.work, machine)}
    offset = form.choice("offset", (BARE, OLD, *bases)) or BARE
    mode = form.choice("mode", AIMS) or "best"
    use = form.choice("use", USES, required=False) or "parts"
    most = form.whole("max_moves", low=0, high=len(found.places), required=False)
    basis = bases.get(offset)
    vibration = bool(form.ticked("vibration") and basis is not None and basis.vibration)
    limit = None
    if mode == "fewest_moves":
        # Within the vibration limits, or as many grams at the radius of the places.
        grams = form.number("limit", above=0.0, high=1e6, unit=page.display.mass_unit(), required=not vibration)
        limit = 1.0 if vibration else None if grams is None else grams * found.places[0].radius_mm
    resolution = form.number("scale_resolution_g", above=0.0, high=1e5, unit=page.display.mass_unit(), required=False)
    box = form.text("catalogue_id")
    if use == "both" and box is None:
        form.wrong("catalogue_id", N_("Choose one of the list."))
    parts = _parts(form, records)
    if not form.ok or not parts:
        if not parts:
            form.wrong("", N_("Weigh the parts first."))
        return None
    aim: ArrangementObjective = "residual_vibration" if vibration else "unbalance"
    return ArrangementRequest(
        machine_id=machine.id,
        session_id=None if basis is None else basis.session_id,
        correction_id=None if basis is None else basis.correction_id,
        set=found.name,
        parts=parts,
        offset=None if offset == BARE else "in_balance_with_old" if offset == OLD else "measured",
        objective=aim,
        norm="max",
        mode="fewest_moves" if mode == "fewest_moves" else "best",
        use="both" if use == "both" else "parts",
        catalogue_id=box if use == "both" else None,
        limit=limit,
        max_moves=most,
        scale_resolution_g=resolution,
        time_limit_s=TIME_LIMIT_S,
    )


def broken(
    page: Page, form: Form, machine: StoredMachine, found: PlaceSet, records: Sequence[PartRecord], place: Place
) -> ArrangementRequest | None:
    """The request of one part that broke: the new one, few moves among the others; None where a field is wrong."""
    old = next(one for one in records if one.place == place.label)
    number = form.text("part", required=True)
    mass = read_mass(page, form, "mass", len(place.axial_mm))
    before = old.mass_g
    if before is None and old.moment_g_mm is None:
        before = read_mass(page, form, "old", len(place.axial_mm))
    most = form.whole("max_moves", low=1, high=len(found.places), required=False)
    resolution = form.number("scale_resolution_g", above=0.0, high=1e5, unit=page.display.mass_unit(), required=False)
    if number is not None and any(one.part == number for one in records):
        form.wrong("part", NEW_PART)
    if not form.ok or number is None:
        return None
    others = [_part(one, "stay" if not weighed(one) else None) for one in records if one.place and one is not old]
    gone = _part(old, "gone", before)
    new = PartToArrange(id=number, mass_g=mass, kind=place.kind, new=True)
    return ArrangementRequest(
        machine_id=machine.id,
        set=found.name,
        parts=(gone, new, *others),
        offset="in_balance_with_old",
        norm="max",
        max_moves=most,
        scale_resolution_g=resolution,
        time_limit_s=TIME_LIMIT_S,
    )


def _parts(form: Form, records: Sequence[PartRecord]) -> tuple[PartToArrange, ...]:
    """Mounted parts, those ticked as to stay and unweighed ones staying; and the spares that are ticked."""
    out = []
    for index, one in enumerate(records):
        if one.place is None:
            if form.ticked(f"use[{index}]") and weighed(one):
                out.append(_part(one, None))
        else:
            out.append(_part(one, "stay" if form.ticked(f"stay[{index}]") or not weighed(one) else None))
    return tuple(out)


def _part(record: PartRecord, may: May | None, mass: Mass = None) -> PartToArrange:
    return PartToArrange(
        id=record.part,
        mass_g=record.mass_g if mass is None else mass,
        moment_g_mm=record.moment_g_mm,
        kind=record.kind,
        present=record.place,
        may=may,
    )
