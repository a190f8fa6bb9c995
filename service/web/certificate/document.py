"""What a certificate is put together from; all text is in the reader's language already."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from itertools import chain
from typing import Literal, TypeAlias

from service.web.pictures.drawing import Group, Item, Picture, Words

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
    signatures: tuple[tuple[str, str], ...]
    """Who signs, and the name as far as it is known: next to the result, in the section `signed`."""
    foot: str
    page_of: str
    dated: datetime
    unprinted: str = "%(count)s signs cannot be printed, a box stands for each: %(signs)s"
    """What is said where the fonts lack signs."""
    signed: int = -1
    """Index of the section below which they sign; the last one by default."""

    def texts(self) -> Iterator[str]:
        """Every text of the certificate."""
        yield from (
            self.title,
            self.subject,
            self.verdict,
            self.foot,
            self.page_of,
            *chain.from_iterable(self.signatures),
        )
        for section in self.sections:
            yield section.heading
            for part in section.parts:
                yield from _texts(part)


def _texts(part: Part) -> Iterator[str]:
    match part:
        case Facts(pairs):
            yield from chain.from_iterable(pairs)
        case Table():
            yield from chain(part.heads, *part.rows)
        case Lines(lines):
            yield from lines
        case Pictures(pictures):
            for picture in pictures:
                yield from _words(picture.items)


def _words(items: Iterable[Item]) -> Iterator[str]:
    for item in items:
        if isinstance(item, Words):
            yield item.text
        elif isinstance(item, Group):
            yield from _words(item.items)
