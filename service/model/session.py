"""Sessions, and the log of one: a document that gives the same answer again."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from pydantic import AwareDatetime, BeforeValidator

from service.messages import Message
from service.model.base import MAX_LIST, AngleDeg, Count, Key, Name, Positive, Text, document
from service.model.correction import Correction
from service.model.diagnostic import Diagnostic
from service.model.faults import BrokenRule
from service.model.machine import Catalogue, Machine
from service.model.message import MessageData
from service.model.plan import Plan
from service.model.run import MassOnRotor, Run, RunOut
from service.model.stop import Stop

SessionState = Literal["open", "corrected", "planned", "fitted", "checked", "closed"]
Step = Literal["initial", "trial", "correction", "plan", "fit", "check", "decide", "closed"]


@document
class AsFoundPiece:
    """A piece that is on the as-found rotor already."""

    plane: Name
    """Correction plane."""
    position_deg: AngleDeg
    """Angle of its position, degrees; one of the plane's positions."""
    mass_g: Positive
    """Mass, g, its fastener included."""
    may: Literal["stay", "move", "remove"]
    """stay: it stays; move: it may go to any position, or come off; remove: it may come off."""


@document
class SessionRequest:
    """Open a session on a machine."""

    machine_id: Name
    """The machine; its conventions are copied into the session."""
    catalogue_id: Name | None = None
    """The box of stock masses; needed for a plan."""
    technician: Name | None = None
    """Who balances."""
    note: Text | None = None
    """Anything worth knowing."""
    run_out: Annotated[tuple[RunOut, ...], MAX_LIST] = ()
    """Run-out vectors, subtracted from every reading."""
    on_rotor: Annotated[tuple[AsFoundPiece, ...], MAX_LIST] = ()
    """Pieces on the as-found rotor that a plan may move or take off."""


def _not_reopened(state: object) -> object:
    if state in ("open", "corrected", "planned", "fitted", "checked"):
        raise BrokenRule(Message("invalid_input.session_state"))
    return state


@document
class SessionPatch:
    """Change what may be changed of a session; a closed one may not."""

    state: Annotated[Literal["closed"] | None, BeforeValidator(_not_reopened)] = None
    """closed: nothing more is added or changed."""
    catalogue_id: Name | None = None
    """Another box of stock masses; refused while a plan is fitted."""
    technician: Name | None = None
    """Who balances."""
    note: Text | None = None
    """Anything worth knowing."""


@document
class SessionSummary:
    """A session in a list."""

    id: str
    """Identifier."""
    state: SessionState
    """open, corrected, planned, fitted, checked or closed."""
    machine_id: str
    """Machine."""
    machine_name: str
    """Name of the machine when the session opened."""
    catalogue_id: str | None
    """Box of stock masses."""
    technician: str | None
    """Who balances."""
    note: str | None
    """Anything worth knowing."""
    created_at: datetime
    """When it was opened, UTC."""
    closed_at: datetime | None
    """When it was closed, UTC."""


@document
class SetApart:
    """A part of a session that is stored and cannot be read; it takes part in nothing until it is repaired."""

    kind: str
    """What: run, correction, plan or stop."""
    id: str
    """Identifier."""
    number: int
    """1, 2, 3 ... in the order of the session."""
    field: str
    """The field that breaks a rule, such as run.readings[0].scatter."""
    rule: str
    """The rule it breaks."""


@document
class Session(SessionSummary):
    """A session: one drum being balanced."""

    step: Step
    """What is next: initial, trial, correction, plan, fit, check, decide, or closed."""
    next_step: str
    """What to do next, in a sentence."""
    next_step_data: MessageData
    """`next_step` as key and parameters, for other languages and units."""
    machine: Machine
    """The machine as it was when the session opened: every number of the session is meant in its conventions."""
    run_out: tuple[RunOut, ...]
    """Run-out vectors, subtracted from every reading."""
    on_rotor: tuple[AsFoundPiece, ...]
    """Pieces on the as-found rotor that a plan may move or take off."""
    runs: tuple[Run, ...]
    """The runs, in order."""
    corrections: tuple[Correction, ...]
    """The corrections, in order."""
    plans: tuple[Plan, ...]
    """The plans, in order."""
    fitted_plan_id: str | None
    """The plan that is bolted on."""
    masses_on_rotor: tuple[MassOnRotor, ...]
    """ALL masses on the rotor now, relative to the as-found rotor, as last stated by a run, a stop or a fitted plan."""
    unchecked: tuple[Diagnostic, ...]
    """Why the drum, as it is now, is not known to run within its limits: what no check run has measured. Empty: every
    sensor with a limit was measured, at every speed."""
    version: int
    """Counts the changes of the session and of its runs, corrections and plans; its ETag."""
    unreadable: tuple[SetApart, ...] = ()
    """Parts that are stored and cannot be read: left out of the lists above; `drumtrue repair` tells what to do."""


@document
class EarlierBox:
    """A box of stock masses that plans were made from before the session was given another."""

    catalogue_id: Name
    """Identifier, as in the `inputs` of those plans."""
    catalogue: Catalogue
    """The box; each plan states what was on hand."""


@document
class SessionRecord:
    """What a service keeps of a session beside its answers: with it another one can store the session."""

    state: SessionState
    """open, corrected, planned, fitted, checked or closed."""
    machine_id: Key
    """Machine."""
    catalogue_id: Key | None
    """Box of stock masses."""
    technician: Name | None
    """Who balances."""
    note: Text | None
    """Anything worth knowing."""
    fitted_plan_id: Key | None
    """The plan that is bolted on."""
    stops: tuple[Stop, ...]
    """Stops of the machine to change masses, in order."""
    version: Count
    """Counts the changes of the session and of its runs, corrections and plans."""
    created_at: AwareDatetime
    """When it was opened, UTC."""
    closed_at: AwareDatetime | None
    """When it was closed, UTC."""


@document
class SessionLog:
    """All that is needed to find a session's answers again, without the service."""

    format: Literal["drumtrue-session"] = "drumtrue-session"
    """Always drumtrue-session."""
    version: str
    """Version of Drumtrue that wrote it."""
    session_id: str | None = None
    """The session it was written from."""
    machine: Machine
    """The machine as the session has it."""
    catalogue: Catalogue | None = None
    """The box of stock masses; counts as received; each plan states what was on hand."""
    earlier_boxes: Annotated[tuple[EarlierBox, ...], MAX_LIST] = ()
    """Boxes of plans that were not made from `catalogue`."""
    run_out: Annotated[tuple[RunOut, ...], MAX_LIST] = ()
    """Run-out vectors."""
    on_rotor: Annotated[tuple[AsFoundPiece, ...], MAX_LIST] = ()
    """Pieces on the as-found rotor that a plan may move or take off."""
    runs: tuple[Run, ...] = ()
    """The runs, in order."""
    corrections: tuple[Correction, ...] = ()
    """The corrections, in order, with what was asked for."""
    plans: tuple[Plan, ...] = ()
    """The plans, in order, with what was asked for."""
    record: SessionRecord | None = None
    """What else is stored of the session; an import needs it, an answer does not."""
    unreadable: tuple[SetApart, ...] = ()
    """Parts that could not be read and are not in this log; such a log can be solved, but not imported."""
