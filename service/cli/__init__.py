"""The command `drumtrue`. Each command imports what it needs when it runs, so that `--help` is quick."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands import arrange, bench, chaos, database, design, drafts, readings, study, token
from service.cli.support import can_options
from service.cli.support.options import DatabaseUrl, OneSession
from service.errors import DrumtrueError

# Matrices here are small, and solves run side by side: threads of the linear algebra only wait for one another.
# On two busy cores they took ten times the processor time. Set before numpy is imported; a user's own choice stays.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

YOUNG_OBJECTS = 50_000
"""What a start loads stays: with the usual 700 it would be looked through for garbage again and again."""

app = typer.Typer(
    name="drumtrue",
    help="Field balancing: which stock masses to bolt into which holes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

app.add_typer(bench.app, name="bench")
app.add_typer(design.app, name="design")
app.add_typer(token.app, name="token")


def main() -> None:
    """Run the command line; a deliberate error is told as text and ends with status 1."""
    from drivers.errors import DriverError

    gc.set_threshold(YOUNG_OBJECTS, 20, 100)
    atexit.register(gc.freeze)  # nor is it looked through at the end
    # Databases, spools and backups hold a customer's records and the digests of tokens.
    os.umask(os.umask(0o077) | 0o077)
    try:
        app()
    except DrumtrueError as error:
        _tell(error.message, error.advice)
    except DriverError as error:
        _tell(str(error), None)
    except Exception as error:
        _tell_of_database(error)
        raise


def _tell_of_database(error: Exception) -> None:
    """Tell in the engine's own words that it failed amidst a command: a damaged file, a lost link, a full disk."""
    from sqlalchemy.exc import DatabaseError, OperationalError

    if type(error) in (DatabaseError, OperationalError):
        reason = getattr(error, "orig", error)
        _tell(f"the database failed: {reason}", "see that it can be reached; restore a damaged one from a backup")


def _tell(message: str, advice: str | None) -> None:
    print(f"drumtrue: {message}", file=sys.stderr)
    if advice:
        print(f"  what to do: {advice}", file=sys.stderr)
    raise SystemExit(1)


@app.command()
def demo(
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which drum, and which scatter of its readings.")] = 1,
    speed: Annotated[float, typer.Option(min=60.0, max=6000.0, help="Speed of the drum, r/min.")] = 460.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")] = False,
    serve_on: Annotated[bool, typer.Option("--serve", help="Leave the service running until Ctrl-C.")] = False,
    parts: Annotated[bool, typer.Option("--parts", help="Arrange the drum's weighed bars, then trim.")] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """Balance a simulated drum through the real service, then match the published field experiment.

    Ends with status 0 when every bearing is down by 90 %.
    """
    if parts:
        from service.cli.commands.demo_parts import run_parts_demo

        raise SystemExit(run_parts_demo(seed=seed, speed_rpm=speed, as_json=as_json, database_url=database_url))
    from service.cli.commands.demo import run_demo

    raise SystemExit(run_demo(seed=seed, speed_rpm=speed, as_json=as_json, serve=serve_on, database_url=database_url))


@app.command()
def serve(
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 takes a free one.")] = 8000,
    database_url: DatabaseUrl = None,
    can: can_options.Bus = "",
    mapping: can_options.MappingFile = None,
    source: Annotated[str, typer.Option(help="Name of the source that is read from the bus.")] = "can",
    sensors: can_options.Sensors = "P,Q",
    planes: can_options.Planes = "1,2",
    j1939: can_options.J1939 = False,
    trust_proxy: Annotated[
        str | None,
        typer.Option(
            envvar="DRUMTRUE_TRUSTED_PROXIES",
            help="Addresses or networks of proxies whose X-Forwarded-For and -Proto are believed, commas between.",
        ),
    ] = None,
    log_format: Annotated[
        str, typer.Option(envvar="DRUMTRUE_LOG_FORMAT", help="text, or json: one object a line, requests too.")
    ] = "text",
    spool: can_options.SpoolFile = None,
    max_spool_mb: can_options.SpoolSize = 256,
    solves: Annotated[
        int | None,
        typer.Option(min=1, envvar="DRUMTRUE_SOLVES", help="Selections computed at once; default: one a core."),
    ] = None,
    retain_days: Annotated[
        int | None,
        typer.Option(
            min=1, envvar="DRUMTRUE_RETAIN_DAYS", help="Roll up raw readings older than this, daily; default: never."
        ),
    ] = None,
    max_ahead_s: Annotated[
        float,
        typer.Option(min=1.0, help="Readings dated further ahead of their receipt are set apart, s."),
    ] = 60.0,
) -> None:
    """Serve the API; an empty or older SQLite file is migrated first. With --can, read a balancer's bus as well."""
    from service.cli.commands.serve import serve_until_stopped
    from service.settings import Settings

    ear = None
    if can:
        from service.cli.commands.bridge import bus_choice
        from service.cli.commands.can_listener import CanListener

        bus = bus_choice(can, mapping, sensors, planes, j1939=j1939)
        ear = CanListener(bus, source, spool, max_spool_mb * 1024 * 1024)
    if log_format not in ("text", "json"):
        raise typer.BadParameter(f"{log_format!r} is no format; use text or json", param_hint="--log-format")
    settings = Settings.from_environment(database_url=database_url)
    settings = replace(settings, solves=solves, retain_days=retain_days, max_ahead_s=max_ahead_s)
    if trust_proxy is not None:
        settings = replace(settings, trusted_proxies=trust_proxy)
    serve_until_stopped(host, port, settings, ear, log_format)


@app.command()
def solve(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A session log, or an export of some.")],
    session: OneSession = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")] = False,
) -> None:
    """Compute the corrections and plans of one session log, without a server."""
    from service.cli.commands.solve import solve_file

    solve_file(file, session, as_json=as_json)


app.command()(arrange.arrange)
app.command()(database.migrate)
app.command()(database.verify)
app.command()(database.repair)
app.command()(database.backup)
app.command()(database.restore)
app.command()(database.retain)
app.command()(database.export)
app.command("import")(database.import_)
app.command()(readings.simulate)
app.command()(readings.bridge)
app.command()(readings.record)
app.command()(readings.check)
app.command()(drafts.layout)
app.command()(drafts.mapping)
app.command()(readings.replay)
app.command()(study.study)
app.command()(chaos.chaos)
app.command()(chaos.histories)
