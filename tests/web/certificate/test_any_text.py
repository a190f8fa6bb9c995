"""A certificate of any size holds any text: what no font has is a box, and is said to be one."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen

from service.web.certificate import fallback_fonts
from service.web.certificate.document import Facts, Part, Section, Sheet, Table
from service.web.certificate.pdf import to_pdf
from tests.support.http.workshop import Workshop
from tests.web.certificate.test_certificate import pages_of

WORDS = {
    "Chinese": "滚筒", "Japanese": "ドラム", "Korean": "드럼", "Hindi": "ड्रम", "Thai": "ดรัม", "emoji": "🙂",
    "Cyrillic": "барабан", "Greek": "τύμπανο", "Polish": "bęben", "English": "drum",
}  # fmt: skip


@pytest.fixture(autouse=True)
def no_fonts_of_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fallback_fonts, "installed", lambda: ())


def sheet(*parts: Part) -> Sheet:
    """A certificate of these parts."""
    return Sheet(
        language="en",
        title="title",
        subject="subject",
        verdict="good",
        mood="good",
        sections=(Section("section", parts),),
        signatures=(("signed", ""),),
        signed=0,
        foot="foot",
        page_of="page %(page)s of %(pages)s",
        dated=datetime(2026, 3, 1, tzinfo=UTC),
    )


def said_in(pdf: bytes) -> str:
    return " ".join(pages_of(pdf))


@pytest.mark.parametrize("script", WORDS)
def test_a_word_of_any_script_is_printed_or_said_to_be_missing(script: str) -> None:
    word = WORDS[script]
    said = said_in(to_pdf(sheet(Facts((("word", word),)))))
    missing = sorted({f"U+{ord(sign):04X}" for sign in word})
    assert (word in said) != all(sign in said for sign in missing)
    assert ("cannot be printed" in said) == (word not in said)


def test_a_font_of_the_machine_stands_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "NotoSansSC-Regular.ttf"
    pen = TTGlyphPen(None)
    for step in (pen.moveTo, pen.lineTo, pen.lineTo):
        step((len(pen.points) * 100, 500 * (len(pen.points) % 2)))
    pen.closePath()
    glyph = pen.glyph()
    font = FontBuilder(1000, isTTF=True)
    font.setupGlyphOrder([".notdef", "a", "b"])
    font.setupCharacterMap({ord("滚"): "a", ord("筒"): "b"})
    font.setupGlyf({".notdef": glyph, "a": glyph, "b": glyph})
    font.setupHorizontalMetrics(dict.fromkeys((".notdef", "a", "b"), (1000, 0)))
    font.setupHorizontalHeader(ascent=800, descent=-200)
    font.setupNameTable({"familyName": "Stand-in", "styleName": "Regular"})
    font.setupOS2()
    font.setupPost()
    font.save(path)
    monkeypatch.setattr(fallback_fonts, "installed", lambda: (path,))
    said = said_in(to_pdf(sheet(Facts((("word", "滚筒"),)))))
    assert "滚筒" in said
    assert "cannot be printed" not in said


def test_a_row_taller_than_a_page_is_continued() -> None:
    names = "; ".join(f"bearing {number} drive end, horizontal" for number in range(200))
    note = "line\n" * 300
    pages = pages_of(
        to_pdf(sheet(Table(("run", "readings"), (("1", names), ("2", "short")), (1.0, 3.0)), Facts((("note", note),))))
    )
    said = " ".join(pages)
    assert len(pages) > 3
    for number in range(200):
        assert f"bearing {number} drive" in said
    assert said.count("line") == 300


def test_a_session_of_64_sensors_has_a_pdf(shop: Workshop) -> None:
    names = [f"Bearing {number} DE horizontal" for number in range(64)]
    session = shop.session(shop.machine(sensors=[{"name": name} for name in names]))
    for _ in range(3):
        readings = [{"sensor": name, "amplitude": 1.0, "phase_deg": 10.0} for name in names]
        shop.post(f"/sessions/{session}/runs", {"kind": "initial", "readings": readings})
    answer = shop.client.get(f"/sessions/{session}/report.pdf")
    assert answer.status_code == 200
    said = said_in(answer.content)
    assert all(name in said for name in names)
