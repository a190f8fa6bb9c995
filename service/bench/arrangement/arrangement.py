"""The measurement: each problem by the search and by its peers, in processor time on one core."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from service.balancing.arrangement import ArrangementResult, objective_deviation, solve_best, values
from service.bench.arrangement.peers import PEERS, Peer
from service.bench.arrangement.problems import SIZES, Named, generated, published

CLOSE = 1e-6
"""Relative tolerance of the published optima."""
QUICK_SIZES = (6, 8, 10)


@dataclass(frozen=True)
class Line:
    """What came of one problem; peers: value by name, None where the method does not apply or is not installed."""

    named: Named
    result: ArrangementResult
    seconds: float
    peers: dict[str, float | None]

    @property
    def right(self) -> bool:
        """Whether a published optimum is met and proved, and no peer has found less than what is proved."""
        found = self.result
        if self.named.known is not None and not (
            found.status == "optimal" and abs(found.value - self.named.known) <= CLOSE * self.named.known
        ):
            return False
        return all(v is None or v >= found.lower_bound * (1.0 - CLOSE) for v in self.peers.values())


def bench_arrangement(*, quick: bool, markdown: bool, budget_s: float, seeds: int, write: Path | None = None) -> bool:
    """Measure and print; True where every published optimum is proved and no bound is broken. write: the data file."""
    problems = [*published(), *generated(QUICK_SIZES if quick else SIZES, seeds)]
    lines = [_measured(named, budget_s) for named in problems]
    _print(lines, markdown=markdown)
    if write is not None:
        write.write_text(json.dumps(_data(lines), indent=1) + "\n", encoding="utf-8")
    return all(line.right for line in lines)


def _measured(named: Named, budget_s: float) -> Line:
    posed = named.posed()
    begun = time.process_time()

    def deviation(arrangement: Any) -> float:
        return objective_deviation(posed.objective, posed.scale_covariance(arrangement))

    found = solve_best(
        posed.problem,
        posed.request.seed,
        deviation=deviation,
        stop=lambda: time.process_time() - begun > max(5.0, budget_s),
    )
    seconds = time.process_time() - begun
    peers = {name: _by_peer(peer, named, budget_s) for name, peer in PEERS.items()}
    return Line(named, found, seconds, peers)


def _by_peer(peer: Peer, named: Named, budget_s: float) -> float | None:
    problem = named.problem()
    if problem.max_moves is not None:
        return None
    try:
        row = peer(problem, 1, budget_s)
    except ImportError:
        return None
    return None if row is None else float(values(problem, row[None, :])[0])


def _print(lines: list[Line], *, markdown: bool) -> None:
    head = ["problem", "status", "seconds", "value", "bound", "scale", *PEERS]
    rows = [
        [
            line.named.name,
            line.result.status if line.right else f"WRONG ({line.result.status})",
            f"{line.seconds:.2f}",
            f"{line.result.value:.4g}",
            f"{line.result.lower_bound:.4g}",
            f"{line.result.scatter:.3g}" if line.result.scatter else "",
            *("" if value is None else f"{value:.4g}" for value in line.peers.values()),
        ]
        for line in lines
    ]
    if markdown:
        for row in (head, ["---"] * len(head), *rows):
            print(f"| {' | '.join(row)} |")
        return
    table = Table(*head, title="Arrangements: value in g.mm, seconds of processor time; scale: deviation of 1 g")
    for row in rows:
        table.add_row(*row)
    Console(width=200).print(table)


def _data(lines: list[Line]) -> dict[str, Any]:
    """The problems with their best values, for others to use: each is a request as POST /arrangements takes it."""
    return {
        "about": "Arrangement of weighed parts. Each request holds places, parts, planes and offset; best: the least "
        "value found of the norm over the planes of |r|, g.mm; proved: no arrangement has a smaller one.",
        "problems": [
            {
                "name": line.named.name,
                "request": line.named.request,
                "best": min([line.result.value, *(v for v in line.peers.values() if v is not None)]),
                "lower_bound": line.result.lower_bound,
                "proved": line.result.status == "optimal",
            }
            for line in lines
        ],
    }
