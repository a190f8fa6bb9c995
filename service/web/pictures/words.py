"""Words that several pictures use."""

from __future__ import annotations

from collections.abc import Sequence

from service.model.run import MassOnRotor
from service.web.pictures.reader import Reader


def mass_words(masses: Sequence[MassOnRotor], reader: Reader, most: int = 4) -> str:
    """Masses as text, such as `L: 200 g @ 0°`; beyond `most` only how many more."""
    words = [f"{short(m.plane)}: {reader.mass(m.mass_g)} @ {reader.angle(m.angle_deg)}" for m in masses[:most]]
    more = len(masses) - most
    return ", ".join([*words, *([reader.gettext("%(count)s more") % {"count": more}] if more > 0 else [])])


def short(name: str, most: int = 16) -> str:
    """A name that fits into a picture."""
    return name if len(name) <= most else name[: most - 1] + "…"
