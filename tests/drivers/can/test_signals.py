"""Single signals against cantools' decoding of whole messages."""

from __future__ import annotations

from dataclasses import replace

import cantools
import pytest
from cantools.database.can import Database
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.can.signals import raw_signal
from tests.drivers.can.databases import Drawn, messages


@given(messages(), st.binary(min_size=7, max_size=7), st.integers(0, 2))
@settings(max_examples=150, deadline=None)
def test_values_are_those_of_cantools(drawn: tuple[str, list[Drawn]], rest: bytes, page: int) -> None:
    database = cantools.database.load_string(drawn[0], "dbc", strict=False)
    assert isinstance(database, Database)
    (message,) = database.messages
    data = bytes([page]) + rest
    for one in drawn[1]:
        signal = raw_signal(message, one.name)
        assert signal.shown(data) is (one.page is None or one.page == page)
        assert signal.value(signal.raw(data)) == pytest.approx(alone(one, data), rel=1e-12, abs=1e-12)
        for size in range(signal.needs, 12):  # what lies behind changes nothing
            assert signal.raw(data[:size].ljust(size, b"\xa5")) == signal.raw(data)


def alone(one: Drawn, data: bytes) -> float:
    """What cantools makes of the signal, the only one of its message."""
    text = f'VERSION ""\nNS_ :\nBS_:\nBU_: X\nBO_ 291 Msg: 8 X\n{replace(one, page=None).line()}\n'
    database = cantools.database.load_string(text, "dbc")
    assert isinstance(database, Database)
    found = database.messages[0].decode(data, decode_choices=False)
    assert isinstance(found, dict)
    return float(found[one.name])  # type: ignore[arg-type]


@given(st.floats(allow_nan=False, width=32), st.booleans())
def test_floating_point(value: float, little: bool) -> None:
    start, order = (0, 1) if little else (7, 0)
    head = 'VERSION ""\nNS_ :\nBS_:\nBU_: X\nBO_ 291 Msg: 4 X\n'
    text = f'{head} SG_ F : {start}|32@{order}- (1,0) [0|0] "" X\nSIG_VALTYPE_ 291 F : 1;\n'
    database = cantools.database.load_string(text, "dbc")
    assert isinstance(database, Database)
    message = database.messages[0]
    assert raw_signal(message, "F").raw(message.encode({"F": value})) == value
