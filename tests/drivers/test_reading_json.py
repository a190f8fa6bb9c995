"""JSON of a reading: written out by hand, the same as the encoder would make, and back again."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.errors import BrokenSource
from drivers.reading import Reading
from drivers.reading_json import reading_to_dict, reading_to_json
from drivers.reading_rules import reading_from_dict
from tests.support.drivers.frames import readings

FIRST, LAST = datetime(1971, 1, 1), datetime(2100, 1, 1)  # noqa: DTZ001
amounts = st.floats(0.0, 1e9)
names = st.text(min_size=1, max_size=100).filter(lambda text: text.encode("utf-8", "ignore").decode() == text)
zones = st.sampled_from([UTC, timezone(timedelta(hours=5, minutes=30)), timezone(-timedelta(hours=8))])


@given(
    st.builds(
        Reading,
        source=names,
        sequence=st.integers(0, 2**53 - 1),
        taken_at=st.datetimes(FIRST, LAST, timezones=zones),
        sensor=names,
        amplitude=amounts,
        phase_deg=st.none() | st.floats(-360.0, 360.0),
        speed_rpm=st.none() | st.floats(1e-3, 1e9),
        scatter=st.none() | st.floats(1e-9, 1e9),
        overall_rms=st.none() | amounts,
        session_id=st.none() | names,
    )
)
def test_any_reading_there_and_back(reading: Reading) -> None:
    written = json.loads(reading_to_json(reading))
    assert written == reading_to_dict(reading)
    assert reading_from_dict(written) == reading


@pytest.mark.parametrize("name", ["amplitude", "phase_deg", "speed_rpm", "scatter", "overall_rms"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_json_does_not_have_is_refused(name: str, value: float) -> None:
    spoilt = replace(readings(1)[0], **{name: value})  # type: ignore[arg-type]
    with pytest.raises(BrokenSource, match="sequences 1 to 1"):
        reading_to_json(spoilt)
