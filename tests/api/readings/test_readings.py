"""Readings and answers of bridges: stored once, all or none, averaged as vectors."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest

from tests.support.http.workshop import Workshop, mass, reading, vector_of

NOON = "2025-12-01T12:00:00+00:00"
"""Before the tests' clock: what is dated ahead of it is set apart."""


def at(second: float) -> str:
    """A moment after noon."""
    return f"2025-12-01T12:{int(second // 60):02}:{second % 60:09.6f}+00:00"


def arrival(sequence: int, vector: complex = 1.0 + 1.0j, sensor: str = "P", **more: Any) -> dict[str, Any]:
    """A reading of the bridge, a second after the one before it."""
    stamp = {"source": "bridge", "sequence": sequence, "taken_at": at(sequence)}
    return {**stamp, **reading(sensor, vector, **more)}


def answer(sequence: int, **more: Any) -> dict[str, Any]:
    """A balancer's answer."""
    body = {"source": "bridge", "sequence": sequence, "taken_at": at(sequence), "masses": [mass("1", 170.2, 70.0)]}
    return {**body, **more}


@pytest.fixture
def machine(shop: Workshop) -> str:
    """A machine with a bridge."""
    stored = shop.machine()
    shop.ask("PUT", "/sources/bridge", {"machine_id": stored})
    return stored


def take(shop: Workshop, session: str, last: float = 60.0, **changes: Any) -> Any:
    """The readings of a run taken from those of the bridge."""
    source = {"source": "bridge", "from": NOON, "to": at(last), **changes}
    return shop.post(f"/sessions/{session}/runs", {"kind": "initial", "take": source})["readings"]


@pytest.mark.usefixtures("machine")
class TestOnce:
    def test_a_reading_sent_again_is_a_duplicate(self, shop: Workshop) -> None:
        batch = [arrival(n) for n in range(5)]
        assert shop.post("/readings", batch) == {"accepted": 5, "duplicates": 0}
        assert shop.post("/readings", batch) == {"accepted": 0, "duplicates": 5}
        assert shop.post("/readings", [*batch, arrival(5)]) == {"accepted": 1, "duplicates": 5}
        assert shop.post("/readings", arrival(6)) == {"accepted": 1, "duplicates": 0}
        assert shop.count("reading") == 7

    def test_a_reading_twice_in_one_batch_is_stored_once(self, shop: Workshop) -> None:
        assert shop.post("/readings", [arrival(1), arrival(1)]) == {"accepted": 1, "duplicates": 1}
        assert shop.count("reading") == 1

    def test_the_moment_counts_not_how_it_is_written(self, shop: Workshop) -> None:
        first = {**arrival(1), "taken_at": "2025-12-01T12:00:01.250000Z"}
        shop.post("/readings", first)
        again = {**first, "taken_at": "2025-12-01T14:00:01.25+02:00"}
        assert shop.post("/readings", again) == {"accepted": 0, "duplicates": 1}

    @pytest.mark.parametrize(
        "change",
        [{"amplitude": 2.0}, {"phase_deg": None}, {"sensor": "Q"}, {"taken_at": NOON}, {"scatter": 0.1}],
        ids=lambda change: next(iter(change)),
    )
    def test_a_number_used_again_for_other_contents_is_refused(self, shop: Workshop, change: dict[str, Any]) -> None:
        shop.post("/readings", arrival(1))
        batch = [arrival(2), {**arrival(1), **change}]
        problem = shop.refused("POST", "/readings", batch, 409, "sequence_reused")
        assert problem["value"] == 1
        shop.refused("POST", "/readings", [arrival(3), {**arrival(3), **change}], 409, "sequence_reused")

    def test_sources_count_each_for_themselves(self, shop: Workshop, machine: str) -> None:
        shop.ask("PUT", "/sources/other", {"machine_id": machine})
        other = {**arrival(1, 5.0 + 0j), "source": "other"}
        assert shop.post("/readings", [arrival(1), other]) == {"accepted": 2, "duplicates": 0}

    def test_a_long_batch_goes_in_whole(self, shop: Workshop) -> None:
        batch = [arrival(n) for n in range(3000)]
        assert shop.post("/readings", batch) == {"accepted": 3000, "duplicates": 0}
        assert shop.post("/readings", batch) == {"accepted": 0, "duplicates": 3000}

    def test_a_reading_sent_again_after_its_source_was_moved_is_a_duplicate(self, shop: Workshop) -> None:
        shop.post("/readings", arrival(1))
        shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
        assert shop.post("/readings", [arrival(1), arrival(2)]) == {"accepted": 1, "duplicates": 1}

    def test_bound_sources_are_listed(self, shop: Workshop, machine: str) -> None:
        other = shop.machine()
        shop.ask("PUT", "/sources/bridge", {"machine_id": other})
        shop.ask("PUT", "/sources/a", {"machine_id": machine})
        assert [(s["name"], s["machine_id"]) for s in shop.get("/sources")] == [("a", machine), ("bridge", other)]


class TestTake:
    def test_vectors_are_averaged_with_the_scatter_of_their_mean(self, shop: Workshop, machine: str) -> None:
        rng = np.random.default_rng(3)
        around = cmath.rect(2.0, math.radians(359.0))  # amplitudes and degrees averaged by themselves would be wrong
        vectors = around + 0.4 * (rng.standard_normal(12) + 1j * rng.standard_normal(12))
        batch = [arrival(n, complex(v), speed_rpm=460.0 + n, overall_rms=3.0 + n) for n, v in enumerate(vectors)]
        batch += [arrival(20, 4.0 + 0j, "Q", scatter=0.3)]
        shop.post("/readings", batch)
        p, q = take(shop, shop.session(machine))
        assert vector_of(p) == pytest.approx(vectors.mean(), rel=1e-12)
        parts = np.array([vectors.real, vectors.imag])
        assert p["scatter"] == pytest.approx(math.sqrt(parts.var(axis=1, ddof=1).mean() / 12), rel=1e-12)
        assert (p["speed_rpm"], p["overall_rms"]) == pytest.approx((465.5, 8.5))
        assert (q["sensor"], q["amplitude"], q["scatter"]) == ("Q", 4.0, 0.3)

    def test_lead_is_averaged_as_lead(self, shop: Workshop) -> None:
        machine = shop.machine(phase_sense="lead")
        shop.ask("PUT", "/sources/bridge", {"machine_id": machine})
        shop.post("/readings", [arrival(1, 1.0 + 0.0j), arrival(2, 0.0 + 1.0j)])
        (found,) = take(shop, shop.session(machine))
        assert vector_of(found) == pytest.approx(0.5 + 0.5j)

    def test_only_between_its_times(self, shop: Workshop, machine: str) -> None:
        shop.post("/readings", [arrival(n, n + 1.0 + 0j) for n in range(10)])
        (found,) = take(shop, shop.session(machine), 4.0, **{"from": at(2.0)})
        assert found["amplitude"] == pytest.approx(4.0)  # readings 2, 3 and 4, both ends included

    def test_not_those_meant_for_another_session(self, shop: Workshop, machine: str) -> None:
        mine, other = shop.session(machine), shop.session(machine)
        shop.post("/readings", [arrival(1, 1.0 + 0j, session_id=mine), arrival(2, 9.0 + 0j, session_id=other)])
        shop.post("/readings", [arrival(3, 3.0 + 0j)])
        (found,) = take(shop, mine)
        assert found["amplitude"] == pytest.approx(2.0)

    def test_same_readings_have_no_scatter_to_speak_of(self, shop: Workshop, machine: str) -> None:
        shop.post("/readings", [arrival(n, 2.0 + 0j) for n in range(4)])
        (found,) = take(shop, shop.session(machine))
        assert found["scatter"] is None

    def test_without_a_phase_amplitudes_are_averaged(self, shop: Workshop, machine: str) -> None:
        shop.post("/readings", [{**arrival(n, n + 1.0 + 0j), "phase_deg": None} for n in range(3)])
        (found,) = take(shop, shop.session(machine))
        assert (found["amplitude"], found["phase_deg"]) == (2.0, None)
        assert found["scatter"] == pytest.approx(1.0 / math.sqrt(3))

    def test_readings_from_before_a_source_was_moved_stay_with_their_machine(
        self, shop: Workshop, machine: str
    ) -> None:
        shop.post("/readings", arrival(1, 1.0 + 0j))
        other = shop.machine()
        shop.ask("PUT", "/sources/bridge", {"machine_id": other})
        shop.post("/readings", arrival(2, 5.0 + 0j))
        (found,) = take(shop, shop.session(other))
        assert found["amplitude"] == 5.0
        body = {"kind": "initial", "take": {"source": "bridge", "from": NOON, "to": at(60)}}
        shop.refused("POST", f"/sessions/{shop.session(machine)}/runs", body, 409, "source_of_other_machine")


class TestAnswers:
    def test_an_answer_is_stored_once(self, shop: Workshop, machine: str) -> None:
        session = shop.session(machine)
        first = shop.post("/balancer-answers", answer(1))
        assert (first["session_id"], first["accepted"]) == (session, True)
        again = shop.post("/balancer-answers", answer(1))
        assert again == {**first, "accepted": False}
        other = answer(1, masses=[mass("1", 1.0, 0.0)])
        shop.refused("POST", "/balancer-answers", other, 409, "sequence_reused")
        assert shop.count("balancer_answer") == 1

    def test_an_answer_sent_again_for_another_session_is_refused(self, shop: Workshop, machine: str) -> None:
        mine, other = shop.session(machine), shop.session(machine)
        shop.post("/balancer-answers", answer(1, session_id=mine))
        shop.refused("POST", "/balancer-answers", answer(1, session_id=other), 409, "sequence_reused")

    def test_an_answer_becomes_a_correction(self, shop: Workshop, machine: str) -> None:
        session = shop.session(machine)
        stored = shop.post("/balancer-answers", answer(1))
        correction = shop.correct(session, source="balancer", answer_id=stored["id"])
        first, second = correction["corrections"]
        assert (first["mass_g"], first["angle_deg"]) == pytest.approx((170.2, 70.0))
        assert first["unbalance_gmm"] == pytest.approx(170.2 * 330.0)
        assert second["mass_g"] == 0.0

    def test_a_session_lists_the_answers_meant_for_it_or_for_none(self, shop: Workshop, machine: str) -> None:
        for_none = shop.post("/balancer-answers", answer(1))
        session, other = shop.session(machine), shop.session(machine)
        mine = shop.post("/balancer-answers", answer(2, session_id=session, taken_at=at(5)))
        shop.post("/balancer-answers", answer(3, session_id=other, taken_at=at(6)))
        listed = shop.get(f"/sessions/{session}/balancer-answers")
        assert [one["id"] for one in listed] == [mine["id"], for_none["id"]]
        assert [one["session_id"] for one in listed] == [session, None]
        assert listed[0]["masses"] == answer(2)["masses"]
        shop.refused("GET", "/sessions/nowhere/balancer-answers", None, 404, "not_found")

    def test_an_answer_for_no_session_waits_for_one(self, shop: Workshop, machine: str) -> None:
        stored = shop.post("/balancer-answers", answer(1))
        assert stored["session_id"] is None
        session = shop.session(machine)
        assert shop.correct(session, source="balancer", answer_id=stored["id"])["corrections"]
