"""What a request for an arrangement must satisfy: every refusal is named and says what to do."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from service.errors import InvalidInput
from service.model.arrangement import ArrangementRequest, PartToArrange, Place

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
    if part.mass_g is None:
        return ()
    return part.mass_g if isinstance(part.mass_g, tuple) else (part.mass_g,)


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
            raise _refused("place_twice", f"place {place.label!r} is listed twice", f"{field}.label", place.label)
        seen.add(place.label)
        if len(place.axial_mm) == 2 and place.axial_mm[0] == place.axial_mm[1]:
            raise _refused(
                "ends_at_one_position",
                f"both ends of place {place.label!r} are at {place.axial_mm[0]:g} mm",
                f"{field}.axial_mm",
                list(place.axial_mm),
                "state two different positions, or one for a part weighed whole",
            )


def _check_identities(parts: Sequence[PartToArrange], places: Sequence[Place]) -> None:
    labels = {place.label for place in places}
    kinds = {place.kind for place in places}
    seen: set[str] = set()
    taken: dict[tuple[str, bool], str] = {}
    for index, part in enumerate(parts):
        field = f"parts[{index}]"
        if part.id in seen:
            raise _refused(
                "part_twice", f"part {part.id!r} is listed twice", f"{field}.id", part.id, "a part is in one place only"
            )
        seen.add(part.id)
        if part.kind is not None and part.kind not in kinds and None not in kinds:
            raise _refused(
                "unknown_kind",
                f"no place takes the kind {part.kind!r} of part {part.id!r}",
                f"{field}.kind",
                part.kind,
                f"the places' kinds are {', '.join(sorted(map(str, kinds)))}",
            )
        if part.present is None:
            continue
        if part.present not in labels:
            raise _refused(
                "unknown_place",
                f"there is no place {part.present!r} for part {part.id!r}",
                f"{field}.present",
                part.present,
                "use a label of the places",
            )
        key = (part.present, may_of(part) == "gone")
        if key in taken:
            raise _refused(
                "place_taken_twice",
                f"parts {taken[key]!r} and {part.id!r} are both in place {part.present!r}",
                f"{field}.present",
                part.present,
                "state where each part is",
            )
        taken[key] = part.id


def _check_part(field: str, part: PartToArrange, places: Sequence[Place]) -> None:
    readings = masses_of(part) if part.moment_g_mm is None else (*masses_of(part), part.moment_g_mm)
    for value in readings:
        if not value > 0.0:
            raise _refused(
                "mass_not_positive",
                f"part {part.id!r} has a reading of {value:g}",
                f"{field}.mass_g",
                value,
                "weigh it again; leave the mass out for a part that stays and was not weighed",
            )
    if part.moment_g_mm is not None and part.mass_g is not None and isinstance(part.mass_g, tuple):
        raise _refused(
            "moment_and_ends",
            f"part {part.id!r} has a moment and the masses of two ends",
            f"{field}.moment_g_mm",
            part.moment_g_mm,
            "state one of the two",
        )
    where = [place for place in places if place.label == part.present] if may_of(part) != "move" else places
    if len(masses_of(part)) == 2:
        short = next((place for place in where if fits(part, place) and len(place.axial_mm) == 1), None)
        if short is not None:
            raise _refused(
                "two_ended_part_in_one_ended_place",
                f"part {part.id!r} was weighed at both ends, but place {short.label!r} has one axial position",
                f"{field}.mass_g",
                list(masses_of(part)),
                "state both axial positions of the place, or the part's whole mass",
            )
    if may_of(part) == "stay" and part.present is None:
        raise _refused(
            "stays_without_place",
            f"part {part.id!r} is to stay, but its place is not stated",
            f"{field}.present",
            None,
            "state the place it is in, or its mass if it may move",
        )
    if may_of(part) == "move" and not readings:
        raise _refused(
            "part_not_weighed",
            f"part {part.id!r} may move, but was not weighed",
            f"{field}.mass_g",
            None,
            "weigh it, or let it stay",
        )


def _check_plausible(parts: Sequence[PartToArrange]) -> None:
    whole = [sum(masses_of(part)) for part in parts if part.mass_g is not None]
    if not whole:
        return
    median = statistics.median(whole)
    for index, part in enumerate(parts):
        mass = sum(masses_of(part))
        if part.mass_g is not None and not median / IMPLAUSIBLE < mass < median * IMPLAUSIBLE:
            raise _refused(
                "mass_implausible",
                f"part {part.id!r} has {mass:g} g, the median of the parts is {median:g} g",
                f"parts[{index}].mass_g",
                mass,
                "was kg typed as g? State every mass in g",
            )


def _check_groups(request: ArrangementRequest, places: Sequence[Place]) -> None:
    known = {place.group for place in places if place.group is not None}
    for index, limit in enumerate(request.group_limits):
        if limit.group not in known:
            raise _refused(
                "unknown_group",
                f"no place is in group {limit.group!r}",
                f"group_limits[{index}].group",
                limit.group,
                "name the group at its places",
            )
    limited = {limit.group for limit in request.group_limits}
    labels = {place.label for place in places if place.group in limited}
    for index, part in enumerate(request.parts):
        if part.mass_g is None and part.moment_g_mm is None and part.present in labels:
            raise _refused(
                "part_not_weighed",
                f"part {part.id!r} is in a group whose masses may differ by a limited amount, but was not weighed",
                f"parts[{index}].mass_g",
                None,
                "weigh it, or leave the limit of its group out",
            )


def _check_complete(request: ArrangementRequest, places: Sequence[Place]) -> None:
    """The drum was measured, or in balance, with the old parts on: what is in every place must be known."""
    relative_to = old_parts(request.parts, places)
    for place, k in zip(places, relative_to, strict=True):
        if k is None and not place.may_be_empty:
            raise _refused(
                "present_incomplete",
                f"place {place.label!r} held a part while the offset {request.offset} was taken, but none is stated",
                "parts",
                place.label,
                "state the part that was there with `present`; one that stays needs no mass",
            )
    for index, part in enumerate(request.parts):
        unknown = part.mass_g is None and part.moment_g_mm is None
        if may_of(part) == "gone" and part.present is not None and unknown:
            raise _refused(
                "part_not_weighed",
                f"part {part.id!r} is gone from place {part.present!r}, but its mass is not known",
                f"parts[{index}].mass_g",
                None,
                "weigh what was taken off, or measure the drum again",
            )


def _check_wishes(request: ArrangementRequest) -> None:
    unweighed = next((p for p in request.parts if p.mass_g is None and p.moment_g_mm is None), None)
    if unweighed is not None and request.offset not in ("measured", "in_balance_with_old"):
        raise _refused(
            "part_not_weighed",
            f"part {unweighed.id!r} was not weighed, and the offset is that of the bare drum",
            "parts",
            unweighed.id,
            "weigh every part, or state the offset measured or in_balance_with_old",
        )
    if request.mode == "fewest_moves" and request.limit is None:
        raise _refused(
            "limit_missing",
            "mode fewest_moves needs a limit of the objective",
            "limit",
            None,
            "state the limit in the objective's unit",
        )
    if request.mode == "fewest_moves" and all(part.present is None for part in request.parts):
        raise _refused(
            "present_missing",
            "mode fewest_moves needs the present arrangement",
            "parts",
            None,
            "state where each part is now with `present`",
        )


def _refused(
    code: str, message: str, field: str, value: object, advice: str = "give each its own name"
) -> InvalidInput:
    return InvalidInput(message, code=code, field=field, value=value, advice=advice)
