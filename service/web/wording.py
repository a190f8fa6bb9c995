"""What use cases say - findings, refusals, advice - as sentences in the reader's language.

They speak English with values in it. The catalogue has each such text with {0}, {1} ... where values stand; a text is
matched with them, and its values are put into the translation. What is not in the catalogue is shown as it was said.
"""

from __future__ import annotations

import re
from functools import cache, lru_cache

from service.web.language import N_, messages, translations
from service.web.numbers import COMMA

NOUNS = (N_("run"), N_("runs"), N_("plane"), N_("planes"), N_("sensor"), N_("sensors"), N_("and"), N_("degrees"))
"""Words that stand in values: run 3, plane 2."""
_PLACE = re.compile(r"\\\{\d+\\\}")
"""A place for a value, once the text is escaped for a pattern."""
_NOUN = re.compile(rf"\b({'|'.join(NOUNS)})\b")
_POINT = re.compile(r"(?<=\d)\.(?=\d)")


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
    for pattern, wanted in _patterns(language):
        if match := pattern.fullmatch(told):
            return wanted.format(*(_value(text, language) for text in match.groups()))
    return told


def _value(text: str, language: str) -> str:
    named = _NOUN.sub(lambda noun: translations(language).gettext(noun.group(1)), text)
    return _POINT.sub(",", named) if language in COMMA else named


@cache
def _patterns(language: str) -> tuple[tuple[re.Pattern[str], str], ...]:
    """Texts with values, the longest first: a short one may be the beginning of another."""
    known = messages(language)
    told = sorted((one for one in known if "{0}" in one), key=len, reverse=True)
    return tuple((re.compile(_PLACE.sub("(.+?)", re.escape(one))), known[one]) for one in told)
