"""Messages in words: names as they are, numbers in the reader's language, quantities in the reader's units."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.errors import InvalidInput, NumericsError
from service.messages import Message, Part, Quantity, Word, from_json, parameters_json, render, render_advice
from service.messages.catalogue import Entry, Text, entries
from service.web.display import Display
from service.web.preferences import Preferences

GERMAN = Display(Preferences(language="de"))
OUNCES = Display(Preferences(mass="oz", length="in"))
TEXTS = {
    "test_mass": Entry(
        Text({"other": '{plane} must take at most {most}, got {mass} in "{name}" ({share:.0%})'}),
        Text({"other": "use {choices:or}; {names:,}"}),
    ),
    "test_count": Entry(Text({"one": "{count} run of {kind}", "other": "{count} runs of {kind}"})),
    "test_outer": Entry(Text({"other": "therefore: {cause}"})),
}


@pytest.fixture(autouse=True)
def known_texts(monkeypatch: pytest.MonkeyPatch) -> None:
    present = entries("en")
    monkeypatch.setattr("service.messages.catalogue.entries", lambda *_: {**present, **TEXTS})


def mass_message(name: str) -> Message:
    return Message(
        "test_mass",
        plane=Part("plane", 1, name),
        most=Quantity(28.349523125, "g"),
        mass=Quantity(np.float64(300.5), "g"),
        name=name,
        share=0.125,
        choices=("a", "b", "c"),
        names=[],
    )


def test_a_message_is_written_in_english_with_its_advice() -> None:
    message = mass_message("left")
    assert render(message) == 'plane "left" must take at most 28.3495 g, got 300.5 g in "left" (12%)'
    assert render_advice(message) == "use a, b or c; none"


def test_quantities_come_in_the_readers_units_and_numbers_with_the_readers_sign() -> None:
    assert "at most 1 oz, got 10.6 oz" in render(mass_message("left"), OUNCES).replace("\N{NARROW NO-BREAK SPACE}", " ")
    assert "got 300,5" in render(mass_message("left"), GERMAN)


@given(st.sampled_from(["open 10 g", "pickup 5 mm", "fitted", "{0}", "%s", "{plane}", "1.5 mm and 2.5 g", "run"]))
def test_a_name_is_shown_as_it_is_in_every_language_and_unit(name: str) -> None:
    for reader in (GERMAN, OUNCES, Display(Preferences(language="de", mass="oz", length="in"))):
        assert render(mass_message(name), reader).count(name) >= 2


def test_a_count_chooses_the_plural_and_words_are_those_of_the_language() -> None:
    assert render(Message("test_count", count=1, kind=Word("trial"))) == "1 run of trial"
    assert render(Message("test_count", count=2, kind=Word("trial"))) == "2 runs of trial"


def test_a_message_holds_others_and_an_unknown_key_or_value_is_shown_for_what_it_is() -> None:
    inner = Message("test_count", count=2, kind=Word("trial"))
    assert render(Message("test_outer", cause=inner)) == "therefore: 2 runs of trial"
    assert render(Message("test_outer")) == "therefore: ?"
    assert render(Message("nothing_known", value=1)) == "nothing_known"
    assert render_advice(Message("nothing_known")) is None


leaves = st.one_of(
    st.text(max_size=20),
    st.booleans(),
    st.none(),
    st.integers(-(2**53), 2**53),
    st.floats(allow_nan=False, allow_infinity=False),
    st.builds(Quantity, st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(["g", "mm", "r/min"])),
    st.builds(Word, st.sampled_from(["trial", "planned"])),
    st.builds(Part, st.sampled_from(["run", "plane", "sensor"]), st.integers(1, 9), st.none() | st.text(max_size=9)),
)
parameters = st.dictionaries(st.sampled_from("abcd"), st.recursive(leaves, lambda one: st.lists(one, max_size=3)))


@given(parameters)
def test_what_is_stored_is_read_back_as_the_same_message(values: dict[str, object]) -> None:
    inner = Message("test_count", **values)
    message = Message("test_outer", cause=inner, **values)
    assert from_json(message.key, parameters_json(message)) == message


def test_an_error_takes_its_code_text_and_advice_from_its_message() -> None:
    error = NumericsError(mass_message("left"), field="planes")
    assert error.code == "test_mass"
    assert str(error) == error.message == render(mass_message("left"))
    assert error.advice == "use a, b or c; none"
    assert NumericsError(Message("numerics.some_variant")).code == "numerics"
    assert InvalidInput(mass_message("left"), code="another").code == "another"


def test_numbers_of_numpy_are_kept_as_plain_ones() -> None:
    message = Message("test_outer", a=np.int64(3), b=np.array([1.0, 2.0]), c=np.float64(0.5), d=(np.int64(1),))
    assert parameters_json(message) == {"a": 3, "b": [1.0, 2.0], "c": 0.5, "d": [1]}
    assert all(type(value) in {int, float, tuple} for value in message.parameters.values())
