"""Every class that a picture uses has its paint, on the page and on paper."""

from __future__ import annotations

import re
from pathlib import Path

from service.web import pictures
from service.web.assets import files
from service.web.certificate.pdf_style import Paint, paint_of
from service.web.pictures import palette

ROOM = Path(pictures.__file__).parent
UNPAINTED = {"pic", "pic-place", "pic-needle"}


def test_every_class_of_the_pictures_is_painted_and_every_paint_is_used() -> None:
    code = "".join(path.read_text() for path in ROOM.rglob("*.py") if path.name != "palette.py")
    used = set(re.findall(r"pic-[a-z-]*[a-z]", code))
    sheet = files()["pictures.css"].decode()
    painted = set(re.findall(r"^\.(pic-[\w-]+) \{", sheet, re.MULTILINE))
    made = {f"pic-{kind}{end}" for kind in ("initial", "trial", "check", "correction") for end in ("", "-fill")}
    made |= {f"pic-{part}-words" for part in ("add", "remove", "keep", "fixed", "blocked", "over", "after")}
    made |= {f"pic-{arrow}-{end}" for arrow in ("sense", "turning") for end in ("head", "words")}
    assert used - UNPAINTED <= painted
    assert painted <= used | made


def test_the_rules_of_the_palette_are_those_of_the_pages() -> None:
    sheet = files()["pictures.css"].decode()
    assert sheet == palette.written(sheet), "write them again: python -m service.web.pictures.palette"
    light = dict(re.findall(r"--([\w-]+):\s*(#[0-9a-fA-F]{6})", sheet.partition("}")[0]))
    assert light == palette.LIGHT


def test_colours_of_light_dark_and_paper_have_the_same_names() -> None:
    blocks = re.findall(r":root[^{]*\{([^}]*)\}", files()["pictures.css"].decode())
    names = [set(re.findall(r"--(pic-[\w-]+):", block)) for block in blocks]
    assert len(names) == 3
    assert names[0] == names[1] == names[2]


def test_paint_on_paper_follows_the_rules_later_ones_first() -> None:
    assert paint_of("pic-vector pic-trial") == Paint(stroke=(11, 87, 208), width=3.0)
    assert paint_of("pic-limit").dashes == (8.0, 4.0)
    assert paint_of("pic-badge pic-check-fill").fill == (0, 107, 60)
    assert paint_of("pic-strong").bold
    assert paint_of("pic-place") == Paint()
