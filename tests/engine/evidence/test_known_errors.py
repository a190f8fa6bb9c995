"""What runs err by: stated of the machine, else learned from repeated runs, else usual; and which pieces were on."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from service.balancing.influence.run_errors import ANGLE_SD, MASS_SD, REPEATABILITY, Repeats
from service.engine.evidence.known_errors import errors_of, pieces_of
from service.model.machine import Uncertainty
from tests.support.numerics.drum_log import run, session

LOG = session()


def test_a_machine_of_which_nothing_is_known_errs_as_is_usual() -> None:
    found = errors_of(LOG.machine, ())
    assert (found.repeatability.source, found.repeatability.share) == ("default", REPEATABILITY)
    assert (found.errors.mass_sd, found.errors.angle_sd, found.errors.drift) == (MASS_SD, ANGLE_SD, 0.0)
    assert found.errors.dof == math.inf


def test_what_is_stated_counts_before_what_was_learned() -> None:
    stated = replace(LOG.machine, uncertainty=Uncertainty(repeatability=0.01, angle_sd_deg=2.0, drift_per_run=0.03))
    found = errors_of(stated, (), Repeats(0.08, 12))
    assert (found.repeatability.source, found.errors.repeatability) == ("stated", 0.01)
    assert found.errors.angle_sd == np.radians(2.0)
    assert found.errors.drift == 0.03
    assert found.errors.dof == math.inf


def test_runs_that_repeat_worse_are_believed_with_their_degrees_of_freedom() -> None:
    found = errors_of(LOG.machine, (), Repeats(0.08, 12))
    assert (found.repeatability.source, found.repeatability.degrees_of_freedom) == ("learned", 12)
    assert (found.errors.repeatability, found.errors.dof) == (0.08, 12)


def test_a_few_that_repeat_better_do_not_make_it_exact() -> None:
    """Two degrees of freedom of nothing against four of the usual 2 %."""
    found = errors_of(LOG.machine, (), Repeats(0.0, 2))
    assert found.errors.repeatability == REPEATABILITY * math.sqrt(4.0 / 6.0)
    assert found.errors.dof == math.inf


def test_a_piece_that_is_stated_again_is_the_same_piece() -> None:
    log = session(
        [run("initial"), run("trial", ("1", 200.0, 0.0)), run("check", ("1", 200.0, 360.0), ("2", 50.0, 90.0))]
    )
    pieces, keys = pieces_of(log.machine, log.runs)
    assert keys == (("1", 200.0, 0.0), ("2", 50.0, 90.0))
    assert pieces.plane.tolist() == [0, 1]
    assert pieces.on.tolist() == [[False, False], [True, False], [True, True]]
    np.testing.assert_allclose(pieces.mass, [200.0, 50j], atol=1e-12)
