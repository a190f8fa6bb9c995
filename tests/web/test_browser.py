"""A technician's day in a real browser: a whole session, lost links, two tablets, gloves, German."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import httpx2
import pytest
from playwright.sync_api import Browser
from playwright.sync_api import TimeoutError as TooLong

from tests.support.pages.browser import LYING, UPRIGHT, Bench, Tablet

GRAMS, ANGLE = '[name="masses.mass_g"]', '[name="masses.angle_deg"]'
TAKE = "[data-take]:enabled"


def describe(tablet: Tablet, bench: Bench, name: str) -> str:
    """Type a new machine in, with what is known of the drum, and come to its first session's form."""
    tablet.press("A new machine")
    tablet.heading("Describe the machine")
    values = {"name": name, "service_speed_rpm": "460", "rotor_mass_kg": "120", "vibration_limit_mm_s": "0.5"}
    for index, plane in enumerate(bench.spec.planes):
        values |= {f"planes[{index}].{key}": text for key, text in {"name": plane.name, "radius_mm": "330"}.items()}
        values |= {f"planes[{index}].axial_mm": f"{plane.axial_mm:g}", f"planes[{index}].first_deg": "20"}
    for index, sensor in enumerate(bench.spec.sensors):
        values |= {f"sensors[{index}].name": sensor.name, f"sensors[{index}].axial_mm": f"{sensor.axial_mm:g}"}
    for field, text in values.items():
        tablet.fill(field, text)
    tablet.fill("seen_from", "the pulley")
    for sense, value in (("rotation", "cw"), ("angle_sense", "against_rotation")):
        tablet.page.locator(f'[name="{sense}"][value="{value}"]').check()
    tablet.press("Store the machine")
    tablet.heading("Which machine?")
    return str(next(m["id"] for m in bench.ask("GET", "/machines") if m["name"] == name))


TURNS = 20
A_TURN_MS = 3_000


def lock(tablet: Tablet) -> None:
    """Stop, take the key out, block the drum: nothing goes on before."""
    tablet.heading("Stop the machine and lock it")
    good_to_touch(tablet)
    tablet.press("Locked, go on")
    tablet.page.get_by_text("Do this first, then tick it.").first.wait_for()
    tablet.tick_all()
    tablet.press("Locked, go on")


def release(tablet: Tablet) -> None:
    """Bolts, tools, guards."""
    tablet.heading("Before the drum turns again")
    good_to_touch(tablet)
    tablet.tick_all()
    tablet.press("Ready to run")


def take(tablet: Tablet, bench: Bench, masses: list[dict[str, Any]]) -> None:
    """Let the drum run; take the run once the page says that it is steady."""
    tablet.page.locator("[data-take]").wait_for()
    for _ in range(TURNS):
        # A source goes on delivering: what came before the page listened is soon too old to be live.
        bench.turn(masses)
        with suppress(TooLong):
            tablet.page.locator(TAKE).wait_for(timeout=A_TURN_MS)
            break
    tablet.page.locator(TAKE).tap()


def trial(tablet: Tablet, bench: Bench, plane: str) -> None:
    """A trial run as the page advises it."""
    tablet.heading(f"Trial run in plane {plane}")
    tablet.press("Stop the machine to bolt it on")
    lock(tablet)
    tablet.heading("Bolt the trial mass into plane")
    good_to_touch(tablet)
    mass = {"mass_g": float(tablet.page.input_value(GRAMS)), "angle_deg": float(tablet.page.input_value(ANGLE))}
    tablet.press("The mass is bolted on")
    release(tablet)
    tablet.heading("Run with the trial mass")
    take(tablet, bench, [{"plane": plane, **mass}])


def good_to_touch(tablet: Tablet, *, axe: bool = True) -> None:
    """Large enough for gloves, as wide as the tablet however it is held, readable for everybody."""
    held = tablet.page.viewport_size
    assert held is not None
    for size in (LYING, UPRIGHT):
        tablet.page.set_viewport_size(size)
        assert tablet.small_targets() == []
        assert tablet.overflow() <= 0
    if axe:  # however it is held: names, order and contrast are the same
        assert tablet.serious() == []
    tablet.page.set_viewport_size(held)


def test_a_whole_session_from_a_new_machine_to_the_certificate(tablet: Tablet, bench: Bench) -> None:
    bench.box("Workshop box")
    tablet.open("/")
    tablet.press("Start balancing")
    machine = describe(tablet, bench, "Combine 12")
    bench.mount(machine)
    good_to_touch(tablet, axe=False)
    tablet.press("Begin")
    tablet.heading("Run the drum as found")
    session = tablet.page.url.rsplit("/", 1)[1]
    good_to_touch(tablet)
    take(tablet, bench, [])

    trial(tablet, bench, "1")
    tablet.heading("Trial run in plane 2")
    # The server is restarted, the page loaded again: the session stands where it stood.
    bench.service.stop()
    bench.service.start()
    tablet.page.reload(wait_until="domcontentloaded")
    tablet.link_was_cut()
    trial(tablet, bench, "2")

    tablet.heading("The runs are enough")
    good_to_touch(tablet)
    tablet.press("Compute")
    tablet.heading("What the drum needs")
    good_to_touch(tablet)
    tablet.press("Choose the pieces")
    tablet.press("Find the best")
    tablet.heading("The best choice from the box")
    assert tablet.page.get_by_text("Nothing in the box does better").count() == 1
    assert tablet.page.locator(".moves .off").count() == 1, "the last trial mass comes off"
    good_to_touch(tablet)
    tablet.press("Fit this")
    lock(tablet)
    tablet.heading("Change the masses")
    good_to_touch(tablet)
    assert tablet.page.locator(".moves .pull").first.inner_text().split("\N{NARROW NO-BREAK SPACE}")[1].startswith("N")
    tablet.press("All is bolted on as shown")
    release(tablet)
    tablet.heading("Run the drum to check it")
    take(tablet, bench, bench.masses_now(session))
    tablet.page.locator(".before-after").wait_for()
    good_to_touch(tablet)
    tablet.press("Close the session")
    tablet.page.get_by_text("it cannot be reopened").wait_for()
    assert bench.ask("GET", f"/sessions/{session}")["state"] == "checked", "one touch closes nothing"
    good_to_touch(tablet)
    tablet.press("Close it for good")
    tablet.heading("Finished")
    good_to_touch(tablet)
    pdf = httpx2.get(f"{bench.service.address}/api/v1/sessions/{session}/report.pdf", timeout=60)
    assert pdf.content.startswith(b"%PDF")
    state = bench.ask("GET", f"/sessions/{session}")
    assert state["state"] == "closed"
    assert [run["kind"] for run in state["runs"]] == ["initial", "trial", "trial", "check"]


def typed(tablet: Tablet, values: Mapping[str, str]) -> None:
    """Type a run in."""
    if tablet.page.locator("details.typed[open]").count() == 0:
        tablet.press("Type the run in")
    for name, text in values.items():
        tablet.fill(name, text)


RUN = {
    "readings[0].amplitude": "3.11",
    "readings[0].phase_deg": "40",
    "readings[1].amplitude": "4.79",
    "readings[1].phase_deg": "120",
}


def test_a_run_typed_without_a_link_waits_on_the_tablet_and_is_stored_once(tablet: Tablet, bench: Bench) -> None:
    session = bench.session(bench.machine("Lost link"), bench.box("Box of the lost link"))
    tablet.open(f"/sessions/{session}")
    typed(tablet, RUN)
    bench.service.stop()
    tablet.press("Store this run")
    tablet.page.locator(".waiting").get_by_text("Not sent yet").wait_for()
    assert "3.11" in tablet.page.locator(".waiting").inner_text()
    bench.service.start()
    tablet.heading("Trial run in plane 1")
    assert len(bench.ask("GET", f"/sessions/{session}")["runs"]) == 1
    tablet.link_was_cut()


def test_what_is_typed_is_still_there_after_a_reload(tablet: Tablet, bench: Bench) -> None:
    session = bench.session(bench.machine("Reload"), bench.box("Box of the reload"))
    tablet.open(f"/sessions/{session}")
    typed(tablet, {"readings[0].amplitude": "3.11"})
    tablet.page.reload(wait_until="domcontentloaded")
    assert tablet.page.input_value('[name="readings[0].amplitude"]') == "3.11"


def test_two_tablets_on_one_session(tablet: Tablet, browser: Browser, bench: Bench) -> None:
    session = bench.session(bench.machine("Two tablets"), bench.box("Box of two tablets"))
    other = Tablet(browser, bench.service.address, viewport=LYING)
    watching = Tablet(browser, bench.service.address, viewport=LYING)
    for one in (tablet, other, watching):
        one.open(f"/sessions/{session}")
        one.heading("Run the drum as found")
    good_to_touch(other, axe=False)
    typed(other, {**RUN, "readings[0].amplitude": "9.99"})
    typed(tablet, RUN)
    tablet.press("Store this run")
    tablet.heading("Trial run in plane 1")
    # Who only looks is taken along; who has typed something is told, keeps it, and cannot overwrite what is newer.
    watching.heading("Trial run in plane 1")
    other.page.get_by_text("has gone on, on another tablet").wait_for()
    other.press("Store this run")
    other.page.get_by_text("What you sent was not stored").wait_for()
    other.heading("Trial run in plane 1")
    assert other.page.locator("[data-kept] input").first.input_value() == "9.99"
    good_to_touch(other)
    runs = bench.ask("GET", f"/sessions/{session}")["runs"]
    assert [run["readings"][0]["amplitude"] for run in runs] == [3.11]
    for one in (other, watching):
        one.close()
        assert one.errors == []
        assert one.elsewhere == []


def test_bad_input_is_told_beside_the_field_and_kept(tablet: Tablet, bench: Bench) -> None:
    session = bench.session(bench.machine("Typing"), bench.box("Box of typing"))
    tablet.context.add_cookies([{"name": "drumtrue_preferences", "value": "language=de", "url": tablet.address}])
    tablet.open(f"/sessions/{session}")
    if tablet.page.locator("details.typed[open]").count() == 0:
        tablet.press("Lauf eintippen")
    bad = {"readings[0].amplitude": "🙂", "readings[0].phase_deg": "400", "speed_rpm": "1.250"}
    for name, text in bad.items():
        tablet.fill(name, text)
    tablet.press("Lauf speichern")
    tablet.page.locator(".field.wrong").first.wait_for()
    assert tablet.page.locator(".field.wrong").count() == 3
    for name, text in bad.items():
        assert tablet.page.input_value(f'[name="{name}"]') == text
    for name, text in {"readings[0].amplitude": "3,11", "readings[0].phase_deg": "40", "speed_rpm": "455,5"}.items():
        tablet.fill(name, text)
    tablet.press("Lauf speichern")
    tablet.heading("Testlauf in Ebene 1")
    assert bench.ask("GET", f"/sessions/{session}")["runs"][0]["readings"][0]["amplitude"] == 3.11


def test_live_values_are_shown_as_old_and_too_fast_is_loud(tablet: Tablet, bench: Bench) -> None:
    machine = bench.machine("Too fast", service_speed_rpm=300.0)
    session = bench.session(machine, bench.box("Box of the fast one"))
    tablet.open(f"/sessions/{session}")
    tablet.page.get_by_text("No value yet: the source is silent").wait_for()
    assert tablet.page.locator(".pic-needle:visible").count() == 0
    values = tablet.page.locator(".dial .pic-strong")
    assert values.all_text_contents() == ["\N{EM DASH}"] * 4
    bench.turn()
    tablet.page.get_by_text("Too fast! Above the service speed").wait_for()
    assert "\N{EM DASH}" not in values.all_text_contents()
    # As found it shakes more than any scale drawn before could know: the dials have grown.
    for needle in tablet.page.locator("[data-amplitude] .pic-needle").all():
        turned = needle.get_attribute("transform") or ""
        assert -120.0 < float(turned.removeprefix("rotate(").split()[0]) < 120.0
    tablet.page.get_by_text("Old value: the source is silent").wait_for()
    assert tablet.page.locator(TAKE).count() == 0


@pytest.mark.parametrize("status", [401, 502, 503])
def test_live_values_come_back_by_themselves_after_an_answer_that_ends_the_stream(
    tablet: Tablet, bench: Bench, status: int
) -> None:
    """A browser gives a stream up for good after such an answer: a proxy gives it while the service starts again."""
    asked: list[str] = []

    def away(route: Any) -> None:
        asked.append(route.request.url)
        if len(asked) <= 3:
            route.fulfill(status=status, body="not now")
        else:
            route.continue_()

    tablet.page.route("**/stream", away)
    session = bench.session(bench.machine(f"Away {status}"), bench.box(f"Box of {status}"))
    tablet.open(f"/sessions/{session}")
    tablet.page.get_by_text("No value yet: the source is silent").wait_for(timeout=15_000)
    assert len(asked) == 4
    tablet.page.unroute("**/stream")
    told = [error for error in tablet.errors if "Failed to load resource" in error]
    assert len(told) == 3
    tablet.errors[:] = [error for error in tablet.errors if error not in told]


def test_every_page_is_large_and_readable_lying_and_dark(browser: Browser, bench: Bench) -> None:
    tablet = Tablet(browser, bench.service.address, viewport=LYING)
    tablet.context.add_cookies([{"name": "drumtrue_preferences", "value": "theme=dark", "url": tablet.address}])
    machine = bench.machine("Dark page")
    box = bench.box("Dark box")
    paths = ("/", "/sessions", "/sessions/new", "/machines", f"/machines/{machine}", "/machines/new", "/boxes")
    for path in (*paths, f"/boxes/{box}", "/boxes/new", "/sources", "/preferences", "/login"):
        tablet.open(path)
        good_to_touch(tablet)
    tablet.close()
    assert (tablet.errors, tablet.elsewhere) == ([], [])


def test_a_flipped_sense_is_shown_beside_its_mirror_image(tablet: Tablet, bench: Bench) -> None:
    told = "with_rotation" if bench.spec.angle_sense == "against_rotation" else "against_rotation"
    session = bench.session(bench.machine("Flipped", angle_sense=told), bench.box("Box of the flipped"))
    runs: list[tuple[str, list[dict[str, Any]]]] = [("initial", [])]
    for plane, angles in (("1", (0.0, 100.0)), ("2", (0.0, 80.0))):
        runs += [("trial", [{"plane": plane, "mass_g": 200.0, "angle_deg": angle}]) for angle in angles]
    for kind, masses in runs:
        taken = sorted(reading.taken_at for reading in bench.turn(masses))
        take = {"source": "drum", "from": taken[0].isoformat(), "to": taken[-1].isoformat()}
        bench.ask("POST", f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "take": take})
    found = bench.ask("POST", f"/sessions/{session}/corrections", {"source": "fit"})
    assert "sense_mirrored" in [one["code"] for one in found["diagnostics"]]
    tablet.open(f"/sessions/{session}/step/correction")
    tablet.heading("What the drum needs")
    card = tablet.page.locator("section.card", has_text="Is it like this, or the mirror image?")
    assert card.locator("svg").count() == 2
    assert card.locator("figcaption").all_inner_texts() == [
        "as the machine is described",
        "the mirror image: it fits the runs far better",
    ]
    good_to_touch(tablet)
