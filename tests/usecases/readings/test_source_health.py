"""How well a source is heard: rate, what is missing, how long it was silent."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

import pytest

from service.usecases.readings.source_health import LOOKED_AT, SourceHealth, health
from tests.support.http.workshop import Workshop


def heard(shop: Workshop, source: str, entries: list[tuple[int, float]]) -> SourceHealth:
    """Health of a source after readings of these numbers, so many seconds after a first moment."""
    shop.ask("PUT", f"/sources/{source}", {"machine_id": shop.machine()})
    begin = datetime.fromisoformat("2025-12-01T08:00:00+00:00")
    readings: list[dict[str, Any]] = [
        {
            "source": source,
            "sequence": number,
            "taken_at": (begin + timedelta(seconds=at)).isoformat(),
            "sensor": "P",
            "amplitude": 1.0,
        }
        for number, at in entries
    ]
    if readings:
        shop.post("/readings", readings)
    return next(one for one in health(shop.work) if one.name == source)


def test_a_steady_source_has_its_rate_and_misses_nothing(shared_shop: Workshop) -> None:
    found = heard(shared_shop, "steady", [(n, 0.5 * n) for n in range(21)])
    assert (found.looked_at, found.missing, found.rate_hz, found.longest_gap_s) == (21, 0, 2.0, 0.5)
    assert found.newest_at == datetime.fromisoformat("2025-12-01T08:00:10+00:00")


def test_numbers_left_out_are_missing_and_a_silence_is_measured(shared_shop: Workshop) -> None:
    found = heard(shared_shop, "gaps", [(5, 0.0), (6, 1.0), (9, 2.0), (10, 40.0)])
    assert (found.missing, found.longest_gap_s) == (2, 38.0)


def test_an_answer_of_a_balancer_takes_a_number_too(shared_shop: Workshop) -> None:
    heard(shared_shop, "balancer", [(1, 0.0), (3, 1.0)])
    answer = {"source": "balancer", "sequence": 2, "taken_at": "2025-12-01T08:00:02Z"}
    masses = [{"plane": "1", "mass_g": 10.0, "angle_deg": 0.0}]
    shared_shop.post("/balancer-answers", {**answer, "masses": masses})
    found = next(one for one in health(shared_shop.work) if one.name == "balancer")
    assert (found.looked_at, found.missing) == (3, 0)


@pytest.mark.parametrize("entries", [[], [(7, 0.0)], [(7, 0.0), (8, 0.0)]])
def test_what_cannot_be_known_is_none(shared_shop: Workshop, entries: list[tuple[int, float]]) -> None:
    found = heard(shared_shop, f"few {len(entries)}", entries)
    assert found.rate_hz is None
    assert found.missing == 0
    assert (found.newest_at is None) == (not entries)


def test_only_the_latest_count(shared_shop: Workshop) -> None:
    old = [(n, float(n)) for n in range(0, 40, 2)]
    found = heard(shared_shop, "old gaps", [*old, *((1000 + n, 1000.0 + n) for n in range(LOOKED_AT))])
    assert (found.looked_at, found.missing, found.rate_hz) == (LOOKED_AT, 0, 1.0)
