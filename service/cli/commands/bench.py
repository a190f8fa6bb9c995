"""`drumtrue bench NAME`; one sub-command a measurement."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Measure against named peers and limits, in one run.", no_args_is_help=True)

Markdown = Annotated[bool, typer.Option("--markdown", help="Print Markdown, for docs/benchmarks.md.")]


@app.command()
def fit(markdown: Markdown = False) -> None:
    """Fit, correction and diagnostics beside numpy's bare least squares."""
    from service.bench.fit import bench_fit

    raise SystemExit(0 if bench_fit(markdown=markdown) else 1)


@app.command()
def start(
    markdown: Markdown = False,
    repeats: Annotated[int, typer.Option(min=1, help="Fresh processes of each command.")] = 5,
) -> None:
    """Processor time of commands in fresh processes, beside the bare imports of what they are built on."""
    from service.bench.start import bench_start

    raise SystemExit(0 if bench_start(repeats=repeats, markdown=markdown) else 1)


@app.command()
def selection(
    as_published: Annotated[
        bool, typer.Option("--as-published", help="Modified Jaya as published, at its published budgets, instead.")
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Small problems and short budgets only.")] = False,
    markdown: Markdown = False,
    budget: Annotated[float, typer.Option(min=0.1, help="Seconds for each peer and problem.")] = 5.0,
    seeds: Annotated[int, typer.Option(min=1, help="Runs of each searcher, sharing its budget.")] = 5,
    runs: Annotated[int, typer.Option(min=1, help="Runs of each published budget.")] = 20,
) -> None:
    """Time to proof, quality and success rate of the selection beside named peers (the extra `bench`)."""
    from service.bench.selection.selection import Bench, bench_selection

    bench = Bench(markdown=markdown, quick=quick, budget_s=budget, seeds=seeds, runs=runs)
    raise SystemExit(0 if bench_selection(bench, as_published=as_published) else 1)


@app.command()
def frontier(
    quick: Annotated[bool, typer.Option("--quick", help="A few sizes only.")] = False,
    markdown: Markdown = False,
    budget: Annotated[float, typer.Option(min=0.1, help="Processor seconds for each problem.")] = 10.0,
    beside: Annotated[bool, typer.Option("--beside", help="Named peers too (the extra `bench`).")] = False,
) -> None:
    """What is proved within a processor time as masses, holes, kinds, planes and sensors grow."""
    from service.bench.selection.frontier import bench_frontier

    bench_frontier(budget_s=budget, quick=quick, markdown=markdown, beside=beside)


@app.command()
def arrangement(
    quick: Annotated[bool, typer.Option("--quick", help="Small problems only.")] = False,
    markdown: Markdown = False,
    budget: Annotated[float, typer.Option(min=0.05, help="Seconds for each peer and problem.")] = 1.0,
    seeds: Annotated[int, typer.Option(min=1, help="Generated problems of each size.")] = 1,
    write: Annotated[Path | None, typer.Option(help="File for the problems with their best values.")] = None,
) -> None:
    """Proofs and times of arrangements of weighed parts beside named methods (CP-SAT: the extra `bench`)."""
    from service.bench.arrangement.arrangement import bench_arrangement

    right = bench_arrangement(quick=quick, markdown=markdown, budget_s=budget, seeds=seeds, write=write)
    raise SystemExit(0 if right else 1)


@app.command()
def can(
    markdown: Markdown = False,
    frames: Annotated[int, typer.Option(min=1000, help="Frames of the run at full speed.")] = 200_000,
    paced: Annotated[float, typer.Option(min=0.1, help="Seconds of the run at 8,000 frames/s.")] = 5.0,
) -> None:
    """From a CAN bus to the database, by the service itself and over a bridge, beside cantools' bare decode rate."""
    from service.bench.can.can import bench_can

    raise SystemExit(0 if bench_can(markdown=markdown, frames=frames, paced_s=paced) else 1)


@app.command()
def web(
    markdown: Markdown = False,
    sessions: Annotated[int, typer.Option(min=1, help="Sessions stored.")] = 1000,
    repeats: Annotated[int, typer.Option(min=5, help="Requests of each page.")] = 60,
) -> None:
    """Pages as the server renders them: time, weight, and whether they ask for anything from elsewhere."""
    from service.bench.web import bench_web

    raise SystemExit(0 if bench_web(stored=sessions, repeats=repeats, markdown=markdown) else 1)


@app.command()
def load(
    markdown: Markdown = False,
    postgresql: Annotated[
        str | None, typer.Option(help="An empty PostgreSQL (postgresql+psycopg://...); default: one started for it.")
    ] = None,
    rows: Annotated[int, typer.Option(min=2000, help="Readings sent in bulk.")] = 200_000,
    singles: Annotated[int, typer.Option(min=1, help="Readings that each of 8 clients sends one by one.")] = 250,
    plans: Annotated[int, typer.Option(min=1, help="Plans asked for.")] = 100,
    sessions: Annotated[int, typer.Option(min=0, help="Then fill up to so many sessions and measure again.")] = 0,
) -> None:
    """Readings and plans over HTTP into SQLite and PostgreSQL, beside an endpoint that does nothing."""
    from service.bench.load.load import Sizes, bench_load

    sizes = Sizes(rows=rows, singles=singles, plans=plans)
    raise SystemExit(0 if bench_load(sizes, markdown=markdown, postgresql=postgresql, sessions=sessions) else 1)


@app.command()
def designs(
    markdown: Markdown = False,
    seeds: Annotated[int, typer.Option(min=1, help="Seeds from which each default method starts.")] = 3,
    searches: Annotated[bool, typer.Option("--searches", help="Measure the published searches as well.")] = False,
) -> None:
    """Published designs evaluated again beside the optimum and its proof; speed; rates of the published searches."""
    from service.bench.designs import bench_designs

    raise SystemExit(0 if bench_designs(markdown=markdown, seeds=seeds, searches=searches) else 1)


@app.command()
def trust(
    markdown: Markdown = False,
    sessions: Annotated[int, typer.Option(min=1, help="Sessions of each rotor and set of errors.")] = 2000,
    rotors: Annotated[str, typer.Option(help="Rotors, by letter, with commas between.")] = "a,a-stiff,b,c,d,e",
) -> None:
    """How often what is stated is true: intervals beside rotors that share no code with the product."""
    from service.bench.trust.table import bench_trust

    raise SystemExit(0 if bench_trust(sessions, rotors.split(","), markdown=markdown) else 1)
