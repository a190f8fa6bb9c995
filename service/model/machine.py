"""What a machine is, and what lies in the box of stock masses."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from annotated_types import Ge, Le, Len

from service.model.base import MAX_LIST, AngleDeg, Count, Finite, Name, NotNegative, Positive, Small, document

Share = Annotated[float, Ge(0), Le(0.5)]
Rotation = Literal["cw", "ccw"]
AngleSense = Literal["against_rotation", "with_rotation"]
PhaseSense = Literal["lag", "lead"]
Quantity = Literal["velocity", "acceleration", "displacement"]
Unit = Literal["mm/s", "in/s", "m/s2", "g", "um", "mm", "mil"]
Detection = Literal["rms", "peak", "peak_to_peak"]
Direction = Literal["horizontal", "vertical", "axial", "radial"]


@document
class Iso20816:
    """Which limits of ISO 20816-3 apply: industrial machines above 15 kW, 120 to 15000 r/min."""

    group: Literal[1, 2]
    """1: above 300 kW; 2: 15 to 300 kW."""
    support: Literal["rigid", "flexible"]
    """Kind of support."""


@document
class Bearing:
    """A bearing of the drum."""

    name: Name
    """Name of the bearing, as the workshop calls it."""
    axial_mm: Finite
    """Axial position, mm, measured from the mass centre."""


@document
class Plane:
    """A correction plane: a ring of positions (holes) that take masses."""

    name: Name
    """Name of the correction plane, unique in the machine."""
    radius_mm: Positive
    """Radius, mm, at which the masses sit."""
    axial_mm: Finite | None = None
    """Axial position, mm, from the mass centre; needed for bearing forces."""
    positions_deg: Annotated[tuple[AngleDeg, ...], Len(1, 360)]
    """Angles of the positions, degrees from the key-phasor mark in the machine's angle sense; 360 is stored as 0."""
    hole_labels: Annotated[tuple[Name, ...], MAX_LIST] | None = None
    """What is stamped beside each position, in the order of `positions_deg`."""
    masses_per_position: Small = 1
    """How many masses one position takes."""
    max_masses: Small
    """How many masses the plane takes in all."""
    max_total_mass_g: Positive | None = None
    """Greatest total mass, g, in the plane."""
    max_force_n: Positive | None = None
    """Greatest centrifugal force, N, on one position at service speed."""


@document
class Sensor:
    """A vibration sensor."""

    name: Name
    """Name of the sensor, unique in the machine."""
    axial_mm: Finite | None = None
    """Axial position, mm, from the mass centre."""
    bearing: Name | None = None
    """The bearing it sits on."""
    direction: Direction | None = None
    """Direction in which it measures."""
    quantity: Quantity = "velocity"
    """The measured quantity."""
    unit: Unit = "mm/s"
    """Unit of `amplitude`: mm/s or in/s; m/s2 or g; um, mm or mil."""
    detection: Detection = "rms"
    """Detection of `amplitude`: rms = peak / sqrt 2 = peak-to-peak / (2 sqrt 2)."""
    limit: Positive | None = None
    """Vibration limit of this sensor, in its own unit and detection."""
    serial: Name | None = None
    """Serial number, for the certificate."""


@document
class Uncertainty:
    """What readings and masses of a machine err by, besides the scatter stated with a reading; null: the default."""

    repeatability: Share | None = None
    """Standard deviation of a 1x vector from start to start of the same rotor, as a share of its amplitude, both
    components together. Default: learned from repeated runs, else 0.02, which is 0.014 per real component."""
    drift_per_run: Share | None = None
    """Standard deviation of the change from one run to the next while the machine warms up, as a share of the
    amplitude, all sensors alike; default 0."""
    mass_sd: Share | None = None
    """Standard deviation of the mass of a piece, as a share of it; default 0.005."""
    angle_sd_deg: Annotated[float, Ge(0), Le(30)] | None = None
    """Standard deviation of the angle of a piece, degrees; default 0.5."""


@document
class Machine:
    """A machine with one drum: geometry, sensors and the conventions of every number about it."""

    name: Name
    """Name of the machine."""
    type: Name | None = None
    """Type or model, shared by machines of one kind."""
    rotor_mass_kg: Positive | None = None
    """Mass of the rotor, kg."""
    service_speed_rpm: Positive
    """Speed in service, r/min."""
    rotation: Rotation = "ccw"
    """Direction of rotation, seen from `seen_from`."""
    seen_from: Name | None = None
    """The side from which the direction of rotation is meant."""
    balance_grade_mm_s: Positive | None = None
    """Balance quality grade G, mm/s (ISO 21940-11); G16 for agricultural machinery."""
    vibration_limit_mm_s: Positive | None = None
    """Limit for sensors without one of their own, mm/s rms of vibration velocity."""
    iso_20816: Iso20816 | None = None
    """Group and support by ISO 20816-3, for vibration zones; null for mobile machines, which it does not cover."""
    angle_sense: AngleSense = "against_rotation"
    """Sense in which mass angles count from the key-phasor mark."""
    phase_sense: PhaseSense = "lag"
    """lag: degrees the rotor turns from the mark passing the pick-up to the next positive peak; lead: its negative."""
    bearings: Annotated[tuple[Bearing, ...], MAX_LIST] = ()
    """The bearings; without them they stand at the sensors' axial positions."""
    uncertainty: Uncertainty | None = None
    """What its readings and masses err by from run to run; null: learned from its runs, else usual values."""
    planes: Annotated[tuple[Plane, ...], Len(1, 8)]
    """The correction planes."""
    sensors: Annotated[tuple[Sensor, ...], Len(1, 64)]
    """The sensors."""


@document
class StoredMachine(Machine):
    """A machine as it is stored."""

    id: str
    """Identifier."""
    created_at: datetime
    """When it was stored, UTC."""
    updated_at: datetime
    """When it was last changed, UTC."""


@document
class CatalogueItem:
    """One kind of stock mass."""

    mass_g: Positive
    """Mass of one piece, g."""
    count: Count | None
    """Pieces in the box; null: unlimited."""
    name: Name | None = None
    """Name or part number."""
    fastener_g: NotNegative = 0.0
    """Mass, g, of the fastener that goes in with each piece."""


@document
class Catalogue:
    """A box of stock masses."""

    name: Name
    """Name of the box."""
    items: Annotated[tuple[CatalogueItem, ...], Len(1, 10_000)]
    """The kinds of stock mass in it; a mass appears once."""


@document
class StockItem(CatalogueItem):
    """One kind of stock mass, with what is left of it."""

    on_hand: int | None
    """Pieces in the box, held ones included; null: unlimited."""
    reserved: int
    """Pieces of these that are held for plans."""
    available: int | None
    """Pieces that anybody may reserve or fit; null: unlimited."""


@document
class StoredCatalogue:
    """A box of stock masses as it is stored."""

    id: str
    """Identifier."""
    name: str
    """Name of the box."""
    items: tuple[StockItem, ...]
    """The kinds of stock mass, with what is left of each."""
    created_at: datetime
    """When it was stored, UTC."""


@document
class Pieces:
    """A number of pieces of one stock mass."""

    mass_g: Positive
    """Mass of one piece, g, as in the catalogue."""
    pieces: Annotated[int, Ge(0), Le(1_000_000)]
    """How many pieces."""


@document
class CataloguePatch:
    """Rename a box, put pieces into it, or state what a count found."""

    name: Name | None = None
    """New name."""
    received: Annotated[tuple[Pieces, ...], MAX_LIST] = ()
    """Pieces put into the box."""
    counted: Annotated[tuple[Pieces, ...], MAX_LIST] = ()
    """Pieces found in the box by counting; the difference is booked."""
