"""`drumtrue bench web`: how long the server takes for each page, how heavy it is, and what it asks for from elsewhere.

A thousand sessions are stored first: one balanced whole on a simulated drum, the others its copies under other keys.
Pages are asked for in the process itself: no network, but everything else, login and form token included.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

from rich.console import Console
from starlette.testclient import TestClient

from db.rows import CorrectionRow, PlanRow, RunRow, SessionRow
from drivers.clock import ManualClock
from drivers.simulator.drum_driver import SimulatedDrum
from drivers.simulator.example import STOCK_G, threshing_drum_example
from drivers.simulator.spec import FittedMass
from service import bootstrap
from service.app import create_app
from service.bench.timing import show, timed
from service.engine import mapping
from service.model.correction import CorrectionRequest
from service.model.machine import Catalogue, CatalogueItem, Machine, Plane, Sensor
from service.model.plan import FittedRequest, PlanRequest
from service.model.run import MassOnRotor, RunKind, RunReading, RunRequest
from service.model.session import SessionRequest
from service.runtime.context import AppContext
from service.settings import Settings
from service.usecases.machines import machines
from service.usecases.plans import corrections, plans
from service.usecases.sessions import runs, sessions
from service.usecases.stock import catalogues

SESSIONS = 1000
AIM_S, AIM_BYTES = 0.050, 150_000
SEED = 7
STEPS = ("initial", "trial", "correction", "plan", "fit", "check", "decide")
HTML = {"accept": "text/html", "accept-language": "en"}
_ELSEWHERE = re.compile(r"""(?:src|href|action)=["']?(?:https?:)?//""")


@dataclass(frozen=True)
class Measured:
    """A page: median and 95th percentile in s, its weight in bytes, whether it names another site."""

    path: str
    median_s: float
    p95_s: float
    size: int
    elsewhere: bool

    @property
    def good(self) -> bool:
        """Quick, light, and content with this server."""
        return self.p95_s < AIM_S and self.size < AIM_BYTES and not self.elsewhere


def bench_web(*, stored: int = SESSIONS, repeats: int = 60, markdown: bool = False) -> bool:
    """Measure every page and print a table; whether all keep the aims."""
    measured = measure(stored=stored, repeats=repeats)
    lines = [
        (
            m.path,
            f"{1e3 * m.median_s:.1f} ms",
            f"{1e3 * m.p95_s:.1f} ms",
            f"{m.size / 1e3:.0f} kB",
            "met" if m.good else "MISSED",
        )
        for m in measured
    ]
    aims = f"p95 below {1e3 * AIM_S:.0f} ms, below {AIM_BYTES / 1e3:.0f} kB, nothing from elsewhere"
    header = ("page", "median", "p95", "size", "aim")
    show(Console(), f"Pages, {stored} sessions stored; {aims}", header, lines, markdown=markdown)
    return all(m.good for m in measured)


def measure(*, stored: int, repeats: int) -> list[Measured]:
    """Each page, on a database of its own with this many sessions."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(database_url=f"sqlite:///{Path(folder) / 'bench.db'}", loopback=True)
        work = bootstrap.build_work(settings)
        paths = _stored(work, stored)
        with TestClient(create_app(settings, work), base_url="http://localhost", headers=HTML) as client:
            measured = [_measured(client, path, name, repeats) for name, path in paths]
        work.database.close()
        return measured


def _measured(client: TestClient, path: str, name: str, repeats: int) -> Measured:
    answer = client.get(path)
    assert answer.status_code == 200, f"{path}: {answer.status_code}"  # noqa: S101
    median, p95 = timed(lambda: client.get(path), repeats=repeats, warm_up=3)
    return Measured(name, median, p95, len(answer.content), _ELSEWHERE.search(answer.text) is not None)


# ---------------------------------------------------------------- what is stored
def _stored(work: AppContext, count: int) -> list[tuple[str, str]]:
    """A whole session and its copies; names and addresses of the pages."""
    spec = threshing_drum_example(SEED)
    machine = machines.create(work, _machine("Bench drum")).id
    items = tuple(CatalogueItem(mass_g=mass, count=10) for mass in STOCK_G)
    box = catalogues.create(work, Catalogue(name="Bench box", items=items)).id
    with SimulatedDrum(
        spec, seed=SEED, clock=ManualClock(datetime.now(UTC) - timedelta(hours=1)), source="bench"
    ) as drum:
        session = _balanced(work, drum, machine, box)
    _copied(work, session, count - 1)
    listed = [
        ("/", "/"),
        ("/sessions", "/sessions"),
        ("/sessions?words=", "/sessions?words=bench"),
        ("/machines", "/machines"),
    ]
    listed += [("/machines/{id}", f"/machines/{machine}"), ("/machines/{id}/edit", f"/machines/{machine}/edit")]
    listed += [
        ("/boxes", "/boxes"),
        ("/boxes/{id}", f"/boxes/{box}"),
        ("/sources", "/sources"),
        ("/sessions/new", "/sessions/new"),
    ]
    listed += [(f"/sessions/{{id}}/step/{step}", f"/sessions/{session}/step/{step}") for step in STEPS]
    listed += [(f"/sessions/{{id}}/{name}", f"/sessions/{session}/{name}") for name in ("runs", "report")]
    return listed


def _machine(name: str) -> Machine:
    spec = threshing_drum_example(SEED)
    return Machine(
        name=name,
        rotor_mass_kg=spec.rotor.mass_kg,
        service_speed_rpm=spec.speed_rpm,
        rotation=spec.rotation,
        vibration_limit_mm_s=0.5,
        balance_grade_mm_s=16.0,
        angle_sense=spec.angle_sense,
        phase_sense=spec.phase_sense,
        planes=tuple(
            Plane(name=p.name, radius_mm=p.radius_mm, axial_mm=p.axial_mm, positions_deg=p.positions_deg, max_masses=3)
            for p in spec.planes
        ),
        sensors=tuple(Sensor(name=s.name, axial_mm=s.axial_mm) for s in spec.sensors),
    )


def _balanced(work: AppContext, drum: SimulatedDrum, machine: str, box: str) -> str:
    """Initial run, a trial run a plane, correction, plan, fitted, checked; as many further runs as make twelve."""
    session = sessions.open_on(work, SessionRequest(machine_id=machine, catalogue_id=box, technician="bench")).id

    def run(kind: RunKind, masses: Sequence[MassOnRotor]) -> None:
        drum.fit_masses(FittedMass(m.plane, m.mass_g, m.angle_deg) for m in masses)
        readings = tuple(
            RunReading(sensor=r.sensor, amplitude=r.amplitude, phase_deg=r.phase_deg) for r in drum.measure(1)
        )
        stated = None if kind == "check" else tuple(masses)
        runs.add(work, session, RunRequest(kind=kind, masses=stated, readings=readings))

    run("initial", ())
    for repeat in range(5):
        for plane in drum.spec.planes:
            run("trial", (MassOnRotor(plane=plane.name, mass_g=100.0, angle_deg=20.0 * repeat),))
    correction = corrections.add(work, session, CorrectionRequest(source="fit"))
    request = PlanRequest(correction_id=correction.id, objective="residual_vibration", alternatives=3)
    plan = plans.fitted(work, plans.propose(work, session, request).id, FittedRequest())
    run("check", mapping.masses_on_rotor(plan))
    return session


def _copied(work: AppContext, session_id: str, count: int) -> None:
    with work.write() as store:
        session = store.get(SessionRow, session_id)
        assert session is not None  # noqa: S101
        whole = (store.runs(session_id), store.corrections(session_id), store.plans(session_id))
        for number in range(count):
            key = work.new_id()
            columns = {c.key: getattr(session, c.key) for c in SessionRow.__table__.columns}
            at = session.created_at - timedelta(hours=number + 1)
            state = {"state": "closed", "closed_at": at, "fitted_plan_id": None}
            store.add(SessionRow(**{**columns, **state, "id": key, "created_at": at}))
            for row in whole[0]:
                store.add(RunRow(id=work.new_id(), session_id=key, number=row.number, run=row.run))
            for one in whole[1]:
                store.add(CorrectionRow(id=work.new_id(), session_id=key, number=one.number, correction=one.correction))
            for made in whole[2]:
                plan = replace(made.plan, session_id=key)
                store.add(PlanRow(id=work.new_id(), session_id=key, number=made.number, plan=plan))
