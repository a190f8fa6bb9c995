"""The session as a state machine: what may follow what, what is next, and what to do instead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Protocol

from service.engine.evidence.follow_up import STOPS
from service.errors import OutOfOrder
from service.messages import Message, Word
from service.model.correction import Correction
from service.model.machine import Machine
from service.model.plan import Plan
from service.model.run import Run
from service.model.session import SessionState, Step
from service.model.stop import Stop

Event = Literal["run", "check", "correction", "plan", "fitted", "unfit", "close"]

_AFTER: dict[Event, SessionState] = {
    "check": "checked",
    "correction": "corrected",
    "plan": "planned",
    "fitted": "fitted",
    "unfit": "planned",
    "close": "closed",
}

_NEXT: dict[Step, Message] = {
    "initial": Message("next_initial"),
    "trial": Message("next_trial"),
    "correction": Message("next_correction"),
    "plan": Message("next_plan"),
    "fit": Message("next_fit"),
    "check": Message("next_check"),
    "decide": Message("next_decide"),
    "closed": Message("next_closed"),
}


class SessionFacts(Protocol):
    """What the state machine asks of a session before an event."""

    @property
    def id(self) -> str:
        """Identifier."""

    @property
    def state(self) -> str:
        """Where the session stands."""

    @property
    def fitted_plan_id(self) -> str | None:
        """The plan whose masses are mounted; None without one."""


@dataclass(frozen=True)
class Progress:
    """What the next step of a session follows from, all of it stored.

    stops: empty for a client that states no stops.
    """

    state: SessionState
    machine: Machine
    runs: Sequence[Run]
    corrections: Sequence[Correction]
    plans: Sequence[Plan]
    stops: Sequence[Stop] = ()

    @cached_property
    def used(self) -> tuple[Run, ...]:
        """Runs that are not excluded."""
        return tuple(run for run in self.runs if not run.excluded)

    @cached_property
    def planes_to_try(self) -> tuple[str, ...]:
        """Planes in which no run had a mass."""
        tried = {mass.plane for run in self.used for mass in run.masses}
        return tuple(plane.name for plane in self.machine.planes if plane.name not in tried)

    @cached_property
    def without_phase(self) -> bool:
        """Whether the runs state amplitudes only."""
        return bool(self.used) and not any(r.phase_deg is not None for run in self.used for r in run.readings)

    @cached_property
    def runs_missing(self) -> int:
        """How many runs are missing without phase: of each sensor 2 P + 1 amplitudes are needed for P planes."""
        return max(0, 2 * len(self.machine.planes) + 1 - len(self.used)) if self.without_phase else 0

    @cached_property
    def can_fit(self) -> bool:
        """Whether the runs are enough for a fit of their own."""
        enough = len(self.used) > len(self.machine.planes)
        return enough and not (self.needs_initial or self.planes_to_try or self.runs_missing)

    @cached_property
    def needs_initial(self) -> bool:
        """Whether the coefficients cannot be found without a run as found: too few others."""
        return len(self.used) <= len(self.machine.planes) and all(run.kind != "initial" for run in self.used)

    @cached_property
    def correction(self) -> Correction | None:
        """The latest correction, unless a run came after it."""
        return self.corrections[-1] if self.corrections and not self.corrections[-1].stale else None

    @cached_property
    def plan(self) -> Plan | None:
        """The latest plan, where it may be fitted."""
        last = self.plans[-1] if self.plans else None
        return last if last is not None and not last.stale and last.state in ("proposed", "unfitted") else None

    @cached_property
    def stop(self) -> Stop | None:
        """The stop under way, or the one whose run is still to be taken."""
        last = under_way(self.stops)
        if last is not None:
            return last
        done = [stop for stop in self.stops if not stop.cancelled]
        waits = bool(done) and done[-1].runs_before >= len(self.runs) and done[-1].purpose != "bare"
        return done[-1] if waits else None

    @cached_property
    def step(self) -> Step:
        """What is next."""
        if self.state == "closed":
            return "closed"
        if self.stop is not None:
            return _of_stop(self.stop)
        if self.state == "fitted":
            return "check"
        if self.state == "checked":
            return "decide"
        if self.state == "planned" and self.plan is not None:
            return "fit"
        if self.correction is not None:
            return "plan"
        if self.needs_initial:
            return "initial"
        return "correction" if self.can_fit else "trial"


def under_way(stops: Sequence[Stop]) -> Stop | None:
    """The stop that is neither released nor given up."""
    last = stops[-1] if stops else None
    return last if last is not None and last.released_at is None and not last.cancelled else None


def next_step(progress: Progress) -> Message:
    """What to do next; before a plan what is missing in fact, all runs but excluded ones counted."""
    step = progress.step
    if step == "correction" and progress.corrections:
        return Message("next_correction.again")
    if step == "decide" and progress.used and any(one.code in STOPS for one in progress.used[-1].warnings):
        return Message("next_decide.stop")
    if step not in ("initial", "trial") or not progress.used or progress.stop is not None:
        return _NEXT[step]
    missing = [Message("next_runs.initial")] if progress.needs_initial else []
    missing += [Message("next_runs.trial", plane=name) for name in progress.planes_to_try]
    if progress.runs_missing > len(missing):
        missing.append(Message("next_runs.more", count=progress.runs_missing - len(missing)))
    return Message("next_runs", missing=missing)


def after(session: SessionFacts, event: Event) -> SessionState:
    """The state that follows. Raises OutOfOrder once the session is closed, and for a check of nothing."""
    if session.state == "closed":
        raise OutOfOrder(Message("session_closed", session=session.id), field="session_id", value=session.id)
    if event == "check" and session.fitted_plan_id is None:
        raise OutOfOrder(
            Message("out_of_order.check_without_plan", state=Word(session.state)), field="kind", value="check"
        )
    if event == "run":
        return "fitted" if session.fitted_plan_id is not None else "open"
    return _AFTER[event]


def _of_stop(stop: Stop) -> Step:
    if stop.purpose == "trial":
        return "trial"
    return "check" if stop.purpose == "plan" and stop.released_at is not None else "fit"
