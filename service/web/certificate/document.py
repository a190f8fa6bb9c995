"""What a certificate is put together from; all text is in the reader's language already."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Literal, TypeAlias

from service.web.pictures.drawing import Picture

Mood = Literal["good", "bad", "open"]


@dataclass(frozen=True)
class Facts:
    """Names and what they are."""

    pairs: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Table:
    """Rows below headings; `widths` are shares, `figures` the columns of numbers."""

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    widths: tuple[float, ...]
    figures: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Pictures:
    """Pictures side by side, `across` of them."""

    pictures: tuple[Picture, ...]
    across: int


@dataclass(frozen=True)
class Lines:
    """Sentences."""

    lines: tuple[str, ...]


Part: TypeAlias = Facts | Table | Pictures | Lines


@dataclass(frozen=True)
class Section:
    """Parts below a heading."""

    heading: str
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Sheet:
    """A certificate: title, what it is about, the verdict, sections, who signs; `dated` is when its last fact was."""

    language: str
    title: str
    subject: str
    verdict: str
    mood: Mood
    sections: tuple[Section, ...]
    signatures: tuple[str, ...]
    foot: str
    page_of: str
    dated: datetime
