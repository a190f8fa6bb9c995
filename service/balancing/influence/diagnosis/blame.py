"""Findings about a run that is wrong: named where the data can tell it, else the runs of which one is."""

from __future__ import annotations

import math

from service.balancing.influence.diagnosis.findings import Finding
from service.balancing.influence.diagnosis.single_faults import Fault, Kind
from service.balancing.influence.diagnosis.suspects import AS_FOUND, Suspects
from service.balancing.rotor.labels import Labels
from service.messages import Message, Quantity

GRAVE = 0.6
"""Share of the amplitude from which a miss is an error and not a warning."""


def named_alone(name: Labels, found: Suspects, missed: float) -> Finding:
    """One run, or one slip in several, that the data can tell from every other."""
    fault, kinds = found.candidates[0].fault, _kinds(found)
    if all(one.kind in ("run", "reading") for one in kinds):
        told = Message("bad_run", run=name.run(fault.runs[0]), missed=missed)
    else:
        runs, slips = [name.run(k) for k in fault.runs], [slip_of(name, one) for one in kinds]
        told = Message("bad_run.slip", count=len(runs), runs=runs, missed=missed, slips=slips)
    return Finding(told, "error", fault.runs, fault.planes, fault.sensors)


def check_missed(name: Labels, found: Suspects, check: int, missed: float) -> Finding:
    """A check run that misses what the other runs predict: its own fault, that of one of several, or of none."""
    run, runs = name.run(check), (check,)
    told = Message("prediction_missed", run=run, missed=missed)
    if found.named:
        slips = [slip_of(name, one) for one in _kinds(found)]
        told = Message("prediction_missed.slip", run=run, missed=missed, slips=slips)
    elif found.sound:
        told = Message("prediction_missed.among", run=run, missed=missed, **_listed(name, found))
    return Finding(told, "error" if missed > GRAVE else "warning", _runs(found) if found.sound else runs)


def one_of_several(name: Labels, found: Suspects, missed: float) -> Finding:
    """Runs of which one is wrong, without one that the data could name."""
    told = Message("one_of_runs_wrong", missed=missed, **_listed(name, found))
    return Finding(told, "error" if missed > GRAVE else "warning", _runs(found))


def slip_of(name: Labels, fault: Fault) -> Message:
    """What a fault is, as part of a sentence."""
    turn = Quantity(math.degrees(fault.turn), "deg")
    runs = [name.run(k) for k in fault.runs]
    planes = [name.plane(p) for p in fault.planes]
    sensors = [name.sensor(s) for s in fault.sensors]
    factor = fault.factor
    texts: dict[Kind, Message] = {
        "amplitude_factor": Message("slip.amplitude_factor", runs=runs, sensors=sensors, factor=factor),
        "angle": Message("slip.angle", runs=runs, planes=planes, turn=turn),
        "angle_mirrored": Message("slip.angle_mirrored", runs=runs, planes=planes),
        "angle_opposite": Message("slip.angle_opposite", runs=runs, planes=planes),
        "gain": Message("slip.gain", runs=runs, factor=factor, turn=turn),
        "left_in": Message("slip.left_in", runs=runs),
        "lost": Message("slip.lost", runs=runs, planes=planes),
        "mass": Message("slip.mass", runs=runs, planes=planes, factor=factor),
        "mass_factor": Message("slip.mass_factor", runs=runs, planes=planes, factor=factor),
        "phase_mirrored": Message("slip.phase_mirrored", runs=runs),
        "phase_offset": Message("slip.phase_offset", runs=runs, turn=turn),
        "phase_opposite": Message("slip.phase_opposite", runs=runs, sensors=sensors),
        "piece": Message("slip.piece", runs=runs, planes=planes, factor=factor, turn=turn),
        "planes_swapped": Message("slip.planes_swapped", runs=runs, planes=planes),
        "reading": Message("slip.reading", runs=runs, sensors=sensors),
        "run": Message("slip.run", runs=runs),
        "sensors_swapped": Message("slip.sensors_swapped", runs=runs, sensors=sensors),
        "sensors_swapped_from": Message("slip.sensors_swapped_from", run=runs[0], sensors=sensors),
    }
    return texts[fault.kind]


def _kinds(found: Suspects) -> tuple[Fault, ...]:
    """What may have happened in the run that is named; what is known of it only loosely is left out beside a slip."""
    return found.kinds or (found.candidates[0].fault,)


def _runs(found: Suspects) -> tuple[int, ...]:
    return tuple(sorted({k for one in found.candidates for k in one.fault.runs}))


def _listed(name: Labels, found: Suspects) -> dict[str, object]:
    return {
        "runs": [name.run(k) for k in _runs(found)],
        "candidates": [
            Message("suspect", slip=slip_of(name, one.fault), share=max(one.share, 0.01)) for one in found.candidates
        ],
        "next": _next_run(name, found.next_run),
    }


def _next_run(name: Labels, run: int | None) -> Message:
    if run is None:
        return Message("next_run")
    return Message("next_run.as_found") if run == AS_FOUND else Message("next_run.like", run=name.run(run))
