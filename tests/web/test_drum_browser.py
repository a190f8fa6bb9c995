"""The picture of the drum as a control: it follows what is typed, a touch chooses the hole and ticks the piece."""

from __future__ import annotations

from typing import Any

from tests.support.pages.browser import Bench, Tablet

ANGLE = '[name="masses.angle_deg"]'
FOUND = [("P", 3.15, 138.0), ("Q", 5.62, 148.0)]


def run(
    bench: Bench, session: str, kind: str, masses: list[dict[str, Any]], values: list[tuple[str, float, float]]
) -> None:
    names = [sensor.name for sensor in bench.spec.sensors]
    readings = [
        {"sensor": name, "amplitude": amplitude, "phase_deg": phase}
        for name, (_, amplitude, phase) in zip(names, values, strict=True)
    ]
    bench.ask("POST", f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})


def lock(tablet: Tablet) -> None:
    tablet.heading("Stop the machine and lock it")
    tablet.tick_all()
    tablet.press("Locked, go on")


def described(tablet: Tablet) -> str:
    return tablet.page.locator(".ends svg desc").first.text_content() or ""


def test_the_picture_follows_what_is_typed_and_a_touch_chooses_the_hole(tablet: Tablet, bench: Bench) -> None:
    session = bench.session(bench.machine("Touched"), bench.box("Box of the touched"))
    run(bench, session, "initial", [], FOUND)
    tablet.open(f"/sessions/{session}")
    tablet.press("Stop the machine to bolt it on")
    lock(tablet)
    tablet.heading("Bolt the trial mass into plane")
    tablet.page.locator(".ends [data-at] .pic-hole").nth(9).click()
    angle = tablet.page.locator(".ends [data-at]").nth(9).get_attribute("data-at")
    assert angle is not None
    assert float(tablet.page.input_value(ANGLE)) == float(angle)
    tablet.fill("masses.mass_g", "88")
    tablet.page.locator(".ends svg desc", has_text="88").wait_for(state="attached")
    assert described(tablet).endswith("10"), "the tenth hole"
    force = tablet.page.locator("[data-force]").inner_text()
    tablet.page.reload(wait_until="domcontentloaded")
    tablet.page.locator(".ends svg desc", has_text="88").wait_for(state="attached")
    assert tablet.page.locator("[data-force]").inner_text() == force, (
        "what is typed outlives a reload, in words and picture"
    )
    assert tablet.page.locator(".picture-list.old").count() == 0


def test_each_piece_is_ticked_by_a_touch_and_stays_ticked_after_a_reload(tablet: Tablet, bench: Bench) -> None:
    session = bench.session(bench.machine("Ticked"), bench.box("Box of the ticked"))
    run(bench, session, "initial", [], FOUND)
    run(
        bench,
        session,
        "trial",
        [{"plane": "1", "mass_g": 100.0, "angle_deg": 20.0}],
        [("P", 2.24, 96.0), ("Q", 4.91, 139.0)],
    )
    run(
        bench,
        session,
        "trial",
        [{"plane": "2", "mass_g": 100.0, "angle_deg": 20.0}],
        [("P", 2.62, 141.0), ("Q", 3.05, 118.0)],
    )
    found = bench.ask("POST", f"/sessions/{session}/corrections", {"source": "fit"})
    bench.ask("POST", f"/sessions/{session}/plans", {"correction_id": found["id"], "objective": "components"})
    tablet.open(f"/sessions/{session}")
    tablet.press("Fit this")
    lock(tablet)
    tablet.heading("Change the masses")
    ticks = tablet.page.locator(".moves .tick input")
    assert ticks.count() == tablet.page.locator(".moves li:not(.stay)").count() > 1
    plane, at = (ticks.first.get_attribute(f"data-{name}") for name in ("plane", "at"))
    place = tablet.page.locator(f'.ends [data-plane="{plane}"][data-at="{at}"]')
    place.scroll_into_view_if_needed()
    place.locator("circle").first.click(force=True)
    assert ticks.first.is_checked()
    tablet.page.reload(wait_until="domcontentloaded")
    tablet.page.locator(".moves .tick input:checked").first.wait_for()
    assert [tick.is_checked() for tick in ticks.all()] == [True] + [False] * (ticks.count() - 1)
    assert tablet.small_targets() == []
    assert tablet.serious() == []
