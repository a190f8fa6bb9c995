"""Guide of a session: the step it is at, as the pages show it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

from service.engine.rotor_state import Drum
from service.engine.session_state import Progress
from service.model.correction import Correction
from service.model.machine import Plane, Sensor
from service.model.plan import Plan
from service.model.run import MassOnRotor, Run
from service.model.session import Session
from service.model.stop import Stop
from service.runtime.context import AppContext
from service.usecases.sessions import reports, sessions, stops
from service.web.language import N_

STEPS = ("initial", "trial", "correction", "plan", "fit", "check", "decide")
TITLES = {
    "initial": N_("As found"),
    "trial": N_("Trial runs"),
    "correction": N_("Correction"),
    "plan": N_("Plan"),
    "fit": N_("Fit"),
    "check": N_("Check"),
    "decide": N_("Finish"),
}


@dataclass(frozen=True)
class Guide:
    """A session with its stops.

    step: the one of STEPS that is next. part: begin, lock, change, release or run, where masses are changed for it.
    stop: the stop that part belongs to.
    """

    session: Session
    stops: tuple[Stop, ...]

    @cached_property
    def progress(self) -> Progress:
        """What the next step follows from."""
        session = self.session
        return Progress(
            state=session.state,
            machine=session.machine,
            runs=session.runs,
            corrections=session.corrections,
            plans=session.plans,
            stops=self.stops,
        )

    @cached_property
    def drum(self) -> Drum:
        """What is stored of the drum."""
        return reports.drum_of(self.session, self.stops)

    @property
    def stop(self) -> Stop | None:
        """The stop under way, or the one whose run is still to be taken."""
        return self.progress.stop

    @cached_property
    def step(self) -> str:
        """The page of the next step: a plan that may be fitted is begun on the plan's page."""
        step = self.progress.step
        if step == "closed":
            return "decide"
        return "plan" if step == "fit" and self.stop is None else step

    @cached_property
    def part(self) -> str:
        """How far the change of masses is."""
        stop = self.stop
        if stop is None:
            return "run" if self.step == "check" else "begin"
        if stop.locked_at is None:
            return "lock"
        if stop.masses is None:
            return "change"
        return "release" if stop.released_at is None else "run"

    @property
    def moment(self) -> str:
        """What a form of the page is of: the step, its stop, how far that is. What is typed for one is for no other."""
        return f"{self.step} {self.stop.number if self.stop is not None else 0} {self.part}"

    @property
    def used(self) -> tuple[Run, ...]:
        """Runs that are not excluded."""
        return self.progress.used

    @property
    def planes_to_try(self) -> tuple[str, ...]:
        """Planes in which no run had a mass."""
        return self.progress.planes_to_try

    @property
    def correction(self) -> Correction | None:
        """The latest correction, unless a run came after it."""
        return self.progress.correction

    @property
    def plan(self) -> Plan | None:
        """The latest plan that may be fitted."""
        return self.progress.plan

    @cached_property
    def fitted(self) -> Plan | None:
        """The plan that is bolted on."""
        return next((plan for plan in self.session.plans if plan.id == self.session.fitted_plan_id), None)

    @property
    def on_rotor(self) -> tuple[MassOnRotor, ...]:
        """ALL masses on the rotor now."""
        return self.session.masses_on_rotor

    @cached_property
    def turning_since(self) -> datetime | None:
        """When the machine was last released: readings from before it are of other masses."""
        released = [stop.released_at for stop in self.stops if stop.released_at is not None]
        return released[-1] if released else None

    @cached_property
    def stamp(self) -> str:
        """Changes with whatever is stored of the session: two tablets that show the same have the same."""
        session = self.session
        seen = (
            session.state,
            session.catalogue_id,
            [(run.id, run.excluded) for run in session.runs],
            [(one.id, one.stale) for one in session.corrections],
            [(plan.id, plan.state, plan.stale) for plan in session.plans],
            [(stop.id, stop.cancelled, stop.locked_at, stop.changed_at, stop.released_at) for stop in self.stops],
        )
        return hashlib.sha256(repr(seen).encode()).hexdigest()[:16]

    # ------------------------------------------------------------ parts of the machine
    def plane(self, name: str) -> Plane:
        """A correction plane by name."""
        return next(plane for plane in self.session.machine.planes if plane.name == name)

    def sensor(self, name: str) -> Sensor:
        """A sensor by name."""
        return next(sensor for sensor in self.session.machine.sensors if sensor.name == name)

    def runs(self, *kinds: str) -> list[Run]:
        """Runs of these kinds, excluded ones too."""
        return [run for run in self.session.runs if run.kind in kinds]

    # ------------------------------------------------------------ the way
    def reached(self, step: str) -> bool:
        """Whether a step is the next one or has something to show."""
        session = self.session
        has = {
            "initial": True,
            "trial": bool(session.runs),
            "correction": bool(session.corrections),
            "plan": bool(session.plans) or self.correction is not None,
            "fit": session.fitted_plan_id is not None or self.step == "fit",
            "check": bool(self.runs("check")),
            "decide": session.state in ("checked", "closed"),
        }
        return step == self.step or has[step]

    def place(self, step: str) -> str:
        """done, now or later."""
        if step == self.step and self.session.state != "closed":
            return "now"
        before = STEPS.index(step) < STEPS.index(self.step) or self.session.state == "closed"
        return "done" if before else "later"


def look(work: AppContext, session_id: str) -> Guide:
    """A session as it stands. Raises NotFound."""
    return Guide(sessions.get(work, session_id), stops.of(work, session_id))


def holes(plane: Plane) -> list[tuple[str, float]]:
    """Label and angle of every position."""
    labels: Sequence[str] = plane.hole_labels or [str(n + 1) for n in range(len(plane.positions_deg))]
    return list(zip(labels, plane.positions_deg, strict=True))
