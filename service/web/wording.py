"""What use cases say - findings, refusals, advice - as sentences in the reader's language and units.

A message as data is rendered from its catalogue. The rest of this module serves texts that have no key yet:

They speak English with values in it. The catalogue has each such text with {0}, {1} ... where values stand; a text is
matched with them, and its values are put into the translation. What is not in the catalogue is shown as it was said.
"""

from __future__ import annotations

import re
from functools import cache, lru_cache
from typing import Protocol

from service.messages import Message, render, render_advice
from service.model.message import MessageData
from service.web.display import Display
from service.web.language import N_, messages, translations
from service.web.numbers import COMMA

NOUNS = (
    *(N_("run"), N_("runs"), N_("plane"), N_("planes"), N_("sensor"), N_("sensors"), N_("and"), N_("degrees")),
    *(N_("machine"), N_("catalogue"), N_("session"), N_("source"), N_("correction"), N_("plan"), N_("trial")),
    *(N_("proposed"), N_("fitted"), N_("unfitted"), N_("open"), N_("corrected"), N_("planned"), N_("checked")),
    *(N_("closed"), N_("selection"), N_("selections"), N_("hole")),
)
"""Words that stand in values: run 3, plane 2; a plan that is fitted."""
JOINED = (
    *(N_("the best selection"), N_("{0}, or with {1}"), N_("{0}, or with {1} other pieces")),
    *(N_("{0} gave nothing in {1}, and without it {2}"), N_("there was no time to try every other change")),
)
"""Texts that are put together from others."""
APART = "; "
"""Between the sentences of a reason."""
_PLACE = re.compile(r"\\\{\d+\\\}")
"""A place for a value, once the text is escaped for a pattern."""
_NOUN = re.compile(rf"\b({'|'.join(NOUNS)})\b")
_POINT = re.compile(r"(?<=\d)\.(?=\d)")


class Told(Protocol):
    """An error or a finding: as data where it is, and in English."""

    @property
    def data(self) -> Message | None:
        """Key and values."""

    @property
    def message(self) -> str:
        """What is wrong."""

    @property
    def advice(self) -> str | None:
        """What to do."""


def sentence(told: str | Message | MessageData | None, show: Display) -> str:
    """A message, or a text that has no key, as a sentence that begins with a capital letter; without a full stop."""
    if told is None or isinstance(told, str):
        return show.in_own_units(words(told or "", show.language))
    return _capital(render(told.message if isinstance(told, MessageData) else told, show))


def advice_of(told: Told, show: Display) -> str:
    """The advice of an error or a finding as sentences, the last with its full stop too."""
    found = None if told.data is None else render_advice(told.data, show)
    text = sentence(told.advice, show) if found is None else _capital(found)
    return text if text[-1:] in ("", ".", "!", "?") else f"{text}."


def message_of(told: Told, show: Display) -> str:
    """The message of an error or a finding as a sentence."""
    return sentence(told.data or told.message, show)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


@lru_cache(maxsize=2048)
def words(told: str, language: str) -> str:
    """The text as a sentence."""
    told = told.strip()
    found = _translated(told, language)
    return found[:1].upper() + found[1:]


def _translated(told: str, language: str) -> str:
    exact = translations(language).gettext(told) if told else told
    if exact != told:
        return exact
    matches = ((pattern.fullmatch(told), wanted) for pattern, wanted in _patterns(language))
    found = [(match.groups(), wanted) for match, wanted in matches if match]
    whole = next((one for one in found if not any(APART in value for value in one[0])), None)
    if whole is None and APART in told:
        return APART.join(_translated(part, language) for part in told.split(APART))
    if whole is None:
        return told
    values, wanted = whole
    return wanted.format(*(_value(text, language) for text in values))


def _value(text: str, language: str) -> str:
    """A value: a text of the catalogue itself, or a name or a number with nouns."""
    if " " in text and (inner := _translated(text, language)) != text:
        return inner
    named = _NOUN.sub(lambda noun: translations(language).gettext(noun.group(1)), text)
    return _POINT.sub(",", named) if language in COMMA else named


@cache
def _patterns(language: str) -> tuple[tuple[re.Pattern[str], str], ...]:
    """Texts with values, the longest first: a short one may be the beginning of another."""
    known = messages(language)
    told = sorted((one for one in known if "{0}" in one), key=len, reverse=True)
    return tuple((re.compile(_PLACE.sub("(.+?)", re.escape(one))), known[one]) for one in told)
