"""The command `drumtrue`. Each command imports what it needs when it runs, so that `--help` is quick."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from service.cli import batching, benching, canbus, chaotic, tokening
from service.cli.batching import Cluster, Workers
from service.errors import DrumtrueError

app = typer.Typer(
    name="drumtrue",
    help="Field balancing: which stock masses to bolt into which holes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

app.add_typer(benching.app, name="bench")
app.add_typer(tokening.app, name="token")
app.command()(batching.study)
app.command()(chaotic.chaos)

DatabaseUrl = Annotated[
    str | None,
    typer.Option(
        "--database-url",
        envvar="DRUMTRUE_DATABASE_URL",
        help="SQLite file (sqlite:///PATH) or PostgreSQL (postgresql+psycopg://...).",
    ),
]
TokenText = Annotated[
    str | None,
    typer.Option(
        "--token",
        envvar="DRUMTRUE_TOKEN",
        show_envvar=True,
        help="Token for the service, where it needs one; better in the environment, where other users do not see it.",
    ),
]


def main() -> None:
    """Run the command line; a deliberate error is told in words and ends with status 1."""
    from drivers.errors import DriverError

    try:
        app()
    except DrumtrueError as error:
        _tell(error.message, error.advice)
    except DriverError as error:
        _tell(str(error), None)


def _say(line: str) -> None:
    print(line, flush=True)


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
    database_url: DatabaseUrl = None,
) -> None:
    """Balance a simulated drum through the real service, then match the published field experiment.

    Ends with status 0 when every bearing is down by 90 %.
    """
    from service.cli.demo import run_demo

    raise SystemExit(run_demo(seed=seed, speed_rpm=speed, as_json=as_json, serve=serve_on, database_url=database_url))


@app.command()
def serve(
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 takes a free one.")] = 8000,
    database_url: DatabaseUrl = None,
    can: canbus.Bus = "",
    mapping: canbus.MappingFile = None,
    source: Annotated[str, typer.Option(help="Name of the source that is read from the bus.")] = "can",
    sensors: canbus.Sensors = "P,Q",
    planes: canbus.Planes = "1,2",
    j1939: canbus.J1939 = False,
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
    spool: canbus.SpoolFile = None,
    max_spool_mb: canbus.SpoolSize = 256,
) -> None:
    """Serve the API; an empty or older SQLite file is migrated first. With --can, read a balancer's bus as well."""
    from service.cli.serving import serve_until_stopped

    ear = None
    if can:
        from service.cli.bridging import bus_choice
        from service.cli.listening import Ear

        bus = bus_choice(can, mapping, sensors, planes, j1939=j1939)
        ear = Ear(bus, source, spool, max_spool_mb * 1024 * 1024)
    if log_format not in ("text", "json"):
        raise typer.BadParameter(f"{log_format!r} is no format; use text or json", param_hint="--log-format")
    serve_until_stopped(host, port, database_url, ear, trust_proxy, log_format)


@app.command()
def migrate(database_url: DatabaseUrl = None) -> None:
    """Bring the database's schema up to date, keeping the data."""
    from service import bootstrap
    from service.settings import Settings

    before, after = bootstrap.migrate_database(Settings.from_environment(database_url=database_url))
    print(f"schema {before or 'empty'} -> {after}" if before != after else f"schema {after}: up to date")


@app.command()
def verify(
    head: Annotated[
        str | None, typer.Option(help="NUMBER:HASH that an earlier check printed: shows that no end was cut off.")
    ] = None,
    database_url: DatabaseUrl = None,
) -> None:
    """Walk the hash chain of the history; say which session or entry was altered, removed or inserted (status 1)."""
    from service.cli.verifying import verify_history

    raise SystemExit(verify_history(database_url, head))


@app.command()
def backup(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="New file, an SQLite database whatever the engine.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Write all that is stored, as of one moment, to a file; the service may go on meanwhile."""
    from service.cli.storing import back_up_to

    back_up_to(file, database_url)


@app.command()
def restore(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A file that `drumtrue backup` wrote.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Put a backup into an empty database, of either engine."""
    from service.cli.storing import restore_from

    restore_from(file, database_url)


@app.command()
def retain(
    days: Annotated[int, typer.Option(min=1, help="Days for which raw readings are kept.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Roll up older raw readings, one row a source, sensor and minute; what runs took of them stays."""
    from service.cli.storing import retain_for

    retain_for(days, database_url)


@app.command()
def export(
    to: Annotated[Path, typer.Option("--to", dir_okay=False, help="New file, JSON Lines: a session log a line.")],
    session: Annotated[list[str] | None, typer.Argument(help="Identifiers of sessions.")] = None,
    every: Annotated[bool, typer.Option("--all", help="All sessions there are.")] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """Write sessions to a file that `import` stores elsewhere and, one session, `solve` solves again."""
    from service.cli.archiving import export_sessions

    if every == bool(session):
        raise typer.BadParameter("name sessions, or --all", param_hint="SESSION")
    export_sessions(session or [], to, database_url)


@app.command("import")
def import_(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A file that `drumtrue export` wrote.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Store the sessions of a file, all or none; machines and boxes are found by name or created, stock stays."""
    from service.cli.archiving import import_sessions

    import_sessions(file, database_url)


@app.command()
def solve(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="A session log, as GET /sessions/ID/log.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")] = False,
) -> None:
    """Compute the corrections and plans of one session log, without a server."""
    from service.cli.solving import solve_file

    solve_file(file, as_json=as_json)


@app.command()
def simulate(
    url: Annotated[str, typer.Option(help="Service to send the readings to.")] = "http://127.0.0.1:8000",
    to: Annotated[str, typer.Option(help="Way out of the readings: http or can.")] = "http",
    can: canbus.Bus = "udp_multicast",
    mapping: canbus.MappingFile = None,
    j1939: canbus.J1939 = False,
    control: Annotated[str, typer.Option(help="HOST:PORT to bolt masses on and off, set speed and faults.")] = "",
    source: Annotated[str, typer.Option(help="Name of the source.")] = "sim",
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which drum, and which scatter.")] = 1,
    interval: Annotated[float, typer.Option(min=0.01, help="Seconds between readings.")] = 1.0,
    rounds: Annotated[int | None, typer.Option(min=1, help="Stop after so many readings of each sensor.")] = None,
    register: Annotated[
        bool | None,
        typer.Option(help="Create machine and box at the service and bind the source; default: with --to http."),
    ] = None,
    waveforms: canbus.Waveforms = False,
    token: TokenText = None,
) -> None:
    """Run a simulated drum that sends its readings to a service, or onto a CAN bus as a balancer does."""
    from service.cli.simulating import out_to_can, out_to_http, simulate_until_stopped
    from service.cli.sources import Simulation

    if to not in ("http", "can"):
        raise typer.BadParameter(f"{to!r} is no way out; use http or can", param_hint="--to")
    out = out_to_http(url, token) if to == "http" else out_to_can(can, mapping, j1939=j1939)
    registered = to == "http" if register is None else register
    simulation = Simulation(seed, interval, waveforms)
    simulate_until_stopped(url if registered else None, token, out, control, source, simulation, rounds)


@app.command()
def bridge(
    url: Annotated[str, typer.Option(help="Service to send the readings to.")] = "http://127.0.0.1:8000",
    can: canbus.Bus = "",
    mapping: canbus.MappingFile = None,
    source: Annotated[str, typer.Option(help="Name of the source; bind it to a machine at the service.")] = "can",
    sensors: canbus.Sensors = "P,Q",
    planes: canbus.Planes = "1,2",
    j1939: canbus.J1939 = False,
    simulated: Annotated[bool, typer.Option("--simulated", help="Read a simulated drum instead of a bus.")] = False,
    replay: Annotated[Path | None, typer.Option(help="Read a recording instead, at once and to its end.")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which simulated drum.")] = 1,
    interval: Annotated[float, typer.Option(min=0.0001, help="Seconds between its readings.")] = 1.0,
    waveforms: canbus.Waveforms = False,
    waveform: canbus.WaveformPath = None,
    layout: canbus.LayoutPath = None,
    started_at: canbus.StartedAt = None,
    spool: canbus.SpoolFile = None,
    max_spool_mb: canbus.SpoolSize = 256,
    status: Annotated[float, typer.Option(min=0.1, help="Seconds between status lines.")] = 10.0,
    send_again: Annotated[bool, typer.Option("--send-again", help="First send what was set aside before.")] = False,
    token: TokenText = None,
) -> None:
    """Carry a balancer's readings from a CAN bus to a service, keeping them on disk until the service has them."""
    if [bool(can), simulated, replay is not None, waveform is not None].count(True) != 1:
        raise typer.BadParameter("name a bus, --simulated, or a file with --replay or --waveform", param_hint="--can")
    from service.cli.bridging import BusChoice, bridge_until_stopped, bus_choice
    from service.cli.sources import Simulation, StandIn, waveform_of

    read: BusChoice | StandIn
    if can:
        read = bus_choice(can, mapping, sensors, planes, j1939=j1939)
    elif waveform is not None:
        read = waveform_of(waveform, layout, started_at)
    else:
        read = replay or Simulation(seed, interval, waveforms)
    bridge_until_stopped(
        read,
        url=url,
        token=token,
        source=source,
        spool=spool,
        max_bytes=max_spool_mb * 1024 * 1024,
        status_s=status,
        send_again=send_again,
    )


@app.command()
def record(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="New file, JSON Lines of readings (.jsonl).")],
    can: canbus.Bus = "",
    mapping: canbus.MappingFile = None,
    source: Annotated[str, typer.Option(help="Name of the source.")] = "can",
    sensors: canbus.Sensors = "P,Q",
    j1939: canbus.J1939 = False,
    simulated: Annotated[bool, typer.Option("--simulated", help="Record a simulated drum instead of a bus.")] = False,
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which simulated drum.")] = 1,
    interval: Annotated[float, typer.Option(min=0.0001, help="Seconds between its readings.")] = 1.0,
    waveforms: canbus.Waveforms = False,
    waveform: canbus.WaveformPath = None,
    layout: canbus.LayoutPath = None,
    started_at: canbus.StartedAt = None,
    count: Annotated[int | None, typer.Option(min=1, help="Stop after so many readings.")] = None,
) -> None:
    """Record a balancer's readings from a CAN bus into a file, or those of a waveform file or a simulated drum."""
    if [bool(can), simulated, waveform is not None].count(True) != 1:
        raise typer.BadParameter("name a bus, or --simulated, or a file with --waveform", param_hint="--can")
    from service.cli.bridging import BusChoice, bus_choice
    from service.cli.replaying import record_until_stopped
    from service.cli.sources import Simulation, StandIn, waveform_of

    read: BusChoice | StandIn
    if can:
        read = bus_choice(can, mapping, sensors, "", j1939=j1939)
    else:
        read = waveform_of(waveform, layout, started_at) if waveform else Simulation(seed, interval, waveforms)
    record_until_stopped(file, read, source, count)


@app.command()
def replay(
    path: Annotated[Path, typer.Argument(exists=True, help="Recording, session log or CAN log; --compare: a folder.")],
    compare: Annotated[
        bool, typer.Option("--compare", help="Solve all session logs of a folder again and list what changed.")
    ] = False,
    tolerance: Annotated[
        float, typer.Option(min=0.0, help="--compare: relative difference that is none, of masses and vibration.")
    ] = 1e-6,
    workers: Workers = None,
    cluster: Cluster = None,
    to: Annotated[str, typer.Option(help="Way out of the readings: http or can.")] = "http",
    url: Annotated[str, typer.Option(help="Service to send the readings to.")] = "http://127.0.0.1:8000",
    can: canbus.Bus = "udp_multicast",
    mapping: canbus.MappingFile = None,
    sensors: canbus.Sensors = "P,Q",
    j1939: canbus.J1939 = False,
    source: Annotated[str | None, typer.Option(help="Name of the source; default: the file's.")] = None,
    speed: Annotated[float | None, typer.Option(min=0.001, help="Times as fast as it was; default: at once.")] = None,
    as_now: Annotated[bool, typer.Option("--as-now", help="Move the times so that the first is now.")] = False,
    keep_going: Annotated[bool, typer.Option("--keep-going", help="Pass over errors in the file.")] = False,
    layout: canbus.LayoutPath = None,
    started_at: canbus.StartedAt = None,
    token: TokenText = None,
) -> None:
    """Replay a log to a service or onto a CAN bus, or compare old sessions' answers with today's.

    With --layout the file is a waveform (CSV, WAV, UFF 58): measured, and its readings sent at once.
    """
    if to not in ("http", "can"):
        raise typer.BadParameter(f"{to!r} is no way out; use http or can", param_hint="--to")
    if compare != path.is_dir():
        raise typer.BadParameter("--compare takes a folder, a replay one file", param_hint="PATH")
    if compare:
        from service.batch.comparing import compare_folder, summary

        found = compare_folder(path, _say, tolerance=tolerance, workers=workers, cluster=cluster)
        print(summary(found))
        raise SystemExit(any(one.changed or one.error for one in found))
    from service.cli.replaying import replay_file
    from service.cli.sources import waveform_of

    if layout is not None and (as_now or speed is not None):
        raise typer.BadParameter("a waveform is read at once, at its own times", param_hint="--layout")
    replay_file(
        path if layout is None else waveform_of(path, layout, started_at),
        to=to,
        url=url,
        token=token,
        bus=can,
        mapping=mapping,
        sensors=sensors,
        j1939=j1939,
        source=source,
        speed=speed,
        as_now=as_now,
        keep_going=keep_going,
    )
