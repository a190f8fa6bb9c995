"""What to ask about a balancer's answer before masses are mounted by it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import timedelta

from db.rows import BalancerAnswerRow, CatalogueRow, SessionRow
from db.store import Store
from service.messages import Message, Quantity
from service.model.correction import CorrectionRequest
from service.model.diagnostic import Diagnostic, diagnostic
from service.model.machine import Plane

AHEAD = timedelta(seconds=60)
"""An answer that is dated further after the moment at which it came is of another clock, or of another day."""


def doubts_of(store: Store, session: SessionRow, request: CorrectionRequest) -> tuple[Diagnostic, ...]:
    """Findings on the answer that a correction is taken from: its time, its session, its planes, its masses."""
    row = None if request.answer_id is None else store.get(BalancerAnswerRow, request.answer_id)
    about_row = () if row is None else tuple(_of_row(store, session, row))
    return (*about_row, *_of_masses(store, session, {mass.plane: mass.mass_g for mass in request.masses or ()}))


def _of_row(store: Store, session: SessionRow, row: BalancerAnswerRow) -> Iterator[Diagnostic]:
    opened, came = session.created_at, row.received_at
    if row.taken_at < opened:
        told = Message("answer_older_than_session", before=Quantity((opened - row.taken_at).total_seconds(), "s"))
        yield diagnostic(told, "warning")
    if came is not None and row.taken_at > came + AHEAD:
        told = Message("answer_dated_ahead", ahead=Quantity((row.taken_at - came).total_seconds(), "s"))
        yield diagnostic(told, "warning")
    others = [one for one in store.open_sessions(session.machine_id) if one.id != session.id]
    if row.session_id is None and others:
        yield diagnostic(Message("answer_for_several_sessions", sessions=len(others) + 1), "warning")


def _of_masses(store: Store, session: SessionRow, masses: Mapping[str, float]) -> Iterator[Diagnostic]:
    box = None if session.catalogue_id is None else store.get(CatalogueRow, session.catalogue_id)
    heaviest = max((item.mass_g + item.fastener_g for item in box.items), default=0.0) if box else None
    for plane in session.machine.planes:
        if plane.name not in masses:
            yield diagnostic(Message("plane_not_answered", plane=plane.name), "warning", planes=(plane.name,))
        elif heaviest is not None and abs(masses[plane.name]) > (most := _most_g(plane, heaviest)):
            told = Message(
                "answer_beyond_box",
                plane=plane.name,
                mass=Quantity(masses[plane.name], "g"),
                most=Quantity(most, "g"),
            )
            yield diagnostic(told, "warning", planes=(plane.name,))


def _most_g(plane: Plane, heaviest: float) -> float:
    """The most that a plane can take of a box, g: all of it in one direction is less."""
    most = plane.max_masses * heaviest
    return most if plane.max_total_mass_g is None else min(most, plane.max_total_mass_g)
