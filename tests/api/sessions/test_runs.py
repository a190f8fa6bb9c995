"""What a run counts for: run-out, missing readings, speeds, senses, scatter."""

from __future__ import annotations

import cmath
import math
from typing import Any

import pytest

from tests.support.http.workshop import DRUM, LinearDrum, Workshop, mass, on_rotor, reading, vector_of


class TestRuns:
    def test_run_out_is_subtracted(self, shop: Workshop) -> None:
        offset = cmath.rect(0.8, 1.1)
        run_out = [{"sensor": "P", "amplitude": 0.8, "phase_deg": math.degrees(1.1)}]
        plain, offset_session = shop.session(), shop.session(run_out=run_out)
        shop.learn(plain)
        false = LinearDrum({**DRUM.initial, "P": DRUM.initial["P"] + offset}, DRUM.influence)
        shop.learn(offset_session, false)
        for key in ("corrections", "initial"):
            size, angle = ("mass_g", "angle_deg") if key == "corrections" else ("amplitude", "phase_deg")
            found, expected = (
                [vector_of(e, size, angle) for e in shop.correct(s)[key]] for s in (offset_session, plain)
            )
            assert found == pytest.approx(expected, abs=1e-9)
        line = shop.get(f"/sessions/{offset_session}/report.json")["before_after"][0]
        assert line["before"] == pytest.approx(abs(DRUM.initial["P"]))

    def test_a_missing_reading_leaves_the_other_sensors_whole(self, shop: Workshop) -> None:
        session = shop.session(shop.machine(sensors=[{"name": name} for name in ("P", "Q", "R")]))
        shop.learn(session)
        shop.post(
            f"/sessions/{session}/runs",
            {"kind": "initial", "readings": [{"sensor": "R", "amplitude": 9.0, "phase_deg": 1.0}]},
        )
        correction = shop.correct(session)
        assert [row[0]["sensor"] for row in correction["influence"]] == ["P", "Q"]
        for row in correction["influence"]:
            for entry in row:
                vector = cmath.rect(entry["amplitude_per_g"], math.radians(entry["phase_deg"]))
                assert vector == pytest.approx(DRUM.influence[entry["sensor"], entry["plane"]], abs=1e-12)

    def test_a_reading_without_phase_counts_as_missing(self, shop: Workshop) -> None:
        session = shop.session()
        shop.learn(session)
        good = shop.correct(session)["corrections"]
        readings = [{"sensor": name, "amplitude": 50.0, "phase_deg": None} for name in ("P", "Q")]
        shop.post(f"/sessions/{session}/runs", {"kind": "initial", "readings": readings})
        assert shop.correct(session)["corrections"] == good

    def test_two_nominal_speeds(self, shop: Workshop) -> None:
        fast = LinearDrum(
            {sensor: 3.0 * cmath.rect(1.0, 0.4) * vector for sensor, vector in DRUM.initial.items()},
            {key: 3.0 * cmath.rect(1.0, 0.4) * value for key, value in DRUM.influence.items()},
        )
        session = shop.session()
        for speed, drum in ((460.0, DRUM), (700.0, fast)):
            for masses in ([], [mass("1", 200.0, 0.0)], [mass("2", 200.0, 0.0)]):
                shop.run(session, "trial" if masses else "initial", masses, drum, nominal_speed_rpm=speed)
        correction = shop.correct(session)
        assert [(row[0]["sensor"], row[0]["speed_rpm"]) for row in correction["influence"]] == [
            ("P", 460.0), ("Q", 460.0), ("P", 700.0), ("Q", 700.0),
        ]  # fmt: skip
        assert all(vector["amplitude"] < 1e-9 for vector in correction["predicted"])
        plan = shop.plan(session, correction)
        expected = [d.vibration(on_rotor(plan["placements"]))[s] for d in (DRUM, fast) for s in ("P", "Q")]
        assert [vector_of(p) for p in plan["predicted"]] == pytest.approx(expected, abs=1e-9)
        lines = shop.get(f"/sessions/{session}/report.json")["before_after"]
        assert [(line["sensor"], line["speed_rpm"]) for line in lines] == [
            ("P", 460.0), ("Q", 460.0), ("P", 700.0), ("Q", 700.0),
        ]  # fmt: skip

    @pytest.mark.parametrize("angle_sense", ["against_rotation", "with_rotation"])
    @pytest.mark.parametrize("phase_sense", ["lag", "lead"])
    def test_stated_senses_change_no_hole(self, shop: Workshop, angle_sense: str, phase_sense: str) -> None:
        def told(entry: dict[str, Any], key: str, mirrored: bool) -> dict[str, Any]:
            return {**entry, key: -entry[key]} if mirrored else entry

        turned, led = angle_sense == "with_rotation", phase_sense == "lead"
        session = shop.session(shop.machine(angle_sense=angle_sense, phase_sense=phase_sense))
        for masses in ([], [mass("1", 200.0, 40.0)], [mass("2", 200.0, 0.0)]):
            body = {
                "kind": "trial" if masses else "initial",
                "masses": [told(m, "angle_deg", turned) for m in masses],
                "readings": [told(r, "phase_deg", led) for r in DRUM.readings(masses)],
            }
            shop.post(f"/sessions/{session}/runs", body)
        found = [told(m, "angle_deg", turned) for m in shop.correct(session)["corrections"]]
        assert all(abs(vector) < 1e-9 for vector in DRUM.vibration(found).values())

    def test_scatter_makes_intervals_and_its_absence_none(self, shop: Workshop) -> None:
        bare, stated = shop.session(), shop.session()
        shop.learn(bare)
        for masses in ([], [mass("1", 200.0, 0.0)], [mass("2", 200.0, 0.0)]):
            readings = [reading(s, v, scatter=0.05) for s, v in DRUM.vibration(masses).items()]
            kind = "trial" if masses else "initial"
            shop.post(f"/sessions/{stated}/runs", {"kind": kind, "masses": masses, "readings": readings})
        for session, known in ((bare, False), (stated, True)):
            correction = shop.correct(session)
            plan = shop.plan(session, correction)
            entries = [*correction["corrections"], *correction["predicted"], *plan["predicted"]]
            assert all((entry["interval"] is not None) is known for entry in entries)
