"""Every message of the code has its text in every language, and every text names values that its message has."""

from __future__ import annotations

import string
from typing import get_args

import pytest

from service.messages.catalogue import ENGLISH_ONLY, SOURCE, Entry, entries
from service.model.plan import PlanState
from service.model.run import RunKind
from service.model.session import SessionState
from service.web.preferences import LANGUAGES
from tests.messages.sources import all_made, made_in

WORDS = ("word.", "unit.", "part.", "list.")


def values_in(entry: Entry) -> set[str]:
    texts = [*entry.message.forms.values(), *(entry.advice.forms.values() if entry.advice else ())]
    return {name for text in texts for _, name, _, _ in string.Formatter().parse(text) if name is not None}


def test_every_message_of_the_code_has_a_text_that_names_its_values() -> None:
    texts = entries(SOURCE)
    for one in all_made():
        assert one.key in texts, f"{one.place}: write {one.key} into service/messages/texts/en"
        if one.names is not None:
            assert values_in(texts[one.key]) <= one.names, f"{one.place}: {one.key}"


def test_every_text_is_of_a_message_of_the_code() -> None:
    used = {one.key for one in all_made()}
    assert {key for key in entries(SOURCE) if not key.startswith(WORDS)} <= used


@pytest.mark.parametrize("language", sorted(set(LANGUAGES) - {SOURCE}))
def test_every_text_is_translated_and_names_no_other_values(language: str) -> None:
    texts, translated = entries(SOURCE), entries(language)
    own = {key for name in ENGLISH_ONLY for key in entries(SOURCE, name)}
    assert texts.keys() - own == translated.keys()
    for key, entry in translated.items():
        assert values_in(entry) <= values_in(texts[key]), key
        assert (entry.advice is None) == (texts[key].advice is None), key
        assert "other" in entry.message.forms, key


@pytest.mark.parametrize("language", sorted(LANGUAGES))
def test_every_state_and_kind_is_a_word_of_each_language(language: str) -> None:
    kinds = {*get_args(RunKind), *get_args(PlanState), *get_args(SessionState)}
    assert {f"word.{name}" for name in kinds} <= entries(language).keys()


def test_a_text_is_trimmed_and_ends_without_a_full_stop() -> None:
    for key, entry in entries(SOURCE).items():
        if not key.startswith(WORDS):
            for text in (*entry.message.forms.values(), *(entry.advice.forms.values() if entry.advice else ())):
                assert text.strip(" .;") == text, key


def test_keys_are_found_in_the_source_text_both_of_a_condition() -> None:
    found = list(made_in('x = Message("a.b" if y else "c", plane=1)\nMessage("d", **more)', "here"))
    assert [(one.key, one.names) for one in found] == [
        ("a.b", frozenset({"plane"})),
        ("c", frozenset({"plane"})),
        ("d", None),
    ]
