"""What is counted is what happened."""

from __future__ import annotations

from service.runtime.metrics import MAX_SOURCES, Metrics


def value(meters: Metrics, line: str) -> float | None:
    """The figure that stands behind a name in Prometheus' text format."""
    found = [one for one in meters.text({}).decode().splitlines() if one.startswith(line + " ")]
    return float(found[0].rpartition(" ")[2]) if found else None


def gaps(*batches: list[int]) -> float | None:
    meters = Metrics()
    for batch in batches:
        meters.stored(len(batch), 0, [("a", number) for number in batch])
    return value(meters, 'drumtrue_sequence_gaps_total{source="a"}')


def test_gaps_are_counted_once_each_whatever_the_order() -> None:
    assert gaps([5, 6, 7], [8]) is None
    assert gaps([5, 7]) == 1
    assert gaps([5], [9]) == 1
    assert gaps([7, 5, 6], [8, 12, 10]) == 2
    assert gaps([5, 6], [5, 6], [4], [7]) is None


def test_sources_without_end_share_a_line() -> None:
    meters = Metrics()
    for number in range(MAX_SOURCES + 20):
        meters.stored(2, 0, [(f"s{number}", 1), (f"s{number}", 3)])
    lines = [line for line in meters.text({}).decode().splitlines() if line.startswith("drumtrue_sequence_gaps_total{")]
    assert len(lines) == MAX_SOURCES + 1
    assert value(meters, 'drumtrue_sequence_gaps_total{source="(others)"}') == 20


def test_a_source_that_is_unbound_leaves_no_lag_behind() -> None:
    meters = Metrics()
    assert b'drumtrue_source_lag_seconds{source="a"} 3.0' in meters.text({"a": 3.0})
    assert b'source="a"' not in meters.text({"b": 1.0})
