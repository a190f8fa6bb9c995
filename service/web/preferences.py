"""What the reader chose: language, light or dark, units. Kept in a cookie, nothing of it at the server."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from urllib.parse import parse_qsl, urlencode

COOKIE = "drumtrue_preferences"
LANGUAGES = {"en": "English", "de": "Deutsch"}
CHOICES: dict[str, tuple[str, ...]] = {
    "language": tuple(LANGUAGES),
    "theme": ("auto", "light", "dark"),
    "mass": ("g", "oz"),
    "length": ("mm", "in"),
    "velocity": ("mm/s", "in/s"),
    "detection": ("sensor", "rms", "peak", "peak_to_peak"),
}


@dataclass(frozen=True)
class Preferences:
    """The reader's choices; `detection` sensor: as each sensor states it."""

    language: str = "en"
    theme: str = "auto"
    mass: str = "g"
    length: str = "mm"
    velocity: str = "mm/s"
    detection: str = "sensor"

    @staticmethod
    def read(cookie: str | None, accepted: str | None) -> Preferences:
        """From the cookie; the language else from the header Accept-Language. What is not known is passed over."""
        base = Preferences(language=_accepted(accepted))
        return base.changed(dict(parse_qsl(cookie or "")[:20]))

    def changed(self, given: Mapping[str, str]) -> Preferences:
        """With those of the given choices that exist."""
        names = {field.name for field in fields(self)}
        return replace(self, **{k: v for k, v in given.items() if k in names and v in CHOICES[k]})

    def cookie(self) -> str:
        """The value of the cookie."""
        return urlencode(asdict(self))


def _accepted(header: str | None) -> str:
    """The best language of ours in an Accept-Language header; English without any."""
    ranked: list[tuple[float, int, str]] = []
    for place, part in enumerate((header or "").split(",")[:20]):
        tag, _, quality = part.strip().partition(";q=")
        language = tag.partition("-")[0].lower()
        if language in LANGUAGES:
            ranked.append((-_quality(quality), place, language))
    return min(ranked)[2] if ranked else "en"


def _quality(text: str) -> float:
    try:
        return float(text or 1.0)
    except ValueError:
        return 0.0
