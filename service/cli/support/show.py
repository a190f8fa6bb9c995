"""Tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.table import Table


def heading(console: Console, text: str) -> None:
    """A line that begins a part."""
    console.print(f"\n[bold]{text}[/bold]", soft_wrap=True)


def before_after(console: Console, lines: Iterable[dict[str, Any]]) -> None:
    """Each sensor before and after, with its limit."""
    table = Table("sensor", "before", "after", "down by", "limit", "unit", title="Before and after (1x)")
    for line in lines:
        table.add_row(
            line["sensor"],
            f"{line['before']:.3f}",
            _number(line["after"], ".3f"),
            "-" if line["reduction"] is None else f"{100 * line['reduction']:.1f} %",
            _number(line["limit"], ".3g"),
            line["unit"],
        )
    console.print(table)


def placements(console: Console, pieces: Iterable[dict[str, Any]], title: str = "Masses and holes") -> None:
    """Which mass goes into which hole."""
    table = Table("plane", "hole", "position", "mass", title=title)
    for piece in pieces:
        table.add_row(piece["plane"], piece["hole"], f"{piece['position_deg']:g} deg", f"{piece['mass_g']:g} g")
    console.print(table)


def field_experiment(console: Console, lines: Iterable[dict[str, Any]]) -> None:
    """The published experiment: what remains for 1, 2 and 3 masses a plane."""
    heading(console, "Published field experiment: balancer's answer 170.2 g @ 70 deg, 292.2 g @ 113 deg")
    table = Table("masses a plane", "unbalance missed / radius", "proof", "masses @ positions")
    for line in lines:
        where = ", ".join(f"{p['plane']}: {p['mass_g']:g} g @ {p['position_deg']:g} deg" for p in line["placements"])
        table.add_row(str(line["max_masses_per_plane"]), f"{line['residual_g']:.3f} g", line["status"], where)
    console.print(table)


def ending(console: Console, result: dict[str, Any]) -> None:
    """How it ended and where it is stored."""
    down = ", ".join(f"{sensor} {100 * share:.1f} %" for sensor, share in result["reductions"].items())
    console.print(f"\nDown by {down} after {result['trims']} trim(s); {result['seconds']:.1f} s.", soft_wrap=True)
    if any(line["within_limit"] is False for line in result["before_after"]):
        console.print("A bearing is still outside its limit: trim again, or look for another cause than unbalance.")
    console.print(f"Session {result['session_id']} is stored in {result['database']}", soft_wrap=True)


def corrections(console: Console, masses: Iterable[dict[str, Any]]) -> None:
    """Continuous correction masses."""
    table = Table("plane", "mass", "angle", "unbalance", title="Corrections: total on the as-found rotor")
    for mass in masses:
        table.add_row(
            mass["plane"],
            f"{mass['mass_g']:.2f} g",
            f"{mass['angle_deg']:.2f} deg",
            f"{mass['unbalance_gmm']:.0f} g.mm",
        )
    console.print(table)


def _number(value: float | None, style: str) -> str:
    return "-" if value is None else format(value, style)
