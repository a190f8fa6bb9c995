"""Places of a machine and the parts in them, as they are weighed, mounted and taken off."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from annotated_types import Len

from service.model.base import AngleDeg, Finite, Name, Positive, Text, document

Mass = float | Annotated[tuple[float, ...], Len(2, 2)] | None
MAX_PLACES, MAX_WEIGHED = 200, 300


@document
class Place:
    """A place on the drum that takes one part."""

    label: Name
    """What is written at the place, unique in the set."""
    angle_deg: AngleDeg
    """Angle of the mounted part's mass centre, degrees from the mark, in the machine's angle sense."""
    radius_mm: Positive
    """Radius of the mounted part's mass centre, mm."""
    axial_mm: Annotated[tuple[Finite, ...], Len(1, 2)]
    """Axial position of the part, mm: one value, or those of its two ends, where it is weighed at both."""
    kind: Name | None = None
    """What fits here, such as left or right; null: any part."""
    group: Name | None = None
    """Group of places whose parts may differ by a limited mass only."""
    may_be_empty: bool = False
    """Whether the place may hold no part."""


@document
class PlaceSetRequest:
    """The places of one kind of part on a machine."""

    places: Annotated[tuple[Place, ...], Len(1, MAX_PLACES)]
    """The places."""


@document
class PlaceSet:
    """A set of places of a machine as it is stored."""

    name: str
    """Name of the set."""
    places: tuple[Place, ...]
    """The places."""
    updated_at: datetime
    """When it was last changed, UTC."""


@document
class PartRecord:
    """One line of a part's history on a machine: weighed, mounted or taken off."""

    part: str
    """Part."""
    event: Literal["mounted", "taken_off", "weighed"]
    """What happened."""
    place: str | None
    """Where it is mounted since; null: not mounted."""
    mass_g: Mass
    """Mass as weighed, g; both ends where it was weighed so; null: not weighed."""
    moment_g_mm: float | None
    """Reading of a moment scale, g.mm; null without one."""
    kind: str | None
    """Kind; null without one."""
    place_set: str | None = None
    """Set of places that the part belongs to; null where none was named."""
    arrangement_id: str | None
    """The arrangement that it belongs to."""
    note: str | None
    """Remark."""
    at: datetime
    """When, UTC."""


@document
class PartWeighed:
    """One part on the scale."""

    part: Name
    """What is written on the part, unique on the machine."""
    mass_g: Mass = None
    """Mass, g; or the two masses read at its ends, g."""
    moment_g_mm: float | None = None
    """Reading of a moment scale, g.mm, in place of the mass."""
    kind: Name | None = None
    """Kind; it fits where the place has the same kind or none."""
    place: Name | None = None
    """Place it is mounted in now; null: not mounted."""


@document
class WeighRequest:
    """Weigh parts of a machine."""

    place_set: Name | None = None
    """Set of places that the parts belong to."""
    parts: Annotated[tuple[PartWeighed, ...], Len(1, MAX_WEIGHED)]
    """The parts; what was in the place of one of them before counts as taken off."""
    note: Text | None = None
    """A remark for the history."""
