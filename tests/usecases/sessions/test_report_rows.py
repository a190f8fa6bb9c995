"""The report as CSV: every number in full, no text that a spreadsheet computes."""

from __future__ import annotations

import csv
import io

from service.usecases.sessions import reports, sessions
from service.usecases.sessions.report_rows import HEADS, report_csv
from tests.support.http.workshop import Workshop


def rows(shop: Workshop, key: str) -> list[dict[str, str]]:
    text = report_csv(sessions.get(shop.work, key), reports.report(shop.work, key))
    return list(csv.DictReader(io.StringIO(text)))


def test_every_reading_mass_and_piece_is_in_it(shared_shop: Workshop) -> None:
    key = shared_shop.session()
    fitted = shared_shop.fit(shared_shop.planned(key))
    found = rows(shared_shop, key)
    assert set(found[0]) == set(HEADS)
    amplitudes = {
        (r["number"], r["name"]): float(r["value"]) for r in found if r["quantity"] == "amplitude" and r["number"]
    }
    session = shared_shop.get(f"/sessions/{key}")
    assert amplitudes == {
        (str(run["number"]), reading["sensor"]): reading["amplitude"]
        for run in session["runs"]
        for reading in run["readings"]
    }
    pieces = [float(r["value"]) for r in found if r["record"] == "fitted" and r["quantity"] == "mass"]
    assert pieces == [p["mass_g"] for p in fitted["fitted"]]
    assert {r["unit"] for r in found if r["record"] == "influence"} >= {"mm/s rms per g", "deg"}


def test_no_name_is_a_formula_and_numbers_stay_numbers(shared_shop: Workshop) -> None:
    evil = '=HYPERLINK("http://x.example")'
    sensors = [{"name": "P", "serial": "@SUM(1)"}, {"name": "Q", "serial": " +1"}]
    key = shared_shop.session(shared_shop.machine(seen_from=evil, sensors=sensors), technician="-1+1")
    shared_shop.run(key, "initial")
    found = {(r["name"], r["quantity"]): r["value"] for r in rows(shared_shop, key)}
    assert f"'{evil}" in found.values()
    assert found["P", "serial"] == "'@SUM(1)"
    assert "'-1+1" in found.values()
    assert all(float(found[sensor, "phase"]) < 360.0 for sensor in "PQ")
    assert not any(value.startswith(("=", "+", "@", "\t", "\r")) for value in found.values())
