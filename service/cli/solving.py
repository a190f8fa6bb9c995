"""`drumtrue solve`: one session log in, corrections and plans out."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from db.documents.base import to_plain
from service.cli import show
from service.errors import InvalidInput
from service.usecases.resolving import Resolved, read_log, resolve

MOST_BYTES = 50_000_000


def solve_file(file: Path, *, as_json: bool) -> None:
    """Print the answers of a log. Raises InvalidInput where it is none."""
    if file.stat().st_size > MOST_BYTES:
        raise InvalidInput(
            f"{file} has {file.stat().st_size} bytes; a session log has {MOST_BYTES} at most",
            advice="give the log of one session",
        )
    resolved = resolve(read_log(file.read_bytes()))
    if as_json:
        print(json.dumps(to_plain(resolved), indent=2))
        return
    _show(Console(highlight=False), resolved)


def _show(console: Console, resolved: Resolved) -> None:
    answers = to_plain(resolved)
    for correction in answers["corrections"]:
        show.heading(console, f"Correction {correction['number']}, from {correction['request']['source']}")
        show.corrections(console, correction["corrections"])
    for plan in answers["plans"]:
        show.heading(console, f"Plan {plan['number']}: {plan['status']}, {plan['message']}")
        if plan["reason"]:
            console.print(f"  {plan['reason']}", soft_wrap=True)
        else:
            show.placements(console, plan["placements"])
            console.print(f"  {plan['request']['objective']} {plan['objective_value']:.6g} {plan['objective_unit']}")
    for line in resolved.changed:
        console.print(f"not the answer of the log: {line}", soft_wrap=True)
