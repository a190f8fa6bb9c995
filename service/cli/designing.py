"""`drumtrue design`: design studies from files, without a server."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from service.design.study import Simulation

app = typer.Typer(help="Design studies: linkages, flywheels, gears and shaft sets.", no_args_is_help=True)

DesignFile = Annotated[str, typer.Argument(metavar="FILE", help="A design file (TOML or JSON), or a preset's name.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]


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
            f"FILE must be a readable design file or one of {', '.join(presets())}, got {file!r}: {wrong}",
            code="design_file_unreadable",
            field="FILE",
            value=file,
            advice="see `drumtrue design list`",
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


def _plain(simulation: Simulation) -> dict[str, Any]:
    """Numbers in SI."""
    return {
        "scalars": {one.name: one.value for one in simulation.scalars},
        "limits": [
            {
                "code": one.code,
                "where": one.where,
                "value": one.value,
                "limit": one.limit,
                "sense": one.sense,
                "violated": one.violated,
            }
            for one in simulation.limits
        ],
        "feasible": simulation.feasible,
        "warnings": [one.message for one in simulation.warnings],
    }


def print_simulation(simulation: Simulation, units: dict[str, str]) -> None:
    """Print responses in the document's units, then broken limits and warnings."""
    from service.design.units import shown, unit_of

    for one in simulation.scalars:
        print(f"{one.name:36} {shown(one.value, one.quantity, units):>14.8g} {unit_of(one.quantity, units)}")
    broken = [one for one in simulation.limits if one.violated]
    for limit in broken:
        unit = unit_of(limit.quantity, units)
        where = f" ({limit.where})" if limit.where else ""
        value, bound = (shown(number, limit.quantity, units) for number in (limit.value, limit.limit))
        print(f"breaks {limit.code}{where}: {value:.6g} against {bound:.6g} {unit}")
    if not broken:
        print(f"within all {len(simulation.limits)} limits")
    for warning in simulation.warnings:
        print(f"warning: {warning.message}")
