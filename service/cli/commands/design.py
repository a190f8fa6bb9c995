"""`drumtrue design`: design studies from files, without a server."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from service.messages import Message

if TYPE_CHECKING:
    from service.design.optimising import Outcome
    from service.design.study import LimitCheck, Simulation
    from service.design.verdict import Verdict
    from service.optimize.search import Evidence

app = typer.Typer(help="Design studies: linkages, flywheels, gears and shaft sets.", no_args_is_help=True)

DesignFile = Annotated[str, typer.Argument(metavar="FILE", help="A design file (TOML or JSON), or a preset's name.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]
Seed = Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which starts.")]
TimeLimit = Annotated[float, typer.Option(min=0.1, max=3600.0, help="Seconds after which the best so far is given.")]


def document_of(file: str) -> dict[str, Any]:
    """The document of a file, or of a preset. Raises RefusedDesign or InvalidInput."""
    from service.design.documents import preset, presets, read_document
    from service.errors import InvalidInput

    if file in presets():
        return preset(file)
    try:
        return read_document(Path(file).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as wrong:
        raise InvalidInput(
            Message("design_file_unreadable", presets=presets(), file=file, reason=wrong), field="FILE", value=file
        ) from wrong


@app.command("list")
def list_(as_json: AsJson = False) -> None:
    """List the published systems that the product brings as presets."""
    from service.design.documents import preset, presets

    rows = [(name, preset(name)) for name in presets()]
    if as_json:
        print(json.dumps([{"name": name, "study": doc["study"], "title": doc["title"]} for name, doc in rows]))
        return
    for name, doc in rows:
        print(f"{name:24} {doc['study']:12} {doc['title']}")


@app.command()
def show(name: Annotated[str, typer.Argument(help="Name of a preset.")]) -> None:
    """Print a preset as a design file, to be changed and used."""
    from service.design.documents import preset_text

    print(preset_text(name), end="")


@app.command()
def check(file: DesignFile, as_json: AsJson = False) -> None:
    """Say everything that is wrong with a design file; ends with status 1 where it is refused."""
    from service.design.registry import check as check_document

    found = check_document(document_of(file))
    if as_json:
        fields = ("code", "severity", "field", "message", "advice")
        print(json.dumps([{name: getattr(one, name) for name in fields} for one in found], indent=2))
    else:
        for one in found:
            print(f"{one.severity}: {one.message}\n  what to do: {one.advice}")
        if not found:
            print("no problem found")
    raise SystemExit(1 if any(one.severity == "refusal" for one in found) else 0)


@app.command()
def evaluate(file: DesignFile, as_json: AsJson = False) -> None:
    """Compute what the design of a file does, and which limits it breaks."""
    from service.design.registry import study_of

    document = document_of(file)
    simulation = study_of(document).simulate(document)
    units = document.get("units", {})
    if as_json:
        print(json.dumps(_plain(simulation), indent=2))
        return
    print_simulation(simulation, units)


@app.command()
def optimise(
    file: DesignFile,
    method: Annotated[str | None, typer.Option(help="Such as sqp, de_standard, jaya; default: the best known.")] = None,
    seed: Seed = 1,
    steps: Annotated[int | None, typer.Option(min=1, max=100_000, help="Starts, or generations.")] = None,
    time_limit: TimeLimit = 60.0,
    output: Annotated[Path | None, typer.Option(help="Write the design found as a file, JSON.")] = None,
    seeds: Annotated[int, typer.Option(min=1, max=10_000, help="Independent searches; the best one is shown.")] = 1,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes for them; default: all cores.")] = None,
    cluster: Annotated[str | None, typer.Option(help="Address of a Dask scheduler to run them on.")] = None,
    as_json: AsJson = False,
) -> None:
    """Find the best design within the limits of a file, with what speaks for it."""
    from service.cli.support.files import writing

    document = document_of(file)
    found = _best(document, method, range(seed, seed + seeds), steps, time_limit, workers, cluster)
    if output is not None:
        with writing(output, "design"):
            output.write_text(json.dumps(found.document, indent=2), encoding="utf-8")
    if as_json:
        print(json.dumps(_plain_outcome(found), indent=2))
    else:
        _print_outcome(found, document.get("units", {}))
    raise SystemExit(0 if found.result.feasible else 1)


def _best(
    document: dict[str, Any],
    method: str | None,
    seeds: range,
    steps: int | None,
    time_limit: float,
    workers: int | None,
    cluster: str | None,
) -> Outcome:
    """The best of several searches; one alone is run here."""
    from service.batch.designs import agreeing, best_of, optimise_seeds
    from service.batch.executors import executor

    with executor(1 if len(seeds) == 1 and cluster is None else workers, cluster) as place:
        found = list(optimise_seeds(place, document, seeds, method, steps, time_limit))
    if len(seeds) > 1:
        print(f"{agreeing(found)} of {len(seeds)} searches ended in the best", file=sys.stderr)
    return best_of(found).outcome


@app.command()
def front(
    file: DesignFile,
    points: Annotated[int, typer.Option(min=2, max=500, help="Points along the front.")] = 30,
    seed: Seed = 1,
    ceiling: Annotated[float | None, typer.Option(help="Greatest second response of interest, as it is shown.")] = None,
    time_limit: TimeLimit = 120.0,
    as_json: AsJson = False,
) -> None:
    """Trade two responses off against each other: designs that no other beats in both."""
    from service.design.optimising import front as run

    document = document_of(file)
    top = float("inf") if ceiling is None else ceiling
    found = run(document, points, seed, ceiling=top, clock=time.monotonic, deadline_s=time_limit)
    if as_json:
        rows = [
            {"objectives": pair.tolist(), "design": one}
            for pair, one in zip(found.objectives, (doc.get("design") for doc in found.documents), strict=True)
        ]
        print(json.dumps({"names": found.names, "complete": found.complete, "points": rows}, indent=2))
        return
    print(f"{found.names[0]:>24} {found.names[1]:>24}")
    for pair in found.objectives:
        print(f"{pair[0]:24.8g} {pair[1]:24.8g}")
    if not found.complete:
        print("not complete: the time limit was reached")


@app.command()
def verdict(
    file: DesignFile,
    seed: Seed = 1,
    steps: Annotated[int | None, typer.Option(min=1, max=100_000, help="Starts of the optimum.")] = None,
    as_json: AsJson = False,
) -> None:
    """Evaluate the published designs of a file again: what they do, what they break, and the honest optimum."""
    from service.design.units import shown, unit_of
    from service.design.verdict import verdict as judge

    document = document_of(file)
    units, found = document.get("units", {}), judge(document, seed, steps)
    if as_json:
        print(json.dumps(_plain_verdict(found), indent=2))
        return
    print(found.title)
    for one in found.designs:
        print(f"\n{one.name}")
        for claim in one.claims:
            claimed, computed = (shown(value, claim.quantity, units) for value in (claim.claimed, claim.computed))
            unit = unit_of(claim.quantity, units)
            print(f"  {claim.response}: published {claimed:.6g}, computed {computed:.6g} {unit}")
        for limit in one.broken:
            print(f"  {_broken(limit, units)}")
        best, quantity = one.optimum, one.optimum.quantity
        value, least = (shown(number, quantity, units) for number in (one.objective, best.value))
        print(f"  {best.objective}: {value:.8g}, optimum {least:.8g} {unit_of(quantity, units)}")
    print()
    _print_outcome(found.optimum, units)


@app.command()
def picture(
    file: DesignFile,
    kind: Annotated[
        str, typer.Option(help="linkage, hodograph, force, moment, section, stress, gears, bars or front.")
    ] = "",
    output: Annotated[Path | None, typer.Option(help="SVG file to write; default: FILE's name and the kind.")] = None,
    against: Annotated[str | None, typer.Option(help="A second file, drawn next to it as the present design.")] = None,
    points: Annotated[int, typer.Option(min=2, max=500, help="Points along a front.")] = 60,
    language: Annotated[str, typer.Option(help="Language of its texts, such as en or de.")] = "en",
) -> None:
    """Draw a design as an SVG file: the linkage over a turn, curves, a disc's section, a front."""
    from service.cli.support.design_pictures import drawn
    from service.cli.support.files import writing
    from service.web.pictures.svg import to_file

    document = document_of(file)
    before = None if against is None else document_of(against)
    chosen, found = drawn(document, before, kind, points, language)
    path = output or Path(f"{Path(file).stem}-{chosen}.svg")
    with writing(path, "picture"):
        path.write_text(to_file(found), encoding="utf-8")
    print(path)


def _plain_verdict(found: Verdict) -> dict[str, Any]:
    return {
        "title": found.title,
        "objective": found.objective,
        "optimum": _plain_outcome(found.optimum),
        "designs": [
            {
                "name": one.name,
                "claims": [
                    {"response": claim.response, "published": claim.claimed, "computed": claim.computed}
                    for claim in one.claims
                ],
                "broken": [_plain_limit(limit) for limit in one.broken],
                "objective": one.objective,
                "optimum": one.optimum.value,
            }
            for one in found.designs
        ],
    }


def _plain_outcome(found: Outcome) -> dict[str, Any]:
    result, evidence = found.result, found.evidence
    return {
        "method": found.method,
        "status": result.status,
        "objective": found.objective,
        "value": found.value,
        "feasible": result.feasible,
        "evidence": {name: getattr(evidence, name) for name in ("kind", "bound", "residual", "agreeing", "starts")},
        "evaluations": result.evaluations,
        "seconds": result.seconds,
        "seed": result.seed,
        "before": _plain(found.before),
        "after": _plain(found.after),
        "sensitivities": found.sensitivities,
        "document": found.document,
    }


def _print_outcome(found: Outcome, units: dict[str, str]) -> None:
    from service.design.units import shown, unit_of

    print(f"{found.method}: {found.result.status}, {_told(found.evidence)}")
    before = {one.name: one.value for one in found.before.scalars}
    print(f"{'':36} {'present':>14} {'optimum':>14}")
    for one in found.after.scalars:
        old, new = (shown(value, one.quantity, units) for value in (before.get(one.name, float("nan")), one.value))
        print(f"{one.name:36} {old:>14.8g} {new:>14.8g} {unit_of(one.quantity, units)}")
    for limit in found.after.limits:
        where = f" ({limit.where})" if limit.where else ""
        if limit.violated:
            print(_broken(limit, units))
        elif limit.active:
            print(f"held by {limit.code}{where}")
    for name, share in found.sensitivities.items():
        print(f"1 % more {name} changes {found.objective} by about {share:.3g} %")


def _told(evidence: Evidence) -> str:
    """What speaks for an answer, as text."""
    agreeing = f"{evidence.agreeing} of {evidence.starts} starts agree" if evidence.agreeing else ""
    if evidence.kind == "proved_bound":
        return f"proved: the bound is {evidence.bound:.9g}"
    if evidence.kind == "kkt":
        return f"{agreeing}, residual of the optimality conditions {evidence.residual:.1e}"
    return agreeing or "best found, without proof"


def _plain(simulation: Simulation) -> dict[str, Any]:
    """Numbers in SI."""
    return {
        "scalars": {one.name: one.value for one in simulation.scalars},
        "limits": [_plain_limit(one) for one in simulation.limits],
        "feasible": simulation.feasible,
        "warnings": [one.message for one in simulation.warnings],
    }


def _plain_limit(one: LimitCheck) -> dict[str, Any]:
    names = ("code", "where", "value", "limit", "sense", "violated", "active")
    return {name: getattr(one, name) for name in names}


def _broken(limit: LimitCheck, units: dict[str, str]) -> str:
    from service.design.units import shown, unit_of

    where = f" ({limit.where})" if limit.where else ""
    value, bound = (shown(number, limit.quantity, units) for number in (limit.value, limit.limit))
    return f"breaks {limit.code}{where}: {value:.6g} against {bound:.6g} {unit_of(limit.quantity, units)}"


def print_simulation(simulation: Simulation, units: dict[str, str]) -> None:
    """Print responses in the document's units, then broken limits and warnings."""
    from service.design.units import shown, unit_of

    for one in simulation.scalars:
        print(f"{one.name:36} {shown(one.value, one.quantity, units):>14.8g} {unit_of(one.quantity, units)}")
    broken = [one for one in simulation.limits if one.violated]
    for limit in broken:
        print(_broken(limit, units))
    if not broken:
        print(f"within all {len(simulation.limits)} limits")
    for warning in simulation.warnings:
        print(f"warning: {warning.message}")
