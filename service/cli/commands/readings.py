"""The commands that make, carry, record and replay readings."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands.study import Cluster, Workers
from service.cli.support import can_options
from service.cli.support.options import TokenText


def _say(line: str) -> None:
    print(line, flush=True)


def simulate(
    url: Annotated[str, typer.Option(help="Service to send the readings to.")] = "http://127.0.0.1:8000",
    to: Annotated[str, typer.Option(help="Way out of the readings: http or can.")] = "http",
    can: can_options.Bus = "udp_multicast",
    mapping: can_options.MappingFile = None,
    j1939: can_options.J1939 = False,
    control: Annotated[str, typer.Option(help="HOST:PORT to bolt masses on and off, set speed and faults.")] = "",
    source: Annotated[str, typer.Option(help="Name of the source.")] = "sim",
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which drum, and which scatter.")] = 1,
    interval: Annotated[float, typer.Option(min=0.01, help="Seconds between readings.")] = 1.0,
    rounds: Annotated[int | None, typer.Option(min=1, help="Stop after so many readings of each sensor.")] = None,
    register: Annotated[
        bool | None,
        typer.Option(help="Create machine and box at the service and bind the source; default: with --to http."),
    ] = None,
    waveforms: can_options.Waveforms = False,
    token: TokenText = None,
) -> None:
    """Run a simulated drum that sends its readings to a service, or onto a CAN bus as a balancer does."""
    from service.cli.commands.simulate import out_to_can, out_to_http, simulate_until_stopped
    from service.cli.support.sources import Simulation

    if to not in ("http", "can"):
        raise typer.BadParameter(f"{to!r} is no way out; use http or can", param_hint="--to")
    out = out_to_http(url, token) if to == "http" else out_to_can(can, mapping, j1939=j1939)
    registered = to == "http" if register is None else register
    simulation = Simulation(seed, interval, waveforms)
    simulate_until_stopped(url if registered else None, token, out, control, source, simulation, rounds)


def bridge(
    url: Annotated[str, typer.Option(help="Service to send the readings to.")] = "http://127.0.0.1:8000",
    can: can_options.Bus = "",
    mapping: can_options.MappingFile = None,
    source: Annotated[str, typer.Option(help="Name of the source; bind it to a machine at the service.")] = "can",
    sensors: can_options.Sensors = "P,Q",
    planes: can_options.Planes = "1,2",
    j1939: can_options.J1939 = False,
    simulated: Annotated[bool, typer.Option("--simulated", help="Read a simulated drum instead of a bus.")] = False,
    replay: Annotated[Path | None, typer.Option(help="Read a recording or CAN log, at once and to its end.")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which simulated drum.")] = 1,
    interval: Annotated[float, typer.Option(min=0.0001, help="Seconds between its readings.")] = 1.0,
    waveforms: can_options.Waveforms = False,
    waveform: can_options.WaveformPath = None,
    layout: can_options.LayoutPath = None,
    started_at: can_options.StartedAt = None,
    spool: can_options.SpoolFile = None,
    max_spool_mb: can_options.SpoolSize = 256,
    status: Annotated[float, typer.Option(min=0.1, help="Seconds between status lines.")] = 10.0,
    send_again: Annotated[bool, typer.Option("--send-again", help="First send what was set aside before.")] = False,
    wait: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="A file: seconds to go on while the service is away or refuses; default: 60, and 0 where it refuses.",
        ),
    ] = None,
    token: TokenText = None,
) -> None:
    """Carry a balancer's readings from a CAN bus to a service, keeping them on disk until the service has them."""
    if [bool(can), simulated, replay is not None, waveform is not None].count(True) != 1:
        raise typer.BadParameter("name a bus, --simulated, or a file with --replay or --waveform", param_hint="--can")
    from service.cli.commands.bridge import BusChoice, bridge_until_stopped, bus_choice
    from service.cli.support.sources import Recorded, Simulation, StandIn, waveform_of

    read: BusChoice | StandIn
    if can:
        read = bus_choice(can, mapping, sensors, planes, j1939=j1939)
    elif waveform is not None:
        read = waveform_of(waveform, layout, started_at)
    elif replay is not None:
        messages = can_options.mapping_of(mapping, sensors, planes, j1939=j1939)
        read = Recorded(replay, messages, started_at)
    else:
        read = Simulation(seed, interval, waveforms)
    bridge_until_stopped(
        read,
        url=url,
        token=token,
        source=source,
        spool=spool,
        max_bytes=max_spool_mb * 1024 * 1024,
        status_s=status,
        send_again=send_again,
        wait_s=wait,
    )


def record(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="New file, JSON Lines of readings (.jsonl).")],
    can: can_options.Bus = "",
    mapping: can_options.MappingFile = None,
    source: Annotated[str, typer.Option(help="Name of the source.")] = "can",
    sensors: can_options.Sensors = "P,Q",
    j1939: can_options.J1939 = False,
    simulated: Annotated[bool, typer.Option("--simulated", help="Record a simulated drum instead of a bus.")] = False,
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Which simulated drum.")] = 1,
    interval: Annotated[float, typer.Option(min=0.0001, help="Seconds between its readings.")] = 1.0,
    waveforms: can_options.Waveforms = False,
    waveform: can_options.WaveformPath = None,
    layout: can_options.LayoutPath = None,
    started_at: can_options.StartedAt = None,
    count: Annotated[int | None, typer.Option(min=1, help="Stop after so many readings.")] = None,
) -> None:
    """Record a balancer's readings from a CAN bus into a file, or those of a waveform file or a simulated drum."""
    if [bool(can), simulated, waveform is not None].count(True) != 1:
        raise typer.BadParameter("name a bus, or --simulated, or a file with --waveform", param_hint="--can")
    from service.cli.commands.bridge import BusChoice, bus_choice
    from service.cli.commands.replay import record_until_stopped
    from service.cli.support.sources import Simulation, StandIn, waveform_of

    read: BusChoice | StandIn
    if can:
        read = bus_choice(can, mapping, sensors, "", j1939=j1939)
    else:
        read = waveform_of(waveform, layout, started_at) if waveform else Simulation(seed, interval, waveforms)
    record_until_stopped(file, read, source, count)


def check(
    path: Annotated[Path | None, typer.Argument(help="A CAN log of any kind; left out: the bus of --can.")] = None,
    can: can_options.Bus = "",
    mapping: can_options.MappingFile = None,
    sensors: can_options.Sensors = "P,Q",
    planes: can_options.Planes = "1,2",
    j1939: can_options.J1939 = False,
    frames: Annotated[int, typer.Option(min=0, help="Frames of mapped messages that are shown one by one.")] = 20,
    seconds: Annotated[float, typer.Option(min=0.1, help="How long the bus is listened to.")] = 10.0,
    started_at: can_options.StartedAt = None,
) -> None:
    """Decode a bus or a log by a mapping and show values and reasons of refusal; nothing is stored or sent.

    Ends with status 1 where it gives no reading.
    """
    if bool(can) == (path is not None):
        raise typer.BadParameter("name a log, or a bus with --can", param_hint="--can")
    from drivers.can.bus import parse_bus
    from service.cli.commands.check import check_bus, check_log
    from service.cli.support.signals import on_stop

    messages = can_options.mapping_of(mapping, sensors, planes, j1939=j1939)
    if path is not None:
        raise SystemExit(check_log(path, messages, frames, started_at))
    stop = threading.Event()
    on_stop(stop.set)
    raise SystemExit(check_bus(parse_bus(can), messages, frames, seconds, stop))


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
    can: can_options.Bus = "udp_multicast",
    mapping: can_options.MappingFile = None,
    sensors: can_options.Sensors = "P,Q",
    j1939: can_options.J1939 = False,
    source: Annotated[str | None, typer.Option(help="Name of the source; default: the file's.")] = None,
    speed: Annotated[float | None, typer.Option(min=0.001, help="Times as fast as it was; default: at once.")] = None,
    as_now: Annotated[bool, typer.Option("--as-now", help="Move the times so that the first is now.")] = False,
    keep_going: Annotated[bool, typer.Option("--keep-going", help="Pass over errors in the file.")] = False,
    layout: can_options.LayoutPath = None,
    started_at: can_options.StartedAt = None,
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
    from service.cli.commands.replay import replay_file
    from service.cli.support.sources import waveform_of

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
        started_at=started_at,
    )
