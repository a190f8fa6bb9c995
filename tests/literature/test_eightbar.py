"""Planar eight-bar mechanism (Online J. Mech. Eng. 1(1), 2023), computed as one mechanism.

The paper adds three independent four-bars; its joint forces cannot be reproduced by the real mechanism. The bounds of
the optimum are ours; the problem is convex and its bound is proved.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from service.design.documents import patched, preset
from service.design.linkage.case import read_case
from service.design.linkage.study import LinkageStudy
from service.design.optimising import optimise
from service.optimize.epsilon import EpsilonConstraint

EIGHTBAR = preset("eightbar")
PUBLISHED = patched(EIGHTBAR, EIGHTBAR["published"][0]["set"])
STUDY = LinkageStudy()
LENGTHS = {"2": 100.0, "3": 400.0, "4": 320.0, "5": 500.0, "6": 330.0, "8": 550.0, "9": 400.0}
WIDE = patched(
    EIGHTBAR,
    {
        "design": {
            "link": [
                {
                    "link": name,
                    "mass_factor": [0.5, 1.5],
                    "centre_radius": [0.0, length],
                    "inertia_centre_factor": 0.5,
                    "inertia_origin_factor": 1.5,
                }
                for name, length in LENGTHS.items()
            ]
        }
    },
)
ANGLES = (0, 30, 90, 180, 270)
JOINTS = ("A", "B", "C", "D", "C", "E", "F", "E", "G", "H")


def test_positions_and_speeds() -> None:
    case, _ = read_case(EIGHTBAR)
    assert case is not None
    c = [0.4076 + 0.25569951j, 0.37809313 + 0.23055875j, 0.29114286 + 0.08370941j, 0.31531228 + 0.14612632j]
    e = [0.90744868 + 0.26799998j, 0.87791021 + 0.24408221j, 0.79023746 + 0.11378562j, 0.81490908 + 0.16620218j]
    g = [1.45531229 + 0.31642997j, 1.42587931 + 0.2913037j, 1.33745823 + 0.16900728j, 1.36273446 + 0.21506268j]
    for name, expected in (("C", c), ("E", e), ("G", g)):
        np.testing.assert_allclose(case.moving.points[name][::90], expected, atol=6e-9)
    at_90 = [-6.002356, 10.227035, 0.242076, 9.673816, -0.124022, 8.085547]
    np.testing.assert_allclose(case.moving.omega[1:, 90], at_90, atol=6e-7)


@pytest.mark.parametrize(
    ("document", "force", "moment", "torque"),
    [
        (
            EIGHTBAR,
            [
                265.59062 + 179.05508j,
                359.42282 + 232.36349j,
                70.85979 + 269.36290j,
                -236.15822 - 426.57555j,
                -96.126 - 137.02299j,
            ],
            [97.40990, 91.70859, 130.95416, -249.33017, -39.69354],
            [-14.38686, -1.49882, 15.75859, -17.53159, 8.02166],
        ),
        (
            PUBLISHED,
            [
                258.22163 + 76.83825j,
                289.48956 + 80.50833j,
                43.68435 + 133.69592j,
                -199.27009 - 124.04996j,
                -90.31006 - 91.30571j,
            ],
            [16.83866, -9.02544, 54.85572, -60.97257, -15.22477],
            [-9.48884, 2.34320, 5.81483, -6.02366, 6.56618],
        ),
    ],
    ids=["original", "published optimum"],
)
def test_time_values(
    document: dict[str, object], force: list[complex], moment: list[float], torque: list[float]
) -> None:
    curves = {one.name: one.y for one in STUDY.simulate(document).curves}
    at = list(ANGLES)
    np.testing.assert_allclose(curves["force_x"][at] + 1j * curves["force_y"][at], force, atol=1e-5)
    np.testing.assert_allclose(curves["moment"][at], moment, atol=1e-5)
    np.testing.assert_allclose(curves["torque"][at], torque, atol=1e-5)


@pytest.mark.parametrize(
    ("document", "rms", "joints", "swings"),
    [
        (
            EIGHTBAR,
            (295.54955, 113.10654, 11.4023),
            (745.29, 728.04, 611.29, 221.13, 382.91, 358.23, 249.84, 115.05, 86.15, 82.96),
            (42.2993, 38.1641, 30.5804),
        ),
        (
            PUBLISHED,
            (194.79858, 40.58272, 6.3785),
            (291.30, 273.57, 203.96, 64.81, 139.77, 100.16, 18.05, 74.18, 41.45, 34.23),
            (39.1864, 30.4376, 29.2593),
        ),
    ],
    ids=["original", "published optimum"],
)
def test_responses(
    document: dict[str, object], rms: tuple[float, ...], joints: tuple[float, ...], swings: tuple[float, ...]
) -> None:
    simulation = STUDY.simulate(document)
    values = [simulation.value(name) for name in ("force_rms", "moment_rms", "torque_rms")]
    np.testing.assert_allclose(values, rms, rtol=1e-5)
    peaks = [one for one in simulation.scalars if one.name.startswith("joint_force_peak.")]
    assert [one.name.split(".")[1].split(" ")[0] for one in peaks] == list(JOINTS)
    np.testing.assert_allclose([one.value for one in peaks], joints, rtol=2e-4)
    for link, swing in zip(("4", "6", "9"), swings, strict=True):
        assert math.degrees(simulation.value(f"swing.{link}")) == pytest.approx(swing, rel=1e-4)


@pytest.mark.parametrize(
    ("document", "least", "force", "moment"),
    [(EIGHTBAR, 0.0103413357, 0.124394, 0.072172), (WIDE, 0.00103009835, 0.027515, 0.036099)],
    ids=["E2 tight", "E1 wide"],
)
def test_least_aim_is_proved(document: dict[str, object], least: float, force: float, moment: float) -> None:
    found = optimise(document, steps=1)
    assert found.value == pytest.approx(least, rel=1e-6)
    assert found.after.feasible
    assert found.result.status == "optimal"
    assert found.evidence.bound is not None
    assert found.value - found.evidence.bound <= 1e-6 * found.value
    assert found.after.value("force_ratio") == pytest.approx(force, rel=2e-4)
    assert found.after.value("moment_ratio") == pytest.approx(moment, rel=2e-4)


@pytest.mark.parametrize(
    ("document", "weights", "response", "least"),
    [
        (EIGHTBAR, {"force": 1.0, "moment": 0.0}, "force_ratio", 0.0650153),
        (EIGHTBAR, {"force": 0.0, "moment": 1.0}, "moment_ratio", 0.00184),
        (WIDE, {"force": 1.0, "moment": 0.0}, "force_ratio", 0.0),
        (WIDE, {"force": 0.0, "moment": 1.0}, "moment_ratio", 0.00105),
    ],
    ids=["tight force", "tight moment", "wide force", "wide moment"],
)
def test_each_alone(document: dict[str, object], weights: dict[str, float], response: str, least: float) -> None:
    found = optimise(patched(document, {"aim": {"weights": weights}}), steps=1)
    assert found.after.value(response) == pytest.approx(least, abs=5e-6 if least else 1e-5)
    assert found.after.feasible


@pytest.mark.parametrize(("moment", "force"), [(0.1, 0.110659), (0.2, 0.082562), (0.5, 0.065601)])
def test_points_of_the_front(moment: float, force: float) -> None:
    problem = STUDY.problem(EIGHTBAR).front
    assert problem is not None
    search = EpsilonConstraint(problem, 2, np.random.default_rng(1), starts=0, end_starts=1, ceiling=moment)
    points = [next(search) for _ in range(3)]
    assert points[2].objectives[1] <= moment * (1.0 + 1e-9)
    assert points[2].objectives[0] == pytest.approx(force, rel=1e-4)
