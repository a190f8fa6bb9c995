"""Rigid rotor and published best designs through the objective `bearing_force`, over HTTP.

Source: thesis on the dynamic performance of the thresher machine, chapter 5 (two-plane discrete balancing); its data
with the printed slips corrected, forces recomputed: reactions within 0.05 N, designs to the digits shown.
The service is told no eccentricity: a balancer's answer stands for it, the masses in the two planes that would cancel
the rotor's own unbalance, found here from the two balances of force and moment alone.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from tests.literature.test_selection_rotor import DESIGNS as THESIS_DESIGNS
from tests.support.http.workshop import Workshop

NEWTON = 0.05


@dataclass(frozen=True)
class RigidRotor:
    """M in kg, speed in r/min, e in mm, I in kg m2; bearings, planes and radius in mm; positions every `step` deg."""

    mass_kg: float
    speed_rpm: float
    eccentricity: complex
    product: complex
    bearings: tuple[float, float]
    planes: tuple[float, float]
    radius: float
    step: int
    forces: tuple[float, float]

    def answer(self) -> list[dict[str, Any]]:
        """Masses that cancel it: sum u = -M e and sum u l = I."""
        levers = np.array([[1.0, 1.0], self.planes])
        own = np.array([1000.0 * self.mass_kg * self.eccentricity, -1e9 * self.product])  # g mm, g mm2
        needed = np.linalg.solve(levers, -own) / self.radius
        return [
            {"plane": name, "mass_g": abs(u), "angle_deg": math.degrees(cmath.phase(u))}
            for name, u in zip("12", map(complex, needed), strict=True)
        ]


STATIC = RigidRotor(60, 1500, 1.00 + 0.25j, 0j, (-200, 300), (-250, 350), 150, 30, (915.60, 610.40))
ROTORS = {
    "static": STATIC,
    "dynamic": RigidRotor(60, 1500, 1.00 + 0.25j, -0.004 - 0.01j, (-200, 300), (-250, 350), 150, 30, (742.27, 1017.34)),
    "drum": RigidRotor(120, 460, -0.154 + 1.20j, 0j, (-480, 440), (-330, 330), 330, 20, (161.12, 175.77)),
}
DESIGNS = [("drum", 1, "200@280", "200@280", 16.31, 17.79), *THESIS_DESIGNS]


def posed(shop: Workshop, rotor: RigidRotor, pieces: int) -> tuple[str, Any]:
    """A session and the correction that stands for the rotor's own unbalance."""
    ring = {
        "radius_mm": float(rotor.radius),
        "positions_deg": [float(degrees) for degrees in range(rotor.step, 361, rotor.step)],
        "max_masses": pieces,
        "masses_per_position": pieces,
    }
    machine = shop.machine(
        rotor_mass_kg=float(rotor.mass_kg),
        service_speed_rpm=float(rotor.speed_rpm),
        bearings=[{"name": n, "axial_mm": float(z)} for n, z in zip("PQ", rotor.bearings, strict=True)],
        planes=[{"name": n, "axial_mm": float(z), **ring} for n, z in zip("12", rotor.planes, strict=True)],
        sensors=[{"name": "P"}],
    )
    session = shop.session(machine, shop.box(count=None))
    return session, shop.correct(session, source="balancer", masses=rotor.answer())


def pieces_of(plane: str, design: str) -> list[dict[str, Any]]:
    """`200@180 50@240` as placements."""
    pairs = (piece.split("@") for piece in design.split())
    return [{"plane": plane, "mass_g": float(grams), "position_deg": float(degrees)} for grams, degrees in pairs]


@pytest.mark.parametrize(("case", "pieces", "first", "second", "force_p", "force_q"), DESIGNS)
def test_published_designs(
    shop: Workshop, case: str, pieces: int, first: str, second: str, force_p: float, force_q: float
) -> None:
    rotor = ROTORS[case]
    session, correction = posed(shop, rotor, pieces)
    plan = shop.plan(session, correction, objective="bearing_force")
    fitted = shop.fit(plan, actual=pieces_of("1", first) + pieces_of("2", second))
    forces = fitted["bearing_forces_n"]
    assert forces["bearings"] == ["P", "Q"]
    assert forces["before"] == pytest.approx(rotor.forces, abs=NEWTON)
    assert forces["after"] == pytest.approx((force_p, force_q), abs=NEWTON)


@pytest.mark.parametrize(("case", "pieces", "force_p", "force_q"), [(d[0], d[1], *d[4:]) for d in DESIGNS])
def test_the_plan_is_at_least_as_good_as_published(
    shop: Workshop, case: str, pieces: int, force_p: float, force_q: float
) -> None:
    """Eq 5.14: half of each reaction's share; several published designs are not the optimum."""
    rotor = ROTORS[case]
    session, correction = posed(shop, rotor, pieces)
    request = {"objective": "bearing_force", "method": "certified", "max_masses_per_plane": pieces}
    plan = shop.plan(session, correction, **request)
    p, q = rotor.forces
    assert plan["status"] == "optimal"
    assert plan["objective_value"] <= 0.5 * force_p / p + 0.5 * force_q / q + NEWTON / min(p, q)
    after, before = plan["bearing_forces_n"]["after"], plan["bearing_forces_n"]["before"]
    assert plan["objective_value"] == pytest.approx(sum(0.5 * a / b for a, b in zip(after, before, strict=True)))
