"""A sensor that is dead or gave nothing is named as the cause, on every machine; never planes that act alike."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.http.workshop import DRUM, Workshop, mass, reading

ON: tuple[list[dict[str, Any]], ...] = ([], [mass("1", 200.0, 0.0)], [mass("2", 200.0, 0.0)])


@pytest.mark.parametrize("run", [0, 1, 2])
@pytest.mark.parametrize("sensor", ["P", "Q"])
def test_a_missing_reading_is_named(shop: Workshop, sensor: str, run: int) -> None:
    session = shop.session()
    for k, on in enumerate(ON):
        readings = [reading(n, v) for n, v in DRUM.vibration(on).items() if (n, k) != (sensor, run)]
        kind = "trial" if on else "initial"
        shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": on, "readings": readings})
    problem = shop.refused("POST", f"/sessions/{session}/corrections", {"source": "fit"}, 422, "sensor_incomplete")
    assert problem["value"] == [run + 1]
    assert sensor in problem["detail"]


@pytest.mark.parametrize(("value", "code"), [(0.0, "sensor_silent"), (1.5, "sensor_stuck")])
def test_a_dead_sensor_is_named(shop: Workshop, value: float, code: str) -> None:
    session = shop.session()
    for on in ON:
        readings = [reading(n, v if n == "P" else complex(value)) for n, v in DRUM.vibration(on).items()]
        kind = "trial" if on else "initial"
        shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": on, "readings": readings})
    problem = shop.refused("POST", f"/sessions/{session}/corrections", {"source": "fit"}, 422, code)
    assert "Q" in problem["detail"]
