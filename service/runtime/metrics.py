"""Prometheus counters of one process.

What is stored is asked of the database when it is scraped.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

from service.runtime.listeners import ListenerState

MAX_SOURCES = 500
"""Sources with a line of their own; a stranger's thousand names must not fill the memory."""
OTHERS = "(others)"
_REQUEST_S = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0)
_SOLVE_S = (0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 120.0)


class Metrics:
    """Counters of one process; safe between threads."""

    def __init__(self) -> None:
        self._registry = registry = CollectorRegistry()
        self._stored = Counter("drumtrue_readings_stored", "Readings stored.", registry=registry)
        self._repeated = Counter("drumtrue_readings_repeated", "Readings that were stored before.", registry=registry)
        self._gaps = Counter(
            "drumtrue_sequence_gaps",
            "Times a source's numbers went on with some left out.",
            ["source"],
            registry=registry,
        )
        self._lag = Gauge(
            "drumtrue_source_lag_seconds", "Age of the newest reading of a bound source.", ["source"], registry=registry
        )
        self._offset = Gauge(
            "drumtrue_source_clock_offset_seconds",
            "What is added to the times of a bound source: above 0 its clock is behind.",
            ["source"],
            registry=registry,
        )
        self._apart = Gauge(
            "drumtrue_source_readings_set_apart",
            "Readings of a bound source that were dated ahead of their receipt.",
            ["source"],
            registry=registry,
        )
        self._solve = Histogram(
            "drumtrue_solve_seconds",
            "Time that a plan took.",
            ["method", "status"],
            buckets=_SOLVE_S,
            registry=registry,
        )
        self._requests = Histogram(
            "drumtrue_request_seconds",
            "Time from a request to the end of its answer.",
            ["operation", "status"],
            buckets=_REQUEST_S,
            registry=registry,
        )
        self._listening = Gauge(
            "drumtrue_listener_up", "1 while a bus is read, 0 while it is opened again.", ["source"], registry=registry
        )
        self._again = Gauge(
            "drumtrue_listener_again",
            "Times that a bus was opened, or its reader started, again.",
            ["source"],
            registry=registry,
        )
        self._frames = Gauge(
            "drumtrue_frames_refused",
            "Frames of a bus without a reading, since its reader was started.",
            ["source", "reason"],
            registry=registry,
        )
        self._highest: dict[str, int] = {}
        self._lock = threading.Lock()

    def stored(self, accepted: int, repeated: int, keys: Iterable[tuple[str, int]]) -> None:
        """Count readings that came in together; keys: source and sequence of each, in any order."""
        self._stored.inc(accepted)
        self._repeated.inc(repeated)
        sequences: dict[str, list[int]] = {}
        for source, sequence in keys:
            sequences.setdefault(source, []).append(sequence)
        for source, numbers in sequences.items():
            if gaps := self._gaps_in(source, sorted(numbers)):
                self._gaps.labels(source if source in self._highest else OTHERS).inc(gaps)

    def _gaps_in(self, source: str, numbers: list[int]) -> int:
        """How often the numbers leave some out, after the highest one so far; earlier ones come again and count not."""
        with self._lock:
            known = source in self._highest
            last = self._highest.get(source, numbers[0] - 1)
            new = [number for number in numbers if number > last]
            if new and (known or len(self._highest) < MAX_SOURCES):
                self._highest[source] = new[-1]
        if not new or new[-1] - last == len(new):
            return 0
        return sum(later - earlier > 1 for earlier, later in zip([last, *new], new, strict=False))

    def solved(self, method: str, status: str, seconds: float) -> None:
        """Count a plan."""
        self._solve.labels(method, status).observe(seconds)

    def answered(self, operation: str, status: int, seconds: float) -> None:
        """Count a request."""
        self._requests.labels(operation, str(status)).observe(seconds)

    def text(
        self,
        lags_s: Mapping[str, float],
        listeners: Sequence[ListenerState] = (),
        *,
        offsets_s: Mapping[str, float] = MappingProxyType({}),
        apart: Mapping[str, int] = MappingProxyType({}),
    ) -> bytes:
        """All of it in Prometheus' text format.

        By bound source: age of the newest reading and offset of the clock, both s; how many readings were set apart.
        """
        for one in listeners:
            self._listening.labels(one.source).set(one.state == "listening")
            self._again.labels(one.source).set(one.reopened + one.restarts)
            for reason, count in one.refused.items():
                self._frames.labels(one.source, reason).set(count)
        told: tuple[tuple[Gauge, Mapping[str, float]], ...]
        told = ((self._lag, lags_s), (self._offset, offsets_s), (self._apart, apart))
        for gauge, values in told:
            gauge.clear()
            for source, value in values.items():
                gauge.labels(source).set(value)
        return generate_latest(self._registry)
