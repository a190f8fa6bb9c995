"""Rules of a session log beyond the types of its fields."""

from __future__ import annotations

from dataclasses import replace

import pytest

from service.engine.logs.rules import KEY, checked, not_a_log
from service.errors import InvalidInput
from service.model.run import MassOnRotor
from service.model.session import AsFoundPiece
from tests.support.numerics.drum_log import session

LOG = session()


def test_a_sound_log_passes_with_its_machine_normalised() -> None:
    turned = replace(LOG.machine.planes[0], positions_deg=(-20.0, *LOG.machine.planes[0].positions_deg[:17]))
    log = replace(LOG, machine=replace(LOG.machine, planes=(turned, LOG.machine.planes[1])))
    assert checked(log).machine.planes[0].positions_deg[0] == 340.0
    assert checked(LOG) == LOG


def test_masses_and_pieces_belong_to_the_machine() -> None:
    stray = replace(LOG.runs[1], masses=(MassOnRotor(plane="9", mass_g=1.0, angle_deg=0.0),))
    piece = AsFoundPiece(plane="1", position_deg=41.0, mass_g=10.0, may="stay")
    assert LOG.catalogue is not None
    twice = replace(LOG.catalogue, items=(LOG.catalogue.items[0],) * 2)
    for wrong in (replace(LOG, runs=(stray,)), replace(LOG, on_rotor=(piece,)), replace(LOG, catalogue=twice)):
        with pytest.raises(InvalidInput):
            checked(wrong)


def test_identifiers_are_as_long_as_their_columns() -> None:
    assert KEY.fullmatch("a" * 32)
    assert not KEY.fullmatch("a" * 33)
    assert not KEY.fullmatch("a b")
    assert not KEY.fullmatch("")


def test_what_is_no_json_is_told_as_no_log() -> None:
    told = not_a_log(ValueError("x"))
    assert told.code == "invalid_log"
    assert told.advice
