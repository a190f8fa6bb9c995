"""Processor time of commands in fresh processes, beside the bare imports of what they are built on."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.request import urlopen

from rich.console import Console

from service.bench.timing import show

NUMPY, SERVICE = "numpy", "fastapi, sqlalchemy, uvicorn, numpy"
MAX_SOLVE, MAX_SERVE = 4.0, 1.8
"""Bounds of `solve FILE` and of `serve`, as multiples of their bare imports."""
HEADER = ("command", "s", "bare imports", "s", "ratio", "at most")


@dataclass(frozen=True)
class _Command:
    """A command and the bare imports it is compared with; a service runs to its first answered /health."""

    shown: str
    arguments: tuple[str, ...]
    beside: str
    most: float | None = None
    serves: bool = False


def bench_start(*, repeats: int, markdown: bool) -> bool:
    """Print the table; returns whether every bound is kept."""
    with tempfile.TemporaryDirectory(prefix="drumtrue-start-") as folder:
        commands = _commands(Path(folder))
        taken: dict[str, list[float]] = {}
        for turn in range(repeats + 1):
            for bare in (NUMPY, SERVICE):
                _add(taken, bare, _run((sys.executable, "-c", f"import {bare}")), turn)
            for one in commands:
                _add(taken, one.shown, _served(one) if one.serves else _run(_program(one)), turn)
                with contextlib.suppress(FileNotFoundError):
                    (Path(folder) / "new.db").unlink()
    middle = {name: statistics.median(times) for name, times in taken.items()}
    ratios = {one.shown: middle[one.shown] / middle[one.beside] for one in commands}
    lines = [
        (
            one.shown,
            f"{middle[one.shown]:.2f}",
            one.beside,
            f"{middle[one.beside]:.2f}",
            f"{ratios[one.shown]:.2f}",
            "" if one.most is None else f"{one.most:g}",
        )
        for one in commands
    ]
    show(Console(), f"Processor time of a start, median of {repeats}", HEADER, lines, markdown=markdown)
    return all(one.most is None or ratios[one.shown] <= one.most for one in commands)


def _add(taken: dict[str, list[float]], name: str, seconds: float, turn: int) -> None:
    """Keep a time; the first turn only compiles."""
    if turn:
        taken.setdefault(name, []).append(seconds)


def _commands(folder: Path) -> tuple[_Command, ...]:
    log = folder / "log.json"
    log.write_text(json.dumps(_log()))
    stored, new = (("--database-url", f"sqlite:///{folder / name}") for name in ("stored.db", "new.db"))
    _run(_program(_Command("", ("migrate", *stored), NUMPY)))
    serve = ("serve", "--port", "0")
    return (
        _Command("--help", ("--help",), NUMPY),
        _Command("solve FILE", ("solve", str(log)), NUMPY, MAX_SOLVE),
        _Command("serve, to the first /health", (*serve, *stored), SERVICE, MAX_SERVE, serves=True),
        _Command("serve, on a new database", (*serve, *new), SERVICE, serves=True),
        _Command("verify", ("verify", *stored), SERVICE),
        _Command("token list", ("token", "list", *stored), SERVICE),
    )


def _program(one: _Command) -> tuple[str, ...]:
    return (sys.executable, "-m", "service", *one.arguments)


def _environment() -> Mapping[str, str]:
    """The environment of the processes: modules are compiled once, whatever ours says."""
    return {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"} | {"PYTHONUNBUFFERED": "1"}


def _run(command: Sequence[str]) -> float:
    """Processor time of a process to its end, s. Raises RuntimeError where it fails."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=_environment())  # noqa: S603
    assert process.stderr is not None  # noqa: S101
    said = process.stderr.read()
    seconds, status = _ended(process)
    if status:
        raise RuntimeError(f"{' '.join(command)} ended with status {status}: {said.decode(errors='replace')[-500:]}")
    return seconds


def _served(one: _Command) -> float:
    """Processor time of a service from its start to its first answer, s."""
    process = subprocess.Popen(  # noqa: S603
        _program(one), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=_environment()
    )
    assert process.stdout is not None  # noqa: S101
    address = next(word for word in process.stdout.readline().split() if word.startswith("http://"))
    with urlopen(f"{address}/health", timeout=60) as answer:  # noqa: S310
        healthy = answer.status == 200
    process.send_signal(signal.SIGKILL)  # at once: what it does after its answer is not asked for
    seconds, _status = _ended(process)
    if not healthy:
        raise RuntimeError("the service is not well")
    return seconds


def _ended(process: subprocess.Popen[bytes] | subprocess.Popen[str]) -> tuple[float, int]:
    _pid, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    for stream in (process.stdout, process.stderr):
        if stream is not None:
            stream.close()
    return used.ru_utime + used.ru_stime, process.returncode


def _log() -> dict[str, object]:
    """A session as a technician has it: two planes of 18 holes, six kinds of stock masses, three runs."""
    holes = [20.0 * hole for hole in range(18)]
    readings = {
        "initial": ((3.109, 40.1), (4.785, 120.3)),
        "trial": ((5.73, 30.0), (4.60, 113.0)),
        "trial ": ((3.96, 44.8), (8.07, 107.0)),
    }
    masses: dict[str, list[dict[str, object]]] = {
        "initial": [],
        "trial": [{"plane": "1", "mass_g": 200.0, "angle_deg": 0.0}],
        "trial ": [{"plane": "2", "mass_g": 200.0, "angle_deg": 80.0}],
    }
    return {
        "machine": {
            "name": "drum",
            "service_speed_rpm": 460.0,
            "vibration_limit_mm_s": 0.7,
            "planes": [
                {"name": name, "radius_mm": 330.0, "positions_deg": holes, "masses_per_position": 1, "max_masses": 3}
                for name in ("1", "2")
            ],
            "sensors": [{"name": "P"}, {"name": "Q"}],
        },
        "catalogue": {
            "name": "box",
            "items": [{"mass_g": mass, "count": 10} for mass in (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)],
        },
        "runs": [
            {
                "kind": kind.strip(),
                "masses": masses[kind],
                "readings": [
                    {"sensor": sensor, "amplitude": amplitude, "phase_deg": phase, "scatter": 0.01}
                    for sensor, (amplitude, phase) in zip(("P", "Q"), both, strict=True)
                ],
            }
            for kind, both in readings.items()
        ],
    }
