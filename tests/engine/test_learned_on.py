"""Coefficients taught on one geometry and used on another: the masses scale exactly, or the source is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.balancing.influence.saved import from_fit
from service.balancing.rotor.units import Scale, convert_amplitude
from service.bench.trust.cases import CASES
from service.bench.trust.coverage import as_run, flat, machine_of
from service.bench.trust.world import ErrorSet, World
from service.engine.correction_solver import solve_correction
from service.engine.influence_fits import fit_runs
from service.engine.learned_on import for_machine, learned_on
from service.engine.saved_influence import as_document
from service.errors import Conflict
from service.model.correction import CorrectionRequest
from service.model.influence import SavedInfluence
from service.model.machine import Machine
from service.model.run import Run


def _taught() -> tuple[Machine, Run, SavedInfluence]:
    case = CASES["a"]
    machine, world = machine_of(case, None), World(case, ErrorSet(), np.random.default_rng(5))
    machine = replace(
        machine,
        planes=tuple(replace(p, axial_mm=300.0 * (k or -1)) for k, p in enumerate(machine.planes)),
        sensors=tuple(replace(s, axial_mm=500.0 * (k or -1)) for k, s in enumerate(machine.sensors)),
    )
    runs = [as_run(machine, 1, "initial", (), world.run())]
    for plane in range(2):
        pieces = (world.piece(plane, complex(case.trial_g)),)
        runs.append(as_run(machine, len(runs) + 1, "trial", pieces, world.run(pieces)))
    fitted = fit_runs(machine, flat(runs), ())
    return machine, runs[0][0], as_document(machine, fitted.rows, from_fit(fitted.fit))


MACHINE, AS_FOUND, SAVED = _taught()


def _masses(machine: Machine, run: Run, saved: SavedInfluence) -> Any:
    request = CorrectionRequest(source="saved_influence")
    answer = solve_correction(machine, (run,), (), request, number=1, key="c", saved=saved)
    return np.array([c.mass_g * np.exp(1j * np.radians(c.angle_deg)) for c in answer.corrections])


@settings(max_examples=30, deadline=None)
@given(
    radii=st.lists(st.floats(50.0, 900.0), min_size=2, max_size=2),
    unit=st.sampled_from(["mm/s", "in/s"]),
    detection=st.sampled_from(["rms", "peak", "peak_to_peak"]),
    angle=st.sampled_from(["against_rotation", "with_rotation"]),
)
def test_masses_follow_radius_unit_and_detection_exactly(
    radii: list[float], unit: Any, detection: Any, angle: Any
) -> None:
    planes = tuple(replace(p, radius_mm=r) for p, r in zip(MACHINE.planes, radii, strict=True))
    sensors = tuple(replace(s, unit=unit, detection=detection) for s in MACHINE.sensors)
    changed = replace(MACHINE, planes=planes, sensors=sensors, angle_sense=angle)
    factor = convert_amplitude(1.0, Scale(), Scale("velocity", unit, detection))
    readings = tuple(
        replace(r, amplitude=r.amplitude * factor, scatter=None if r.scatter is None else r.scatter * factor)
        for r in AS_FOUND.readings
    )
    found = _masses(changed, replace(AS_FOUND, readings=readings), for_machine(SAVED, changed))
    expected = _masses(MACHINE, AS_FOUND, SAVED) * [p.radius_mm / r for p, r in zip(MACHINE.planes, radii, strict=True)]
    if angle == "with_rotation":
        expected = expected.conj()
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("what", ["plane", "sensor", "quantity", "rotation"])
def test_another_place_quantity_or_rotation_is_refused(what: str) -> None:
    plane, sensor = MACHINE.planes[0], MACHINE.sensors[0]
    changed = {
        "plane": replace(MACHINE, planes=(replace(plane, axial_mm=-100.0), *MACHINE.planes[1:])),
        "sensor": replace(MACHINE, sensors=(replace(sensor, axial_mm=-100.0), *MACHINE.sensors[1:])),
        "quantity": replace(
            MACHINE, sensors=(replace(sensor, quantity="displacement", unit="um"), *MACHINE.sensors[1:])
        ),
        "rotation": replace(MACHINE, rotation="cw"),
    }[what]
    with pytest.raises(Conflict) as refused:
        for_machine(SAVED, changed)
    assert refused.value.code == "influence_of_other_geometry"


def test_what_older_versions_stored_is_taken_to_be_of_the_session_that_taught_it() -> None:
    old = replace(SAVED, learned_on=None)
    twice = replace(MACHINE, planes=tuple(replace(p, radius_mm=2.0 * p.radius_mm) for p in MACHINE.planes))
    assert for_machine(old, twice, learned_on(MACHINE)) == for_machine(SAVED, twice)
