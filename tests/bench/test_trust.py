"""The campaign's rotor is its own: checked against closed forms; and a short form of `drumtrue bench trust`."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from service.bench.trust import rotor, world
from service.bench.trust.cases import CASES
from service.bench.trust.coverage import ERROR_SETS, coverage
from service.bench.trust.rotor import Beam, Disc, Support, criticals, response
from service.bench.trust.table import allowed
from service.bench.trust.world import ErrorSet, World


def test_the_rotor_imports_nothing_of_the_product() -> None:
    tree = ast.parse(Path(rotor.__file__).read_text(encoding="utf-8"))
    named = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    named |= {name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names}
    assert named == {"__future__", "dataclasses", "numpy", "numpy.typing"}


def test_a_disc_on_a_slender_shaft_is_a_jeffcott_rotor() -> None:
    # Simply supported at both ends: k = 48 E I / L^3 (Timoshenko, Vibration Problems in Engineering, chapter 1).
    length, diameter, mass, damping = 1.0, 0.03, 40.0, 1e-3
    ends = (Support(0, 1e12, 1e12, damping), Support(8, 1e12, 1e12, damping))
    beam = Beam((length / 8,) * 8, (diameter,) * 8, (0.0,) * 8, (Disc(4, mass, 1e-6, 1e-6),), ends)
    stiffness = 48.0 * rotor.STEEL_E * np.pi * diameter**4 / 64.0 / length**3
    shaft = rotor.STEEL_RHO * np.pi * diameter**2 / 4.0 * length
    natural = np.sqrt(stiffness / (mass + 17.0 / 35.0 * shaft))  # the shaft's share by Rayleigh
    assert criticals(beam, 1)[0] == pytest.approx(natural * 60.0 / (2.0 * np.pi), rel=2e-3)
    omega = 0.5 * natural
    q = response(beam, omega * 60.0 / (2.0 * np.pi), (4,))[16, 0]
    expected = omega**2 / (stiffness - (mass + 17.0 / 35.0 * shaft) * omega**2)
    assert q.real == pytest.approx(expected, rel=5e-3)
    # It turns forward: y follows x by a quarter turn.
    y = response(beam, omega * 60.0 / (2.0 * np.pi), (4,))[17, 0]
    assert y == pytest.approx(-1j * q, rel=1e-6)


def test_a_heavy_rotor_on_soft_supports_moves_as_a_rigid_one() -> None:
    # Far above its rigid-body criticals the mass centre stands still: x = -U / m in the middle.
    case = CASES["a"]
    soft = Beam(case.beam.lengths, case.beam.outer, case.beam.inner, case.beam.discs, (Support(0, 10.0, 10.0, 0.0),))
    M = rotor.matrices(soft)[0]
    mass = float(M[0::4, 0::4].sum())
    assert response(soft, 3000.0, (4,))[16, 0].real == pytest.approx(-1.0 / mass, rel=0.02)


def test_without_errors_a_world_reads_what_is_true() -> None:
    w = World(CASES["e"], ErrorSet(within=0.0), np.random.default_rng(1))
    piece = w.piece(0, 50.0 + 0j)
    seen = w.run((piece,))
    assert np.abs(seen.vibration - w.true(np.array([50.0, 0.0]))).max() < 6.0 * seen.scatter.max()


@pytest.mark.parametrize("rotor_name", ["a", "c", "e"])
@pytest.mark.parametrize("errors", ["repeats to 2 %, default", "repeats to 1 %, stated", "placement 0.5 %, 0.5 deg"])
def test_what_is_stated_is_true_as_often_as_is_said(rotor_name: str, errors: str) -> None:
    found = coverage(CASES[rotor_name], errors, 40)
    low, _ = allowed(errors)
    for what, (share, count) in found.items():
        assert share > low - 4.0 * (0.05 * 0.95 / count) ** 0.5, what


def test_every_set_of_errors_is_a_worlds() -> None:
    assert all(world.UNSEEN > 0.0 and isinstance(errors, ErrorSet) for errors, _ in ERROR_SETS.values())
