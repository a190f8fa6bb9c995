"""The session as a state machine: what may follow what, and what to do instead."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol

from service.errors import OutOfOrder
from service.model.correction import Correction
from service.model.machine import Machine
from service.model.run import Run
from service.model.session import SessionState

Event = Literal["run", "check", "correction", "plan", "fitted", "unfit", "close"]

_AFTER: dict[Event, SessionState] = {
    "check": "checked",
    "correction": "corrected",
    "plan": "planned",
    "fitted": "fitted",
    "unfit": "planned",
    "close": "closed",
}

_NEXT: dict[str, str] = {
    "open": "take an initial run and a trial run in each plane, then ask for corrections",
    "corrected": "ask for a plan: which stock masses go into which holes",
    "planned": "stop and lock the machine, fit the masses of the plan, then report them fitted",
    "fitted": "take a check run",
    "checked": "close the session, or ask for corrections again to trim",
    "closed": "the session is finished; open a new one to go on",
}


def next_step(state: str, machine: Machine, runs: Sequence[Run], corrections: Sequence[Correction]) -> str:
    """What to do next, in a sentence; before a plan what is missing in fact, all runs but excluded ones counted."""
    used = [run for run in runs if not run.excluded]
    if state != "open" or not used:
        return _NEXT[state]
    if corrections and not corrections[-1].stale:
        return _NEXT["corrected"]
    tried = {mass.plane for run in used for mass in run.masses}
    missing = [f"a trial run in plane {plane.name}" for plane in machine.planes if plane.name not in tried]
    if len(used) <= len(machine.planes) and all(run.kind != "initial" for run in used):
        missing = ["an initial run", *missing]
    if missing:
        return f"take {' and '.join(missing)}, then ask for corrections"
    return "ask for corrections again: the runs changed since" if corrections else "ask for corrections"


class SessionFacts(Protocol):
    """What the state machine asks of a session."""

    @property
    def id(self) -> str:
        """Identifier."""

    @property
    def state(self) -> str:
        """Where the session stands."""

    @property
    def fitted_plan_id(self) -> str | None:
        """The plan whose masses are mounted; None without one."""


def after(session: SessionFacts, event: Event) -> SessionState:
    """The state that follows. Raises OutOfOrder once the session is closed, and for a check of nothing."""
    if session.state == "closed":
        raise OutOfOrder(
            f"session {session.id} is closed",
            code="session_closed",
            field="session_id",
            value=session.id,
            advice="open a new session on the machine",
        )
    if event == "check" and session.fitted_plan_id is None:
        raise OutOfOrder(
            f"a check run follows a fitted plan; the session is {session.state}",
            field="kind",
            value="check",
            advice="report a plan fitted first, or store the run as kind correction with all masses on the rotor",
        )
    if event == "run":
        return "fitted" if session.fitted_plan_id is not None else "open"
    return _AFTER[event]
