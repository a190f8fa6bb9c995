"""Stops: the machine is locked, masses are changed, and it is released again."""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from service.model.base import Name, document
from service.model.plan import Placement
from service.model.run import MassOnRotor

StopPurpose = Literal["trial", "plan", "bare"]


@document
class StopRequest:
    """Stop the machine to change masses."""

    purpose: StopPurpose
    """trial: a trial mass goes on; plan: the masses of a plan go on; bare: everything comes off."""
    plane: Name | None = None
    """Plane of a trial mass."""
    plan_id: Name | None = None
    """The plan whose masses go on."""
    alternative: int | None = None
    """Which of the plan's alternatives, counted from 0; null: the plan itself."""


@document
class Stop:
    """One stop of the machine; each step is stated by who stands beside it, with its time."""

    id: str
    """Identifier."""
    number: int
    """1, 2, 3 ... in the order of the session."""
    purpose: StopPurpose
    """What the stop is for."""
    plane: str | None
    """Plane of a trial mass."""
    plan_id: str | None
    """The plan whose masses go on."""
    placements: tuple[Placement, ...]
    """Pieces that are to be on the rotor afterwards; empty for a trial."""
    runs_before: int
    """Runs stored when the stop began: the next run belongs to it."""
    begun_at: datetime
    """When, UTC."""
    locked_at: datetime | None = None
    """When the machine was stated to stand still, locked: key out, drum blocked; UTC."""
    masses: tuple[MassOnRotor, ...] | None = None
    """ALL masses on the rotor afterwards, relative to the as-found rotor; null until they are on."""
    changed_at: datetime | None = None
    """When the masses were stated to be on, UTC."""
    changed_after_run: int | None = None
    """How many runs the session had when the masses were stated; null: not yet, or before this was kept."""
    released_at: datetime | None = None
    """When bolts were stated torqued, tools out, guards on: the machine may run; UTC."""
    cancelled: bool = False
    """True: given up before anything was changed."""
