"""`drumtrue solve`: one session log in, corrections and plans out."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from service.cli.support import show
from service.cli.support.log_files import one_log
from service.engine.logs.replay import Resolved, resolve
from service.model.base import to_plain


def solve_file(file: Path, session: str | None, *, as_json: bool) -> None:
    """Print the answers of a log; session: which, of a file with several. Raises as `log_files.one_log` does."""
    resolved = resolve(one_log(file, session))
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
