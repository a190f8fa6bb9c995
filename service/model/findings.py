"""What the signal chain finds of a block of waveforms beside the reading: harmonics, neighbours, doubts."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le, Len

from service.model.base import AngleDeg, Name, document

Flag = Literal["clipped", "dropout", "edges_repaired", "neighbour_tone", "beating", "speed_off"]
Doubt = Literal["one_x_not_dominant", "h_to_v_beyond_3", "h_to_v_not_90_deg", "axial_above_radial"]

Size = Annotated[float, Ge(0)]
"""Measured, not typed in: a ratio to next to nothing may be as great as it likes."""


@document
class OrderComponent:
    """One order of a channel."""

    order: Annotated[int, Ge(1), Le(20)]
    """Multiple of the speed."""
    amplitude: Size
    """Amplitude, in the sensor's unit and detection."""
    phase_deg: AngleDeg
    """Phase, degrees of the component's own period, in the machine's phase sense."""


@document
class NeighbourTone:
    """A tone of another machine."""

    order: Size
    """Its frequency over that of the rotor."""
    amplitude: Size
    """Amplitude, in the sensor's unit and detection."""


@document
class BearingDirections:
    """1x components in different directions at one bearing."""

    bearing: Name
    """Bearing."""
    h_to_v: Size | None
    """Horizontal over vertical amplitude."""
    h_minus_v_deg: AngleDeg
    """Phase of horizontal less that of vertical, degrees."""
    axial_to_radial: Size | None
    """Axial over the greater radial amplitude; null without an axial sensor."""
    doubts: Annotated[tuple[Doubt, ...], Len(0, 4)]
    """Signs that something besides unbalance is at work."""


@document
class Findings:
    """What was found of a channel beside its 1x component; of several blocks, of all of them together."""

    turns: Annotated[int, Ge(1), Le(1_000_000_000)]
    """Whole turns that were measured; of several blocks their sum."""
    components: Annotated[tuple[OrderComponent, ...], Len(1, 20)]
    """Order 1 and its harmonics; of several blocks the mean vectors of the orders that all have."""
    neighbour: NeighbourTone | None = None
    """The strongest tone within half an order of 1x."""
    flags: Annotated[tuple[Flag, ...], Len(0, 5)] = ()
    """What to know before trusting the reading; of several blocks whatever was said of any."""
    directions: BearingDirections | None = None
    """How the directions at the sensor's bearing compare; of several blocks those of the last."""
