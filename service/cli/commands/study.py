"""`drumtrue study` and where long work runs."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.support.options import OneSession

if TYPE_CHECKING:
    from service.batch.studies import Study

Workers = Annotated[
    int | None, typer.Option(min=1, max=256, help="Processes of this machine for long work; default: one a core.")
]
Cluster = Annotated[
    str | None,
    typer.Option(envvar="DRUMTRUE_CLUSTER", help="Dask scheduler for long work instead, such as tcp://HOST:8786."),
]


def study(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A session log, or an export of some.")],
    session: OneSession = None,
    draws: Annotated[int, typer.Option(min=1, max=1_000_000, help="How often the session is solved again.")] = 200,
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which draws.")] = 1,
    scatter: Annotated[
        float | None, typer.Option(min=0.0, max=1.0, help="Scatter of readings that state none, part of the amplitude.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")] = False,
    workers: Workers = None,
    cluster: Cluster = None,
) -> None:
    """Say how sure a session's answer is: solve it again with its readings drawn anew within their scatter."""
    from service.batch.studies import study as run
    from service.cli.support.log_files import one_log

    def say(done: int) -> None:
        if sys.stdout.isatty() and not as_json:
            print(f"\r{done}/{draws}", end="", flush=True)

    found = run(one_log(file, session), draws, seed, scatter=scatter, workers=workers, cluster=cluster, progress=say)
    if as_json:
        print(json.dumps(asdict(found), indent=2))
        return
    if sys.stdout.isatty():
        print()
    _tell(found)


def _tell(found: Study) -> None:
    print(f"{found.draws} draws, {found.answered} with an answer")
    for one in found.masses:
        print(f"correction mass in {one.name}: {one.median:.1f} g (90 %: {one.low:.1f} to {one.high:.1f})")
    for one in found.predicted:
        print(f"vibration left at sensor {one.name}: {one.median:.3g} (90 %: {one.low:.3g} to {one.high:.3g})")
    if found.same is not None:
        print(f"the same masses in the same holes: {100 * found.same:.0f} % of the draws")
    if found.within is not None:
        print(f"the plan keeps every sensor within its limit: {100 * found.within:.0f} % probable")
    if found.best is not None:
        print(f"no other selection does better: {100 * found.best:.0f} % probable")
    for reason, count in found.refused:
        print(f"no answer, {count} times: {reason}")
