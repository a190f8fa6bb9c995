"""Saved coefficients: arrays to documents and back, planes by name, rows by sensor and speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.influence.saved import SavedInfluence as Arrays
from service.engine import mapping
from service.engine.saved_influence import as_arrays, as_document, merged, shown
from tests.support.numerics.drum_log import INFLUENCE, session

LOG = session()
MACHINE = LOG.machine
ROWS = mapping.channels(MACHINE, LOG.runs)
TRUE = np.array([[INFLUENCE[s, p] for p in ("1", "2")] for s in ("P", "Q")])
ARRAYS = Arrays(TRUE, np.broadcast_to(1e-8 * np.eye(2), (2, 2, 2)).astype(complex), 3)


def test_there_and_back() -> None:
    back = as_arrays(MACHINE, as_document(MACHINE, ROWS, ARRAYS), ROWS)
    np.testing.assert_array_equal(back.influence, ARRAYS.influence)
    np.testing.assert_array_equal(back.covariance, ARRAYS.covariance)
    assert back.sessions == 3


def test_planes_are_found_by_name_in_whatever_order() -> None:
    turned = replace(MACHINE, planes=MACHINE.planes[::-1])
    back = as_arrays(turned, as_document(MACHINE, ROWS, ARRAYS), ROWS)
    np.testing.assert_array_equal(back.influence, TRUE[:, ::-1])
    other = replace(MACHINE, planes=(replace(MACHINE.planes[0], name="new"),))
    assert np.isnan(as_arrays(other, as_document(MACHINE, ROWS, ARRAYS), ROWS).influence).all()


def test_a_row_without_coefficients_is_left_out_and_comes_back_unknown() -> None:
    half = replace(ARRAYS, influence=np.where([[True], [False]], TRUE, complex(np.nan, np.nan)))
    saved = as_document(MACHINE, ROWS, half)
    assert [row.sensor for row in saved.rows] == ["P"]
    assert np.isnan(as_arrays(MACHINE, saved, ROWS).influence[1]).all()


def test_new_rows_replace_those_of_the_same_sensor_and_speed() -> None:
    old = as_document(MACHINE, ROWS, ARRAYS)
    slow = replace(old, rows=tuple(replace(row, speed_rpm=300.0) for row in old.rows))
    both = merged(slow, replace(old, sessions=4))
    assert [row.sensor for row in both.rows] == ["P", "Q", "P", "Q"]
    assert [row.speed_rpm for row in both.rows] == [460.0, 460.0, 300.0, 300.0]
    assert (both.sessions, merged(None, old)) == (4, old)
    assert len(merged(old, old).rows) == 2
    assert merged(replace(old, planes=("x", "y")), old) == old


def test_shown_as_amplitude_and_phase() -> None:
    first = shown(MACHINE, as_document(MACHINE, ROWS, ARRAYS))[0][0]
    assert (first.sensor, first.plane) == ("P", "1")
    assert (first.amplitude_per_g, first.phase_deg) == pytest.approx((0.014, 17.0))
    assert first.scatter_per_g == pytest.approx(1e-4)
