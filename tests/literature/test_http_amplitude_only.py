"""The four-run method of the SPM A2010 manual, through the API.

Source: SPM A2010 manual, page 68, as collected by easymanua.ls. One plane, 12.3 g at three positions 120 degrees apart,
amplitudes only; printed answer 16.3 g at 91 degrees, counted as the trial positions are. Tolerance: 3 % and 2 degrees,
for the printed answer was read off a drawing.
"""

from __future__ import annotations

import pytest

from tests.support.http.workshop import Workshop, mass

TRIAL_G = 12.3
INITIAL = 6.1
TRIALS = ((0.0, 7.7), (120.0, 3.2), (240.0, 10.3))


def test_spm_a2010_four_runs(shop: Workshop) -> None:
    plane = {"name": "fan", "radius_mm": 100.0, "positions_deg": [0.0, 120.0, 240.0], "max_masses": 3}
    machine = {"planes": [plane], "sensors": [{"name": "A"}], "bearings": []}
    session = shop.session(shop.machine(**machine))
    runs = [("initial", [], INITIAL), *(("trial", [mass("fan", TRIAL_G, angle)], read) for angle, read in TRIALS)]
    for kind, masses, amplitude in runs:
        readings = [{"sensor": "A", "amplitude": amplitude, "phase_deg": None}]
        shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})
    answer = shop.correct(session, source="amplitude_only")
    assert answer["alternatives"] == []
    assert answer["corrections"][0]["mass_g"] == pytest.approx(16.3, rel=0.03)
    assert answer["corrections"][0]["angle_deg"] == pytest.approx(91.0, abs=2.0)
