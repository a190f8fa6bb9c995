"""The ledger of a box: what came in, what is held for a plan, what was fitted, and what that leaves."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from annotated_types import Ge, Le, Len

from service.model.base import Name, Text, document
from service.model.machine import Pieces

MovementKind = Literal["received", "returned", "withdrawn", "counted", "reserved", "released", "expired", "fitted"]


@document
class StockBooking:
    """Pieces put into the box, taken out of it, or counted in it, by hand."""

    kind: Literal["received", "returned", "withdrawn", "counted"]
    """received: put into the box; returned: came back from a drum whose session is closed; withdrawn: lent, lost or
    scrapped; counted: this many were found, the difference is booked."""
    pieces: Annotated[tuple[Pieces, ...], Len(1, 1000)]
    """Of which masses how many; of a count, all that were found, those held for plans included."""
    note: Text | None = None
    """Delivery note, reason, who counted."""


@document
class Balance:
    """What the ledger comes to for one stock mass."""

    mass_g: float
    """Mass of one piece, g."""
    name: Name | None
    """Name or part number."""
    on_hand: int | None
    """Pieces in the box; null: unlimited."""
    reserved: int
    """Pieces of these that are held for plans."""
    available: int | None
    """Pieces that anybody may reserve or fit; null: unlimited."""


@document
class Hold:
    """Pieces held for a plan until they are fitted or the time is over."""

    mass_g: float
    """Mass of one piece, g."""
    pieces: int
    """How many pieces."""
    plan_id: str
    """The plan they are held for."""
    session_id: str
    """Its session."""
    machine_name: str
    """The machine they are meant for."""
    technician: str | None
    """Who balances it."""
    until: datetime
    """When the hold ends by itself, UTC."""


@document
class Movement:
    """One entry of the ledger; none is ever changed."""

    id: int
    """Number of the entry."""
    kind: MovementKind
    """received, returned, withdrawn, counted; reserved for a plan, released, expired, or fitted."""
    mass_g: float
    """Mass of one piece, g."""
    pieces: int
    """Pieces into the box, negative: out of it."""
    held: int
    """Pieces more that are held for the plan, negative: fewer."""
    session_id: str | None
    """Session it was booked for."""
    plan_id: str | None
    """Plan it was booked for."""
    until: datetime | None
    """When a reservation ends by itself, UTC."""
    note: str | None
    """Delivery note, reason, who counted."""
    at: datetime
    """When it was booked, UTC."""


@document
class Stock:
    """A box: its balances, what is held for whom, and its movements, newest first."""

    catalogue_id: str
    """The box."""
    items: tuple[Balance, ...]
    """Each stock mass with what the ledger comes to."""
    holds: tuple[Hold, ...]
    """What is held for plans now."""
    movements: tuple[Movement, ...]
    """The page of movements that was asked for."""


@document
class ReserveRequest:
    """Hold the pieces of a plan, so that no one else can take them."""

    minutes: Annotated[int, Ge(1), Le(1440)] = 120
    """How long, minutes; after that anybody may take them."""
