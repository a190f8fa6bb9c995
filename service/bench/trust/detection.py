"""How often a fault of one session is seen, and whether the right run is named: one fault a session, known which."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from service.bench.trust.cases import Case
from service.bench.trust.coverage import BOLTED, as_run, bolted, flat, machine_of, rounded
from service.bench.trust.world import ErrorSet, Piece, Seen, World
from service.engine.correction_solver import solve_correction
from service.errors import DrumtrueError
from service.messages import Message, Part
from service.model.correction import Correction, CorrectionRequest
from service.model.diagnostic import Diagnostic
from service.model.machine import Machine
from service.model.run import Run, RunKind

ERRORS = ErrorSet(within=0.004, repeat=0.01, **BOLTED)
"""What sound runs err by, in these sessions; of it only the scatter within a run is stated."""
BLAMING = ("bad_run", "prediction_missed", "one_of_runs_wrong", "runs_contradict", "not_linear", "sense_mirrored")
MAX_MORE_RUNS = 2
"""Further runs that are taken as advised."""


@dataclass
class Recorded:
    """A run as it was written down: kind, pieces as stated, what was read, and pieces as they were meant."""

    kind: RunKind
    pieces: tuple[Piece, ...]
    seen: Seen
    meant: tuple[Piece, ...] = ()


@dataclass(frozen=True)
class Injected:
    """A fault. culprits: numbers of the runs that are wrong, any of which may be named. spoil: what is written down.

    really: what is on the rotor instead of the pieces of a run.
    """

    name: str
    culprits: tuple[int, ...]
    spoil: Callable[[World, int, Recorded], Recorded] = lambda _world, _number, run: run
    really: Callable[[int, tuple[Piece, ...], list[Recorded]], tuple[Piece, ...]] = lambda _number, pieces, _before: (
        pieces
    )
    initials: int = 1


@dataclass
class Told:
    """Counts over sessions, and the gains: with the advice followed, and with the best single run left out."""

    sessions: int = 0
    before: int = 0
    said: int = 0
    right: int = 0
    listed: int = 0
    wrong: int = 0
    loss: list[float] = field(default_factory=list)


def detection(case: Case, fault: Injected, sessions: int, seed: int = 7) -> Told:
    """Sessions with a fault: whether it is said, and of which runs."""
    machine, told = machine_of(case, None), Told()
    for number in range(sessions):
        _one(World(case, ERRORS, np.random.default_rng([seed, number])), machine, fault, told)
    return told


def _one(world: World, machine: Machine, fault: Injected, told: Told) -> None:
    runs = _until_plan(world, machine, fault)
    told.sessions += 1
    try:
        first = _solved(machine, runs)
    except DrumtrueError:
        told.before += 1
        return
    told.before += bool(_blame(first) or any(one.code == "trial_response_small" for one in first.diagnostics))
    wanted = bolted(world, (), rounded(machine, first))
    _take(world, fault, runs, "check", wanted)
    second = _solved(machine, runs)
    blame = _blame(second)
    told.said += bool(blame)
    if blame and fault.culprits:
        named = {run for one in blame for run in one.runs}
        right = bool(named & set(fault.culprits)) or any(not one.runs for one in blame)
        told.right += right and len(named) == 1
        told.listed += right
        told.wrong += len(named) == 1 and not right
    best = max(_gain(world, machine, _without(runs, gone)) for gone in range(len(runs) + 1))
    told.loss.append(best - _advised(world, machine, fault, runs))


def _until_plan(world: World, machine: Machine, fault: Injected) -> list[Recorded]:
    runs: list[Recorded] = []
    for _ in range(fault.initials):
        _take(world, fault, runs, "initial", ())
    for plane in range(len(machine.planes)):
        angle = 2.0 * np.pi * round(24.0 * float(world.rng.random())) / 24.0
        _take(world, fault, runs, "trial", (world.piece(plane, world.case.trial_g * np.exp(1j * angle)),))
    return runs


def _take(world: World, fault: Injected, runs: list[Recorded], kind: RunKind, pieces: tuple[Piece, ...]) -> None:
    number = len(runs) + 1
    seen = world.run(fault.really(number, pieces, runs))
    runs.append(fault.spoil(world, number, Recorded(kind, pieces, seen, pieces)))


def _documents(machine: Machine, runs: Sequence[Recorded]) -> tuple[Run, ...]:
    return flat([as_run(machine, k, run.kind, run.pieces, run.seen) for k, run in enumerate(runs, start=1)])


def _solved(machine: Machine, runs: Sequence[Recorded]) -> Correction:
    return solve_correction(machine, _documents(machine, runs), (), CorrectionRequest(source="fit"), number=1, key="c")


def _blame(correction: Correction) -> list[Diagnostic]:
    return [one for one in correction.diagnostics if one.code in BLAMING]


def _without(runs: Sequence[Recorded], gone: int) -> list[Recorded]:
    return [run for k, run in enumerate(runs, start=1) if k != gone]


def _gain(world: World, machine: Machine, runs: Sequence[Recorded]) -> float:
    """True reduction, percent, by the masses that a fit of the runs asks for."""
    try:
        correction = _solved(machine, runs)
    except DrumtrueError:
        return -np.inf
    masses = np.array([c.mass_g * np.exp(1j * np.radians(c.angle_deg)) for c in correction.corrections])
    return 100.0 * (1.0 - float(np.linalg.norm(world.true(masses)) / np.linalg.norm(world.initial)))


def _advised(world: World, machine: Machine, fault: Injected, runs: list[Recorded]) -> float:
    """True reduction where the technician does what is said: further runs as asked for, the named runs left out."""
    taken, out = list(runs), set[int]()
    for _ in range(MAX_MORE_RUNS + 2):
        kept = [run for k, run in enumerate(taken, start=1) if k not in out]
        numbers = [k for k in range(1, len(taken) + 1) if k not in out]
        blame = sorted(_blame(_solved(machine, kept)), key=lambda one: BLAMING.index(one.code))
        if not blame:
            return _gain(world, machine, kept)
        named = [numbers[k - 1] for k in blame[0].runs]
        if _says(blame[0], "slip.sensors_swapped_from"):
            back = _swapped(min(named), max(named))
            taken = [back(world, k, run) for k, run in enumerate(taken, start=1)]
        elif len(named) == 1 or blame[0].code == "bad_run":
            out |= set(named)
        elif len(taken) < len(runs) + MAX_MORE_RUNS:
            _take(
                world,
                replace(fault, spoil=Injected("", ()).spoil, really=Injected("", ()).really),
                taken,
                *_asked(blame[0], kept),
            )
        else:
            break
        try:
            _solved(machine, [run for k, run in enumerate(taken, start=1) if k not in out])
        except DrumtrueError:
            return _gain(world, machine, kept)
    return _gain(world, machine, [run for k, run in enumerate(taken, start=1) if k not in out])


def _says(one: Diagnostic, slip: str) -> bool:
    """Whether a finding names this slip."""
    slips = one.data.parameters.get("slips", ()) if one.data is not None else ()
    return isinstance(slips, tuple) and any(isinstance(each, Message) and each.key == slip for each in slips)


def _asked(one: Diagnostic, runs: Sequence[Recorded]) -> tuple[RunKind, tuple[Piece, ...]]:
    """The further run that is asked for: as found, or with the masses of a run."""
    data = one.data
    wanted = data.parameters.get("next") if data is not None else None
    if one.code == "runs_contradict":
        return runs[one.runs[0] - 1].kind, runs[one.runs[0] - 1].meant
    if isinstance(wanted, Message) and wanted.key == "next_run.like":
        part = wanted.parameters["run"]
        assert isinstance(part, Part)  # noqa: S101
        return "trial", runs[part.number - 1].meant
    return "initial", ()


def _times(run: int, factor: complex, sensor: int | None = None) -> Callable[[World, int, Recorded], Recorded]:
    def spoil(_world: World, number: int, one: Recorded) -> Recorded:
        if number != run:
            return one
        v = one.seen.vibration.copy()
        v[slice(None) if sensor is None else sensor] *= factor
        return replace(one, seen=replace(one.seen, vibration=v))

    return spoil


def _swapped(first: int, last: int) -> Callable[[World, int, Recorded], Recorded]:
    def spoil(world: World, number: int, one: Recorded) -> Recorded:
        if not first <= number <= last:
            return one
        order = np.arange(len(one.seen.vibration))
        for k in range(0, len(order), len(world.case.probes)):
            order[[k, k + 1]] = order[[k + 1, k]]
        return replace(
            one, seen=replace(one.seen, vibration=one.seen.vibration[order], scatter=one.seen.scatter[order])
        )

    return spoil


def _typed(run: int, change: Callable[[complex], complex]) -> Callable[[World, int, Recorded], Recorded]:
    def spoil(_world: World, number: int, one: Recorded) -> Recorded:
        if number != run:
            return one
        return replace(one, pieces=tuple(replace(p, stated=change(p.stated)) for p in one.pieces))

    return spoil


def _lost(number: int, pieces: tuple[Piece, ...], _before: list[Recorded]) -> tuple[Piece, ...]:
    return () if number == 2 else pieces


def _left_in(number: int, pieces: tuple[Piece, ...], before: list[Recorded]) -> tuple[Piece, ...]:
    return (*pieces, *before[1].pieces) if number == 3 else pieces


def _largest(change: complex) -> Callable[[int, tuple[Piece, ...], list[Recorded]], tuple[Piece, ...]]:
    """The largest piece of the check run sits elsewhere, or was forgotten."""

    def really(number: int, pieces: tuple[Piece, ...], before: list[Recorded]) -> tuple[Piece, ...]:
        if len(before) < 3 or number != len(before) + 1 or len(pieces) < 2:
            return pieces
        worst = max(range(len(pieces)), key=lambda k: abs(pieces[k].stated))
        return tuple(replace(p, true=p.true * change) if k == worst else p for k, p in enumerate(pieces))

    return really


def _mirrored(_world: World, _number: int, one: Recorded) -> Recorded:
    return replace(one, pieces=tuple(replace(p, stated=np.conj(p.stated)) for p in one.pieces))


def _turned(deg: float) -> complex:
    return complex(np.exp(1j * np.radians(deg)))


def faults(planes: int) -> tuple[Injected, ...]:
    """Every fault of the campaign, for a drum with this many planes; check is the run after the trials."""
    check = planes + 2
    return (
        Injected("none", ()),
        Injected("trial angle 10 deg off", (2,), _typed(2, lambda u: u * _turned(10.0))),
        Injected("trial angle 60 deg off", (2,), _typed(2, lambda u: u * _turned(60.0))),
        Injected("trial angle mirrored", (2,), _typed(2, lambda u: complex(np.conj(u)))),
        Injected("trial angle opposite", (2,), _typed(2, lambda u: -u)),
        Injected("trial mass 20 % off", (2,), _typed(2, lambda u: 1.2 * u)),
        Injected("trial mass ten times", (2,), _typed(2, lambda u: 10.0 * u)),
        Injected("trial mass lost", (2,), really=_lost),
        Injected("trial mass left in", (3,), really=_left_in),
        Injected("sensors swapped in trial 1", (2,), _swapped(2, 2)),
        Injected("sensors swapped from trial 2 on", tuple(range(3, check + 1)), _swapped(3, 99)),
        Injected("all angles mirrored", (), _mirrored),
        Injected("outlier in trial", (2,), _times(2, 1.5 * _turned(60.0))),
        Injected("outlier in trial, one sensor", (2,), _times(2, 1.5 * _turned(60.0), 0)),
        Injected("outlier in initial", (1,), _times(1, 1.5 * _turned(60.0))),
        Injected("outlier in initial, initial twice", (1,), _times(1, 1.5 * _turned(60.0)), initials=2),
        Injected("phase flipped in trial", (2,), _times(2, -1.0)),
        Injected("largest piece forgotten", (check + 1,), really=_largest(0.0), initials=2),
        Injected("largest piece 60 deg off", (check + 1,), really=_largest(_turned(60.0)), initials=2),
    )
