"""`drumtrue bench NAME`; one sub-command a measurement."""

from __future__ import annotations

from typing import Annotated

import typer

app = typer.Typer(help="Measure against named peers and limits, in one run.", no_args_is_help=True)

Markdown = Annotated[bool, typer.Option("--markdown", help="Print Markdown, for the README.")]


@app.command()
def fit(markdown: Markdown = False) -> None:
    """Fit, correction and diagnostics beside numpy's bare least squares."""
    from service.bench.fit import bench_fit

    raise SystemExit(0 if bench_fit(markdown=markdown) else 1)
