"""A linkage and a disc of other sources than the studies' own, brought as a user brings them: as files.

The four-bar: P. E. Nikravesh, Planar Multibody Dynamics, the program of its kinematic analysis states consistent angles
and rates at a crank angle of 90 degrees to four decimals. The disc: exercise 1.1 of a tutorial on rotating rings, discs
and cylinders for courses in strength of materials. No gear pair with published values of this Lewis model was found.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from service.design.documents import read_document
from service.design.linkage.case import read_case
from service.design.registry import check, study_of

FOUR_BAR = """
study = "linkage"
version = 1
title = "Four-bar of a textbook"
units = { length = "m", mass = "kg", inertia = "kg m2", speed = "rad/s", acceleration = "m/s2" }
[linkage]
speed = 6.283185307179586
samples = 360
crank = "1"
ground = { O = [0.0, 0.0], Q = [2.0, 0.5] }
[[linkage.link]]
name = "1"
points = { O = [0.0, 0.0], A = [1.0, 0.0] }
mass = 1.0
centre = [0.5, 0.0]
inertia = 0.1
[[linkage.link]]
name = "2"
points = { A = [0.0, 0.0], B = [3.0, 0.0] }
mass = 1.0
centre = [1.5, 0.0]
inertia = 0.8
[[linkage.link]]
name = "3"
points = { Q = [0.0, 0.0], B = [2.2, 0.0] }
mass = 1.0
centre = [1.1, 0.0]
inertia = 0.4
[[linkage.dyad]]
joint = "B"
links = ["2", "3"]
side = "left"
[aim]
weights = { force = 1.0 }
"""
DISC = """
study = "flywheel"
version = 1
[units]
length = "mm"
mass = "kg"
speed = "rad/s"
density = "kg/m3"
stress = "MPa"
energy = "J"
inertia = "kg m2"
[disc]
inner_radius = 180.0
outer_radius = 360.0
speed = 160.0
density = 7700.0
poisson = 0.33
[design]
thickness = [20.0, 20.0, 20.0, 20.0, 20.0, 20.0]
thickness_bounds = [10.0, 30.0]
[limits]
mass = 100.0
[aim]
goal = "most_energy"
"""


def test_a_four_bar_of_a_textbook_has_its_angles_and_rates() -> None:
    document = read_document(FOUR_BAR)
    assert [one for one in check(document) if one.severity == "refusal"] == []
    case, _ = read_case(document)
    assert case is not None
    at = 90
    angles = np.angle(case.moving.axis[1:, at])
    np.testing.assert_allclose(angles, [0.5782, 1.3357], atol=5e-5)
    np.testing.assert_allclose(case.moving.omega[1:, at], [0.7099, 3.4807], atol=5e-5)


def test_a_disc_of_a_tutorial_has_its_radial_stress_and_the_printed_hoop_stress_is_told_too_low() -> None:
    simulation = study_of(read_document(DISC)).simulate(read_document(DISC))
    stress = {one.name: one.y for one in simulation.curves}
    assert stress["stress_radial"].max() / 1e6 == pytest.approx(2.66, abs=0.005)
    hoop = stress["stress_hoop"].max() / 1e6
    assert hoop == pytest.approx(22.337, abs=0.001)
    assert math.isclose(hoop, 21.80, rel_tol=0.025), "printed 21.80 MPa, 2.4 % below the closed form"
