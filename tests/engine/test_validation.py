"""What types cannot tell: names that must exist, angles that must be positions, values that appear once."""

from __future__ import annotations

from dataclasses import replace

import pytest

from service.engine import validation
from service.errors import InvalidInput
from service.model.machine import Catalogue, CatalogueItem, Plane
from service.model.run import MassOnRotor
from service.model.session import AsFoundPiece
from tests.support.numerics.drum_log import session

MACHINE = session().machine
PLANE = MACHINE.planes[0]


def test_angles_that_differ_by_rounding_or_a_turn_are_one_position() -> None:
    assert validation.same_angle(20.0, 380.0)
    assert validation.same_angle(0.0, 360.0 - 1e-7)
    assert not validation.same_angle(20.0, 20.001)
    assert validation.position_index(PLANE, 340.0, "x") == 17
    assert validation.position_index(PLANE, -20.0, "x") == 17


def test_a_hole_is_named_as_on_the_drum_or_by_its_number() -> None:
    labelled = replace(PLANE, hole_labels=tuple(f"H{n}" for n in range(18)))
    assert (validation.hole_label(PLANE, 0), validation.hole_label(labelled, 0)) == ("1", "H0")
    found = validation.hole_at(labelled, 40.0)
    assert found is not None
    assert (found.index, found.label) == (2, "H2")
    assert validation.hole_at(PLANE, 41.0) is None
    assert (validation.label_at(PLANE, 40.0), validation.label_at(PLANE, 41.0)) == ("3", None)


def test_unknown_names_and_angles_are_refused_with_their_field() -> None:
    for call, field in (
        (lambda: validation.plane_index(MACHINE, "9", "a"), "a"),
        (lambda: validation.sensor_index(MACHINE, "X", "b"), "b"),
        (lambda: validation.position_index(PLANE, 41.0, "c"), "c"),
        (lambda: validation.item_of((CatalogueItem(mass_g=10.0, count=1),), 11.0, "d"), "d"),
        (lambda: validation.require_unique("e", ["x", "y", "x"]), "e"),
    ):
        with pytest.raises(InvalidInput) as refused:
            call()
        assert refused.value.field == field
    assert [validation.plane_index(MACHINE, name, "a") for name in ("1", "2")] == [0, 1]
    assert [validation.sensor_index(MACHINE, name, "b") for name in ("P", "Q")] == [0, 1]
    validation.require_unique("e", ["x", "y"])


def test_a_machine_is_stored_with_its_positions_in_one_turn() -> None:
    turned = replace(PLANE, positions_deg=(-20.0, 360.0, 20.0))
    assert validation.normalised(replace(MACHINE, planes=(turned,))).planes[0].positions_deg == (340.0, 0.0, 20.0)


@pytest.mark.parametrize(
    "plane",
    [
        replace(PLANE, positions_deg=(0.0, 360.0)),
        replace(PLANE, hole_labels=("only one",)),
        replace(PLANE, hole_labels=("twice",) * 18),
    ],
)
def test_positions_and_labels_must_be_told_apart(plane: Plane) -> None:
    with pytest.raises(InvalidInput):
        validation.normalised(replace(MACHINE, planes=(plane,)))


def test_names_are_used_once() -> None:
    with pytest.raises(InvalidInput):
        validation.normalised(replace(MACHINE, planes=(PLANE, PLANE)))
    with pytest.raises(InvalidInput):
        validation.normalised(replace(MACHINE, sensors=(MACHINE.sensors[0],) * 2))


def test_a_mass_appears_once_in_a_box() -> None:
    box = Catalogue(name="box", items=(CatalogueItem(mass_g=10.0, count=1), CatalogueItem(mass_g=20.0, count=None)))
    validation.check_catalogue(box)
    with pytest.raises(InvalidInput):
        validation.check_catalogue(replace(box, items=(*box.items, CatalogueItem(mass_g=10.0, count=5))))


def test_masses_and_as_found_pieces_sit_in_planes_of_the_machine() -> None:
    validation.check_masses(MACHINE, (MassOnRotor(plane="1", mass_g=10.0, angle_deg=41.0),))
    with pytest.raises(InvalidInput):
        validation.check_masses(MACHINE, (MassOnRotor(plane="9", mass_g=10.0, angle_deg=0.0),))
    validation.check_as_found(MACHINE, (AsFoundPiece(plane="1", position_deg=40.0, mass_g=10.0, may="move"),))
    with pytest.raises(InvalidInput):
        validation.check_as_found(MACHINE, (AsFoundPiece(plane="1", position_deg=41.0, mass_g=10.0, may="move"),))
