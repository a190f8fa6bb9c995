"""The certificate, as a page and as PDF: what it says, in whose words, on how many pages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pypdfium2
import pytest

from service.model.report import Outcome, Report
from service.model.session import Session
from service.usecases.sessions import reports, sessions
from service.web.certificate.content import certificate
from service.web.certificate.document import Pictures, Sheet, Table
from service.web.certificate.pdf import to_pdf
from service.web.pictures.reader import Reader
from service.web.preferences import Preferences
from tests.support.http.workshop import DRUM, Workshop, mass, on_rotor

HTML = {"accept": "text/html"}
STRANGE = "Ø µm ° ² <script>alert(1)</script> & 中文 🙂 \N{RIGHT-TO-LEFT OVERRIDE}x"
LONG = "W" * 100


@pytest.fixture(scope="module")
def checked(shared_shop: Workshop) -> tuple[str, Session, Report]:
    """A session from as found to check run, 12 runs, pieces found on the drum, one run excluded."""
    shop = shared_shop
    sensors: list[dict[str, Any]] = [
        {"name": "P", "serial": "A-4711", "limit": 0.5, "direction": "vertical"},
        {"name": "Q", "serial": "A-4712", "limit": 0.5},
    ]
    places = [{**s, "axial_mm": x} for s, x in zip(sensors, (-480.0, 440.0), strict=True)]
    machine = shop.machine(balance_grade_mm_s=16.0, seen_from="gear side", sensors=places, type="TD 5")
    found = [
        {"plane": "1", "position_deg": 200.0, "mass_g": 50.0, "may": "remove"},
        {"plane": "2", "position_deg": 40.0, "mass_g": 20.0, "may": "stay"},
    ]
    key = shop.session(machine, technician="A. N. Other", note="seal worn", on_rotor=found)
    shop.learn(key)
    for number in range(8):
        run = shop.run(key, "trial", [mass("12"[number % 2], 100.0 + number, 40.0 * number)])
    shop.ask("PATCH", f"/sessions/{key}/runs/{run['id']}", {"excluded": True, "reason": "belt slipped"})
    fitted = shop.fit(shop.plan(key, shop.correct(key), max_masses_per_plane=2))
    off = [mass(p["plane"], -p["mass_g"], p["position_deg"]) for p in fitted["taken_off"]]
    shop.post(f"/sessions/{key}/runs", {"kind": "check", "readings": DRUM.readings(on_rotor(fitted["fitted"]) + off)})
    return key, sessions.get(shop.work, key), reports.report(shop.work, key)


def sheet_of(found: tuple[str, Session, Report], language: str = "en", **units: str) -> Sheet:
    return certificate(found[1], found[2], Reader(Preferences(language=language, **units)))


def pages_of(pdf: bytes) -> list[str]:
    """The text of every page of a PDF."""
    document = pypdfium2.PdfDocument(pdf)
    try:
        return [" ".join(page.get_textpage().get_text_range().split()) for page in document]
    finally:
        document.close()


def test_the_pdf_of_twelve_runs_says_everything_on_at_most_three_pages(checked: tuple[str, Session, Report]) -> None:
    assert len(checked[1].runs) == 12
    pages = pages_of(to_pdf(sheet_of(checked)))
    assert len(pages) <= 3
    said = " ".join(pages).replace("\u202f", " ")
    for part in (
        "Balancing certificate", "A. N. Other", "seal worn", "TD 5", "460 r/min", "G 16", "A-4711", "A-4712",
        "gear side", "Balanced: within what was asked for.", "3.11 mm/s rms", "4.79 mm/s rms", "0.5 mm/s rms",
        "against the rotation", "Phase (lag)", "belt slipped", "Proved: nothing in the box does better.", "Checked by",
        "mm/s rms / g", "Influence coefficients", f"Drumtrue {checked[2].version}", "page 1 of",
        "reached, its whole interval too",
    ):  # fmt: skip
        assert part in said, f"{part!r} is not in {said}"
    for piece in checked[2].fitted:
        assert f"{piece.plane} {piece.hole} {piece.position_deg:.0f}° {piece.mass_g:g} g bolted in" in said
    for run in checked[1].runs:
        assert f"{run.number} " in said


def test_a_speed_that_nobody_measured_is_not_stated(checked: tuple[str, Session, Report]) -> None:
    """The nominal speed stands once, under its own name; the column says what the tachometer read."""
    key, session, report = checked
    runs = tuple(
        replace(
            run,
            readings=tuple(replace(one, speed_rpm=455.0 if run.kind == "initial" else None) for one in run.readings),
        )
        for run in session.runs
    )
    lines = tuple(replace(line, before_rpm=455.0, after_rpm=None) for line in report.before_after)
    found = (key, replace(session, runs=runs), replace(report, before_after=lines))
    tables = [part for section in sheet_of(found).sections for part in section.parts if isinstance(part, Table)]
    columns = {
        table.rows[0][0]: [row[table.heads.index("Speed measured")] for row in table.rows]
        for table in tables
        if "Speed measured" in table.heads
    }
    assert len(columns) == 2
    said = {text.replace("\u202f", " ") for column in columns.values() for text in column}
    assert said == {"455 r/min / \N{EM DASH}", "455 r/min", "\N{EM DASH}"}


def test_who_signs_stands_below_the_result_with_the_name(checked: tuple[str, Session, Report]) -> None:
    pages = pages_of(to_pdf(sheet_of(checked)))
    signed = [page for page in pages if "Place and date" in page]
    assert len(signed) == 1
    assert "Balanced by: A. N. Other" in signed[0]
    assert "Before and after" in signed[0]


def test_the_pdf_is_the_same_every_time_and_looks_like_ink_on_paper(checked: tuple[str, Session, Report]) -> None:
    pdf = to_pdf(sheet_of(checked))
    assert to_pdf(sheet_of(checked)) == pdf
    later = replace(checked[2], written_at=checked[2].written_at.replace(year=2031))
    assert to_pdf(certificate(checked[1], later, Reader())) == pdf
    document = pypdfium2.PdfDocument(pdf)
    try:
        for page in document:
            picture = page.render(scale=0.5).to_pil().convert("RGB")
            colours = picture.getcolors(1_000_000)
            white = sum(count for count, colour in colours if min(colour) > 250) / (picture.width * picture.height)
            # Neither empty nor black; there is the blue of a mass and the green of a value within its limit.
            assert 0.6 < white < 0.995
        drawn = [page.render(scale=1.0).to_pil().convert("RGB") for page in document]
        seen = {colour for page in drawn for _count, colour in page.getcolors(1_000_000)}
        assert {(11, 87, 208), (0, 107, 60)} <= seen
    finally:
        document.close()


def test_the_reader_has_language_and_units_of_their_own(checked: tuple[str, Session, Report]) -> None:
    said = " ".join(pages_of(to_pdf(sheet_of(checked, "de", mass="oz", length="in", velocity="in/s")))).replace(
        "\u202f", " "
    )
    for part in (
        "Auswuchtprotokoll",
        "Ausgewuchtet: Was verlangt war",
        "0,122 in/s rms",
        "12,99 in",
        "460 U/min",
        "Seite 1 von",
    ):
        assert part in said, said
    assert "Balancing" not in said
    assert " g " not in said


def test_a_page_shows_the_same_and_links_to_the_files(
    shared_shop: Workshop, checked: tuple[str, Session, Report]
) -> None:
    key, client = checked[0], shared_shop.client
    page = client.get(f"/sessions/{key}/report", headers=HTML)
    assert page.status_code == 200
    sheet = sheet_of(checked)
    for section in sheet.sections:
        assert f"<h2>{section.heading}</h2>" in page.text
        for part in section.parts:
            if isinstance(part, Table):
                assert all(cell.replace("&", "&amp;") in page.text for row in part.rows for cell in row)
    drawn = sum(len(part.pictures) for s in sheet.sections for part in s.parts if isinstance(part, Pictures))
    assert page.text.count("<svg") == drawn >= 5
    assert len(page.content) < 150_000
    assert "style=" not in page.text
    for prefix in ("", "/api/v1"):
        answer = client.get(f"{prefix}/sessions/{key}/report.pdf")
        assert (answer.status_code, answer.headers["content-type"]) == (200, "application/pdf")
        assert answer.content.startswith(b"%PDF")
        assert answer.content == to_pdf(sheet)
        assert client.get(f"{prefix}/sessions/{key}/report.csv").headers["content-type"] == "text/csv; charset=utf-8"
    assert client.get(f"/sessions/{key}/report.json").json()["session"]["id"] == key
    for path in ("report", "report.pdf", "report.csv"):
        assert client.get(f"/sessions/nobody/{path}", headers=HTML).status_code == 404


def stories(shop: Workshop) -> Iterator[tuple[str, Any]]:
    """Sessions that are not like the others, by name."""
    yield "nothing yet", shop.session()
    one = shop.session()
    shop.run(one, "initial")
    yield "unfinished", one
    plain: dict[str, Any] = {"vibration_limit_mm_s": None, "rotor_mass_kg": None, "bearings": []}
    two = shop.session(shop.machine(**plain))
    shop.fit(shop.planned(two))
    yield "no limit, no tolerance", two
    three = shop.session()
    silent = [{"sensor": s, "amplitude": a, "phase_deg": None} for s, a in (("P", 3.1), ("Q", 4.8))]
    shop.post(f"/sessions/{three}/runs", {"kind": "initial", "readings": silent})
    answer = shop.correct(three, source="balancer", masses=[mass("1", 170.2, 70.0), mass("2", 292.2, 113.0)])
    shop.fit(shop.plan(three, answer, objective="components"))
    shop.post(f"/sessions/{three}/runs", {"kind": "check", "readings": silent})
    yield "no phase", three
    holes = [360.0 / 40 * n for n in range(40)]
    planes: list[dict[str, Any]] = [
        {"name": f"{n} {LONG[:90]}", "radius_mm": 330.0, "positions_deg": holes, "max_masses": 3} for n in range(8)
    ]
    sensors = [{"name": f"{n} {LONG[:90]}"} for n in range(9)]
    machine = shop.machine(type=STRANGE, planes=planes, sensors=sensors, bearings=[])
    four = shop.session(machine, technician=STRANGE, note=f"{LONG * 10}\n{STRANGE}")
    readings = [
        {"sensor": s["name"], "amplitude": 1e-6 if n else 99999.0, "phase_deg": 359.9} for n, s in enumerate(sensors)
    ]
    masses = [mass(plane["name"], 0.001, -359.0) for plane in planes]
    shop.post(f"/sessions/{four}/runs", {"kind": "initial", "readings": readings})
    shop.post(f"/sessions/{four}/runs", {"kind": "trial", "readings": readings, "masses": masses})
    yield "many planes, long and strange names", four


def test_sessions_of_every_kind_have_a_certificate(shared_shop: Workshop) -> None:
    expected = {
        "nothing yet": ("Not finished", "No run has been taken."),
        "unfinished": ("Not finished", "No mass has been fitted."),
        "no limit, no tolerance": ("Not finished", "Not stated: it needs grade"),
        "no phase": ("Above the limit: P, Q.", "Not examined"),
        "many planes, long and strange names": ("Not finished", "Ø µm ° ² <script>alert(1)</script> & □□ □"),
    }
    for name, key in stories(shared_shop):
        page = shared_shop.client.get(f"/sessions/{key}/report", headers=HTML)
        assert page.status_code == 200, name
        assert "<script>alert" not in page.text
        said = " ".join(pages_of(shared_shop.client.get(f"/sessions/{key}/report.pdf").content))
        for part in expected[name]:
            assert part in said, f"{name}: {part!r} is not in {said}"


@pytest.mark.parametrize(
    ("outcome", "mood"),
    [
        ("unchecked", "open"),
        ("above_limit", "bad"),
        ("grade_not_reached", "bad"),
        ("partly_judged", "open"),
        ("nothing_asked", "open"),
        ("reached", "good"),
    ],
)
def test_the_certificate_says_the_verdict(checked: tuple[str, Session, Report], outcome: Outcome, mood: str) -> None:
    report = replace(checked[2], verdict=replace(checked[2].verdict, outcome=outcome, above=("P", "Q")))
    sheet = certificate(checked[1], report, Reader())
    assert sheet.mood == mood
    assert ("P, Q" in sheet.verdict) == (outcome == "above_limit")
