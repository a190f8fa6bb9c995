"""How sure an answer is: a session solved again and again, its readings drawn anew within their scatter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.rotor.phasors import phasor, polar
from service.balancing.selection import compiled
from service.batch.drawn_answers import Prepared, answer, prepare
from service.batch.executors import executor
from service.engine.logs.replay import last_problem, resolve
from service.engine.mapping import placement_vectors
from service.engine.plan_survival import plan_survival
from service.errors import DrumtrueError, InvalidInput
from service.messages import Message
from service.model.plan import Placement, Plan
from service.model.run import Run, RunReading
from service.model.session import SessionLog

TOGETHER = 2_000
"""Draws that are answered together."""
FEW_DRAWS = 50_000
"""Draws that one process answers together sooner than others have started."""
WORTH_COMPILING = 20_000
"""Draws that gain more from compiled loops than compiling takes."""
PER_PIECE = 8
"""Draws that go to a worker at once: enough to outlast the way there, few enough to share out evenly."""

Placed = tuple[tuple[str, float, float], ...]


@dataclass(frozen=True)
class Draw:
    """One draw. masses: (g, degrees) a plane, in the machine's order. placements: (plane, degrees, g) of the plan.

    predicted: amplitude a sensor and speed after the plan, in the sensor's unit. refused: why it has no answer.
    """

    masses: tuple[tuple[float, float], ...] = ()
    placements: Placed = ()
    predicted: tuple[tuple[str, float], ...] = ()
    refused: str | None = None


@dataclass(frozen=True)
class Spread:
    """Of one value over the draws: its median and the range that holds 90 % of them."""

    name: str
    low: float
    median: float
    high: float


@dataclass(frozen=True)
class Study:
    """What the draws say.

    same: share of the answered draws that choose the plan's own selection, null without a plan. masses: correction mass
    of each plane, g. predicted: amplitude each sensor is left with, in its unit. refused: draws without an answer, by
    reason. Without any answer there is no spread. within, best: how probable it is that the plan keeps every sensor
    within its limit, and that no selection does better, given the readings' own scatter; null where that is unknown.
    """

    draws: int
    answered: int
    same: float | None
    masses: tuple[Spread, ...]
    predicted: tuple[Spread, ...]
    refused: tuple[tuple[str, int], ...]
    within: float | None = None
    best: float | None = None


def study(
    log: SessionLog,
    draws: int,
    seed: int,
    *,
    scatter: float | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int], None] = lambda _done: None,
) -> Study:
    """Solve the session's last correction and plan again `draws` times.

    Each reading is drawn from a normal distribution about itself with its own scatter in both components, or with
    `scatter` times its amplitude where it states none. Draw number i depends on the seed and i alone: the same study
    gives the same figures wherever it runs. Raises InvalidInput for a reading whose scatter no one states, and what
    `executor` raises.
    """
    last = _last_only(log)
    _require_scatter(last, scatter)
    itself = _one(last)
    if itself.refused is not None:
        raise InvalidInput(Message("invalid_input.session_unsolved", reason=itself.refused), field="file")
    together = prepared_of(last, scatter) is not None
    size = TOGETHER if together else PER_PIECE
    pieces = [range(start, min(start + size, draws)) for start in range(0, draws, size)]
    few = together and draws <= FEW_DRAWS and cluster is None
    compiling = together and draws >= WORTH_COMPILING
    found: dict[int, tuple[Draw, ...]] = {}
    with executor(1 if few else workers, cluster) as where:
        work = {where.submit(draw_some, last, piece, seed, scatter, compiling=compiling): piece for piece in pieces}
        for future in as_completed(work):
            found[work[future].start] = future.result()
            progress(sum(len(some) for some in found.values()))
    summed = _summed(last, itself, [one for piece in pieces for one in found[piece.start]])
    within, best = _probabilities(last)
    return replace(summed, within=within, best=best)


def _probabilities(log: SessionLog) -> tuple[float | None, float | None]:
    """How probable it is that the log's own plan meets the limits, and that it is the best."""
    plans = resolve(log).plans
    _, posed = last_problem(log)
    if posed is None or plans[-1].reason is not None:
        return None, None
    vectors = placement_vectors(log.machine, plans[-1].placements) - placement_vectors(log.machine, plans[-1].taken_off)
    found = plan_survival(posed, [vectors])
    if found is None:
        return None, None
    within = None if found.within is None else float(found.within[0])
    return within, None if found.best is None else float(found.best[0])


def draw_some(
    log: SessionLog, numbers: Sequence[int], seed: int, scatter: float | None, *, compiling: bool = False
) -> tuple[Draw, ...]:
    """The answers of these draws, together where that is possible; runs on a worker.

    compiling: whether there are enough draws in all to compile the search's loops for.
    """
    if compiling:
        compiled.load()
    prepared = prepared_of(log, scatter)
    if prepared is None:
        return tuple(_alone(log, number, seed, scatter) for number in numbers)
    found = answer(prepared, numbers, seed)
    sense = log.machine.angle_sense
    names = prepared.names
    return tuple(
        Draw(
            masses=tuple(polar(mass, sense) for mass in found.masses[at].tolist()),
            placements=_sorted(found.placements[at]),
            predicted=tuple(zip(names, found.amplitudes[at].tolist(), strict=True)),
        )
        if found.answered[at]
        else _alone(log, number, seed, scatter)
        for at, number in enumerate(numbers)
    )


def prepared_of(log: SessionLog, scatter: float | None) -> Prepared | None:
    """What the draws of a session share; None where each has to be solved by itself."""
    if any(plan.fitted is not None for plan in log.plans):
        return None
    fitted, posed = last_problem(log)
    return None if fitted is None else prepare(log, fitted, posed, scatter)


def _alone(log: SessionLog, number: int, seed: int, scatter: float | None) -> Draw:
    return _one(drawn(log, np.random.default_rng([seed, number]), scatter))


def drawn(log: SessionLog, rng: np.random.Generator, scatter: float | None = None) -> SessionLog:
    """The log with every reading drawn anew; a reading without phase is drawn in amplitude alone."""

    def reading(one: RunReading) -> RunReading:
        sigma = one.scatter if one.scatter is not None else (scatter or 0.0) * one.amplitude
        first, second = rng.normal(0.0, sigma, 2)
        if one.phase_deg is None:
            return replace(one, amplitude=abs(one.amplitude + first))
        amplitude, phase = polar(phasor(one.amplitude, one.phase_deg, sense) + complex(first, second), sense)
        return replace(one, amplitude=amplitude, phase_deg=phase)

    def run(one: Run) -> Run:
        return replace(one, readings=tuple(reading(r) for r in one.readings))

    sense = log.machine.phase_sense
    return replace(log, runs=tuple(run(one) for one in log.runs))


def _last_only(log: SessionLog) -> SessionLog:
    """The log with its last plan and that plan's correction, or its last correction, alone."""
    if not log.plans:
        return replace(log, corrections=log.corrections[-1:])
    plan = log.plans[-1]
    wanted = tuple(one for one in log.corrections if one.id == plan.request.correction_id)
    return replace(log, corrections=wanted, plans=(plan,))


def _require_scatter(log: SessionLog, scatter: float | None) -> None:
    for run in log.runs:
        for reading in run.readings:
            if not run.excluded and reading.scatter is None and scatter is None:
                raise InvalidInput(
                    Message("invalid_input.scatter_missing", sensor=reading.sensor, run=run.number), field="scatter"
                )


def _one(log: SessionLog) -> Draw:
    try:
        answers = resolve(log)
    except DrumtrueError as error:
        return Draw(refused=error.message)
    correction, plan = answers.corrections[-1], answers.plans[-1] if answers.plans else None
    predicted = correction.predicted if plan is None else plan.predicted
    return Draw(
        masses=tuple((mass.mass_g, mass.angle_deg) for mass in correction.corrections),
        placements=_placed(plan),
        predicted=tuple((f"{one.sensor} at {one.speed_rpm:g} r/min", one.amplitude) for one in predicted),
        refused=None if plan is None or plan.reason is None else plan.reason,
    )


def _placed(plan: Plan | None) -> Placed:
    if plan is None:
        return ()
    return _sorted(plan.placements)


def _sorted(placements: Sequence[Placement]) -> Placed:
    return tuple(sorted((piece.plane, piece.position_deg, piece.mass_g) for piece in placements))


def _summed(log: SessionLog, answer: Draw, found: Sequence[Draw]) -> Study:
    good = [one for one in found if one.refused is None]
    reasons = [one.refused for one in found if one.refused is not None]
    same = sum(one.placements == answer.placements for one in good)
    planes = [plane.name for plane in log.machine.planes] if good else []
    sensors = [name for name, _ in answer.predicted] if good else []
    return Study(
        draws=len(found),
        answered=len(good),
        same=same / len(good) if good and answer.placements else None,
        masses=tuple(_spread(name, [one.masses[index][0] for one in good]) for index, name in enumerate(planes)),
        predicted=tuple(_spread(name, [one.predicted[index][1] for one in good]) for index, name in enumerate(sensors)),
        refused=tuple((reason, reasons.count(reason)) for reason in sorted(set(reasons))),
    )


def _spread(name: str, values: Sequence[float]) -> Spread:
    low, median, high = (float(value) for value in np.quantile(values, [0.05, 0.5, 0.95]))
    return Spread(name, low, median, high)
