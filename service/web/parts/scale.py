"""The weighing page: which place is next, and what was typed of the part in it."""

from __future__ import annotations

from collections.abc import Sequence

from service.model.parts import Mass, PartRecord, PartWeighed, Place, PlaceSet
from service.web.forms import Form
from service.web.rendering import Page

SPARE = ""
"""Stands for the place of a part that is not mounted."""
MAX_G = 1e6


def in_places(records: Sequence[PartRecord]) -> dict[str, PartRecord]:
    """The part of each place, by label."""
    return {one.place: one for one in records if one.place is not None}


def first_to_weigh(places: Sequence[Place], records: Sequence[PartRecord]) -> str:
    """The first place whose part has no mass yet; the first of all where every one has."""
    known = in_places(records)
    return next((p.label for p in places if p.label not in known or not weighed(known[p.label])), places[0].label)


def following(places: Sequence[Place], label: str) -> str | None:
    """The place after this one; None after the last, and after a spare part."""
    labels = [place.label for place in places]
    index = labels.index(label) + 1 if label in labels else len(labels)
    return labels[index] if index < len(labels) else None


def weighed(record: PartRecord) -> bool:
    """Whether a part was weighed."""
    return record.mass_g is not None or record.moment_g_mm is not None


def ends_of(found: PlaceSet, label: str) -> int:
    """Readings that a part of this place is weighed with."""
    place = next((one for one in found.places if one.label == label), found.places[0])
    return len(place.axial_mm)


def blank(page: Page, label: str, before: PartRecord | None, taken: set[str]) -> Form:
    """The form of a place: the number that its part is known by, else its own label where that is free."""
    number = before.part if before is not None else label if label not in taken else ""
    return Form({"part": number}, page.preferences)


def read(page: Page, form: Form, found: PlaceSet, label: str) -> PartWeighed | None:
    """What was typed of one part; None where a field is wrong."""
    part = form.text("part", required=True)
    mass = read_mass(page, form, "mass", ends_of(found, label))
    kinds = sorted({place.kind for place in found.places if place.kind is not None})
    place = next((one for one in found.places if one.label == label), None)
    kind = place.kind if place is not None else form.choice("kind", kinds) if kinds else None
    if not form.ok or part is None:
        return None
    return PartWeighed(part=part, mass_g=mass, kind=kind, place=label or None)


def read_mass(page: Page, form: Form, name: str, ends: int, *, required: bool = True) -> Mass:
    """One mass, or both ends', in g; None where it is wrong or left out."""
    unit = page.display.mass_unit()
    if ends == 1:
        return form.number(name, above=0.0, high=MAX_G, unit=unit, required=required)
    left = form.number(f"{name}_left", above=0.0, high=MAX_G, unit=unit, required=required)
    right = form.number(f"{name}_right", above=0.0, high=MAX_G, unit=unit, required=required or left is not None)
    return None if left is None or right is None else (left, right)
