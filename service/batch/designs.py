"""Long searches of designs: independent seeds on the cores of this machine, or on a Dask cluster."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from typing import Any

from service.design.optimising import AGREED, Outcome, optimise


@dataclass(frozen=True)
class SeedAnswer:
    """What one seed found: its seed, and the outcome."""

    seed: int
    outcome: Outcome


def optimise_seeds(
    executor: Executor,
    document: dict[str, Any],
    seeds: Sequence[int],
    method: str | None = None,
    steps: int | None = None,
    time_limit_s: float = 60.0,
) -> Iterator[SeedAnswer]:
    """Optimise a document from each seed, answers as they come. Raises RefusedDesign.

    time_limit_s: of each search, on the clock of where it runs.
    """
    work = [executor.submit(_one, document, seed, method, steps, time_limit_s) for seed in seeds]
    for done in as_completed(work):
        yield done.result()


def best_of(found: Sequence[SeedAnswer]) -> SeedAnswer:
    """The best answer: feasible before infeasible, then by what is optimised, then the lowest seed."""
    return min(found, key=lambda one: (one.outcome.result.violation, one.outcome.result.value, one.seed))


def agreeing(found: Sequence[SeedAnswer]) -> int:
    """How many seeds ended within a millionth of the best."""
    best = best_of(found).outcome.result
    near = AGREED * max(abs(best.value), 1e-300)
    return sum(one.outcome.result.feasible and one.outcome.result.value - best.value <= near for one in found)


def _one(document: dict[str, Any], seed: int, method: str | None, steps: int | None, time_limit_s: float) -> SeedAnswer:
    found = optimise(document, method, seed, steps, clock=time.monotonic, deadline_s=time_limit_s)
    return SeedAnswer(seed, found)
