"""What a request for an arrangement must satisfy: every refusal is named and says what to do."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import replace

from service.errors import InvalidInput
from service.messages import Message, Quantity
from service.model.arrangement import ArrangementRequest, PartToArrange
from service.model.parts import Mass, PartRecord, Place, WeighRequest

IMPLAUSIBLE = 100.0
"""A mass this many times the median, or this part of it, is a unit mistaken."""


def check(request: ArrangementRequest, places: Sequence[Place]) -> None:
    """Refuse what cannot be meant. Raises InvalidInput with a code of its own for each rule."""
    check_places(places)
    _check_identities(request.parts, places)
    for index, part in enumerate(request.parts):
        _check_part(f"parts[{index}]", part, places)
    _check_plausible(request.parts)
    _check_groups(request, places)
    if request.offset in ("measured", "in_balance_with_old"):
        _check_complete(request, places)
    _check_wishes(request)


def masses_of(part: PartToArrange) -> tuple[float, ...]:
    """The readings of a part, g: none, one, or both ends."""
    return _readings(part.mass_g)


def _readings(mass_g: Mass) -> tuple[float, ...]:
    if mass_g is None:
        return ()
    return mass_g if isinstance(mass_g, tuple) else (mass_g,)


def may_of(part: PartToArrange) -> str:
    """What may happen to a part: as stated; an unweighed one stays."""
    weighed = part.mass_g is not None or part.moment_g_mm is not None
    return part.may or ("move" if weighed else "stay")


def fits(part: PartToArrange, place: Place) -> bool:
    """Whether a part goes into a place by its kind."""
    return place.kind is None or part.kind == place.kind


def old_parts(parts: Sequence[PartToArrange], places: Sequence[Place]) -> list[int | None]:
    """Part in each place while the drum was measured or in balance: the one that is gone, else the present one."""
    out: list[int | None] = [None] * len(places)
    labels = [place.label for place in places]
    for gone in (False, True):
        for k, part in enumerate(parts):
            if part.present is not None and (may_of(part) == "gone") == gone:
                out[labels.index(part.present)] = k
    return out


def check_places(places: Sequence[Place]) -> None:
    """Refuse a label used twice, or both ends at one position. Raises InvalidInput."""
    seen: set[str] = set()
    for index, place in enumerate(places):
        field = f"places[{index}]"
        if place.label in seen:
            raise _refused(Message("place_twice", place=place.label), f"{field}.label", place.label)
        seen.add(place.label)
        if len(place.axial_mm) == 2 and place.axial_mm[0] == place.axial_mm[1]:
            raise _refused(
                Message("ends_at_one_position", place=place.label, at=Quantity(place.axial_mm[0], "mm")),
                f"{field}.axial_mm",
                list(place.axial_mm),
            )


def check_weighed(request: WeighRequest, places: Sequence[Place], known: Sequence[PartRecord]) -> None:
    """Refuse a weighing that cannot be meant, by what is known of the machine's other parts. Raises InvalidInput.

    places: of the set that the parts belong to; empty where none is named, any place is taken then.
    """
    labels, seen = {place.label for place in places}, set[str]()
    masses = {one.part: sum(_readings(one.mass_g)) for one in known if one.mass_g is not None}
    masses |= {one.part: sum(_readings(one.mass_g)) for one in request.parts if one.mass_g is not None}
    median = statistics.median(masses.values()) if masses else 0.0
    for index, one in enumerate(request.parts):
        field = f"parts[{index}]"
        part = PartToArrange(
            id=one.part, mass_g=one.mass_g, moment_g_mm=one.moment_g_mm, kind=one.kind, present=one.place
        )
        if one.part in seen:
            raise _refused(Message("part_twice", part=one.part), f"{field}.part", one.part)
        seen.add(one.part)
        if places and one.place is not None and one.place not in labels:
            raise _refused(
                Message("unknown_place.in_set", place=one.place, set=request.place_set), f"{field}.place", one.place
            )
        _check_part(field, replace(part, may="move"), [place for place in places if one.place in (None, place.label)])
        if one.mass_g is not None:
            _check_near(field, one.part, masses[one.part], median)


def _check_identities(parts: Sequence[PartToArrange], places: Sequence[Place]) -> None:
    labels = {place.label for place in places}
    kinds = {place.kind for place in places}
    seen: set[str] = set()
    taken: dict[tuple[str, bool], str] = {}
    for index, part in enumerate(parts):
        field = f"parts[{index}]"
        if part.id in seen:
            raise _refused(Message("part_twice", part=part.id), f"{field}.id", part.id)
        seen.add(part.id)
        if part.kind is not None and part.kind not in kinds and None not in kinds:
            raise _refused(
                Message("unknown_kind", part=part.id, kind=part.kind, known=sorted(map(str, kinds))),
                f"{field}.kind",
                part.kind,
            )
        if part.present is None:
            continue
        if part.present not in labels:
            raise _refused(
                Message("unknown_place.of_part", part=part.id, place=part.present), f"{field}.present", part.present
            )
        key = (part.present, may_of(part) == "gone")
        if key in taken:
            raise _refused(
                Message("place_taken_twice", place=part.present, first=taken[key], second=part.id),
                f"{field}.present",
                part.present,
            )
        taken[key] = part.id


def _check_part(field: str, part: PartToArrange, places: Sequence[Place]) -> None:
    readings = masses_of(part) if part.moment_g_mm is None else (*masses_of(part), part.moment_g_mm)
    for value in readings:
        if not value > 0.0:
            raise _refused(
                Message("mass_not_positive", part=part.id, mass=Quantity(value, "g")), f"{field}.mass_g", value
            )
    if part.moment_g_mm is not None and part.mass_g is not None and isinstance(part.mass_g, tuple):
        raise _refused(Message("moment_and_ends", part=part.id), f"{field}.moment_g_mm", part.moment_g_mm)
    where = [place for place in places if place.label == part.present] if may_of(part) != "move" else places
    if len(masses_of(part)) == 2:
        short = next((place for place in where if fits(part, place) and len(place.axial_mm) == 1), None)
        if short is not None:
            raise _refused(
                Message("two_ended_part_in_one_ended_place", part=part.id, place=short.label),
                f"{field}.mass_g",
                list(masses_of(part)),
            )
    if may_of(part) == "stay" and part.present is None:
        raise _refused(Message("stays_without_place", part=part.id), f"{field}.present", None)
    if may_of(part) == "move" and not readings:
        raise _refused(Message("part_not_weighed.may_move", part=part.id), f"{field}.mass_g", None)


def _check_plausible(parts: Sequence[PartToArrange]) -> None:
    whole = [sum(masses_of(part)) for part in parts if part.mass_g is not None]
    if not whole:
        return
    median = statistics.median(whole)
    for index, part in enumerate(parts):
        if part.mass_g is not None:
            _check_near(f"parts[{index}]", part.id, sum(masses_of(part)), median)


def _check_near(field: str, part: str, mass: float, median: float) -> None:
    if not median / IMPLAUSIBLE < mass < median * IMPLAUSIBLE:
        raise _refused(
            Message("mass_implausible", part=part, mass=Quantity(mass, "g"), median=Quantity(median, "g")),
            f"{field}.mass_g",
            mass,
        )


def _check_groups(request: ArrangementRequest, places: Sequence[Place]) -> None:
    known = {place.group for place in places if place.group is not None}
    for index, limit in enumerate(request.group_limits):
        if limit.group not in known:
            raise _refused(Message("unknown_group", group=limit.group), f"group_limits[{index}].group", limit.group)
    limited = {limit.group for limit in request.group_limits}
    labels = {place.label for place in places if place.group in limited}
    for index, part in enumerate(request.parts):
        if part.mass_g is None and part.moment_g_mm is None and part.present in labels:
            raise _refused(Message("part_not_weighed.in_group", part=part.id), f"parts[{index}].mass_g", None)


def _check_complete(request: ArrangementRequest, places: Sequence[Place]) -> None:
    """The drum was measured, or in balance, with the old parts on: what is in every place must be known."""
    relative_to = old_parts(request.parts, places)
    for place, k in zip(places, relative_to, strict=True):
        if k is None and not place.may_be_empty:
            raise _refused(
                Message("present_incomplete", place=place.label, offset=str(request.offset)), "parts", place.label
            )
    for index, part in enumerate(request.parts):
        unknown = part.mass_g is None and part.moment_g_mm is None
        if may_of(part) == "gone" and part.present is not None and unknown:
            raise _refused(
                Message("part_not_weighed.gone", part=part.id, place=part.present), f"parts[{index}].mass_g", None
            )


def _check_wishes(request: ArrangementRequest) -> None:
    unweighed = next((p for p in request.parts if p.mass_g is None and p.moment_g_mm is None), None)
    if unweighed is not None and request.offset not in ("measured", "in_balance_with_old"):
        raise _refused(Message("part_not_weighed.bare_drum", part=unweighed.id), "parts", unweighed.id)
    if request.mode == "fewest_moves" and request.limit is None:
        raise _refused(Message("limit_missing"), "limit", None)
    if request.mode == "fewest_moves" and all(part.present is None for part in request.parts):
        raise _refused(Message("present_missing"), "parts", None)


def _refused(message: Message, field: str, value: object) -> InvalidInput:
    return InvalidInput(message, field=field, value=value)
