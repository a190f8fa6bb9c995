"""The measurement itself: it counts what it says, and loses nothing."""

from __future__ import annotations

import pytest

from service.bench.can.can import FULL_BUS, into_database
from service.bench.can.frames import prepared_frames


def test_all_frames_of_a_short_run_are_stored() -> None:
    prepared = prepared_frames()
    for count, rate in ((3000, None), (2000, FULL_BUS)):
        measured = into_database(prepared, count, rate)
        assert (measured.frames, measured.stored) == (count, count)
        assert measured.cpu_s > 0.0
        assert measured.rate == pytest.approx(count / measured.seconds)
