"""Whatever was answered 2xx can be read, listed, exported, imported elsewhere, verified and closed."""

from __future__ import annotations

import itertools
import shutil
import tempfile
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import hypothesis.strategies as st
from hypothesis import settings
from hypothesis.stateful import Bundle, RuleBasedStateMachine, consumes, rule, run_state_machine_as_test

from service.cli.commands.transfer import export_sessions, import_sessions
from service.usecases import audit
from service.usecases.readings.retention import retain
from service.usecases.repair import repair
from tests.support.http.workshop import DRUM, Workshop, mass

SIZES = st.floats(0.0, 1e9, allow_subnormal=False) | st.floats(0.01, 20.0).map(lambda value: round(value, 1))
PHASES = st.none() | st.integers(-360, 360).map(float) | st.floats(-360.0, 360.0)
YEARS = st.sampled_from([timedelta(0), timedelta(days=-3652), timedelta(days=3652), timedelta(minutes=-5)])


class Stored(RuleBasedStateMachine):
    """Requests in any order; at the end of each history all that was taken is looked at."""

    shop: Workshop
    sessions: Bundle[str] = Bundle("sessions")

    def __init__(self) -> None:
        super().__init__()
        self.machine, self.box = self.shop.machine(), self.shop.box(count=50)
        self.numbers = itertools.count()
        self.open: list[str] = []
        self.source = f"source of {self.machine}"
        self.shop.ask("PUT", f"/sources/{self.source}", {"machine_id": self.machine})

    def tried(self, method: str, path: str, body: object) -> Any:
        """The answer of a request that may be refused, but never with 5xx."""
        answer = self.shop.client.request(method, f"/api/v1{path}", json=body)
        assert answer.status_code < 500, f"{method} {path}: {answer.text}"
        return answer.json() if answer.is_success else None

    @rule(target=sessions)
    def begin(self) -> Any:
        session = self.shop.session(self.machine, self.box)
        self.open.append(session)
        return session

    @rule(session=sessions, count=st.integers(2, 12), size=SIZES, phase=PHASES, off=YEARS, twice=st.booleans())
    def take(self, session: str, count: int, size: float, phase: float | None, off: timedelta, twice: bool) -> None:
        begun: datetime = self.shop.now() + off
        first = next(self.numbers) * 100
        sent = [
            {
                "source": self.source,
                "sequence": first + place * (1 + twice),
                "taken_at": (begun + timedelta(milliseconds=place)).isoformat(),
                "sensor": "PQ"[place % 2],
                "amplitude": size,
                "phase_deg": phase,
            }
            for place in range(count)
        ]
        for _ in range(1 + twice):
            self.tried("POST", "/readings", sent)
        take = {"source": self.source, "from": sent[0]["taken_at"], "to": sent[-1]["taken_at"]}
        self.tried("POST", f"/sessions/{session}/runs", {"kind": "initial", "take": take})

    @rule(session=sessions, plane=st.sampled_from(["", "1", "2"]), grams=st.floats(1.0, 500.0))
    def type_run(self, session: str, plane: str, grams: float) -> None:
        masses = [mass(plane, grams, 20.0)] if plane else []
        body = {"kind": "trial" if plane else "initial", "masses": masses, "readings": DRUM.readings(masses)}
        self.tried("POST", f"/sessions/{session}/runs", body)

    @rule(session=sessions, last=st.booleans())
    def exclude(self, session: str, last: bool) -> None:
        runs = self.shop.get(f"/sessions/{session}")["runs"]
        if runs:
            path = f"/sessions/{session}/runs/{runs[-1 if last else 0]['id']}"
            self.tried("PATCH", path, {"excluded": last, "reason": "tried"})

    @rule(session=sessions, fit=st.booleans())
    def plan(self, session: str, fit: bool) -> None:
        correction = self.tried("POST", f"/sessions/{session}/corrections", {"source": "fit"})
        request = {"objective": "residual_vibration", "method": "exact", "max_masses_per_plane": 1}
        if correction is not None:
            body = {"correction_id": correction["id"], **request}
            plan = self.tried("POST", f"/sessions/{session}/plans", body)
            if plan is not None and fit:
                self.tried("POST", f"/plans/{plan['id']}/fitted", {})

    @rule(session=consumes(sessions))
    def close(self, session: str) -> None:
        assert self.shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})["state"] == "closed"
        self.open.remove(session)

    @rule()
    def roll_up(self) -> None:
        retain(self.shop.work, 1)

    def teardown(self) -> None:
        folder = Path(tempfile.mkdtemp())
        try:
            self.look(folder)
        finally:
            shutil.rmtree(folder)

    def look(self, folder: Path) -> None:
        """Read, list, export, import elsewhere, close and verify everything."""
        for session in self.shop.get(f"/sessions?machine_id={self.machine}&limit=200"):
            for path in ("", "/log", "/report.json", "/history"):
                self.shop.get(f"/sessions/{session['id']}{path}")
        url = self.shop.work.database.url.render_as_string(hide_password=False)
        assert export_sessions([], folder / "all.jsonl", url) == 0
        import_sessions(folder / "all.jsonl", f"sqlite:///{folder / 'elsewhere.db'}")
        for session in self.open:
            self.shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
        assert repair(self.shop.work).unreadable == ()
        assert audit.verify(self.shop.work).findings == ()


def test_whatever_was_answered_can_be_read_exported_verified_and_closed(shared_shop: Workshop) -> None:
    class OfShop(Stored):
        shop = shared_shop

    run_state_machine_as_test(OfShop, settings=settings(max_examples=6, stateful_step_count=12, deadline=None))
