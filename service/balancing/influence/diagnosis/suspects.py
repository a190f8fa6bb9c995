"""Which run is wrong: every single fault weighed against the others by how well the rest then fits.

Each fault is undone and the runs are fitted again. What is left is a chi-square; a fault with free values (an angle, a
reading) is weighed down by how much of their range it does not need (Occam factor, MacKay, Information Theory,
Inference, and Learning Algorithms, 2003, chapter 28). Faults that the data cannot tell apart come out alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from service.balancing.influence.diagnosis.free_values import (
    Form,
    Weighed,
    best_values,
    chi_squares,
    freedom,
    typical_amplitude,
)
from service.balancing.influence.diagnosis.single_faults import Fault, Kind, Undone, discrete, left_out, turned_masses
from service.balancing.influence.fit import InfluenceFit, RunSet, fit_influence
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.errors import NumericsError

NAMED = 0.985
"""Probability from which one group of runs is named alone, and up to which candidates are listed."""
LEAST = 0.003
"""Probability below which a candidate is not listed."""
SOUND = 1e-3
"""Probability that what is left of the misfit must have, for a fault to explain it."""
LEAST_REPEATABILITY = 0.01
"""Least error of a run from start to start, per real component, as a share of its amplitude."""
LEAST_SCATTER = 0.003
"""Least error of a reading, as a share of the sensor's typical amplitude."""
PLACEMENT = 0.007
"""Error of a piece's vector, per real component, as a share of its effect."""
AS_FOUND = -1
"""The state without any mass, in place of the index of a run."""
MAX_WEIGHED = 12
MIN_WEIGHED = 3
LONG_SESSION = 120
"""Runs, and sensors, that faults are looked for in are those that miss the model most: `LONG_SESSION` over their
number, within these."""
MAX_FAULTS = 3000
"""Slips that are weighed; what is more is left out."""
_CLASS: dict[Kind, float] = {"run": 0.25, "reading": 0.2, "gain": 0.03, "phase_offset": 0.05, "angle": 0.1,
                             "mass": 0.05, "piece": 0.05}  # fmt: skip
_SLIPS = 0.27
_FREE_OF_A_MASS: tuple[tuple[Kind, tuple[bool, bool]], ...] = (
    ("angle", (False, True)),
    ("mass", (True, False)),
    ("piece", (True, True)),
)
_FREE_OF_A_RUN: tuple[tuple[Kind, tuple[bool, bool]], ...] = (("phase_offset", (False, True)), ("gain", (True, True)))


@dataclass(frozen=True)
class Candidate:
    """A fault, how probable it is beside the others (0 to 1), and the runs as they would be without it."""

    fault: Fault
    share: float
    undone: RunSet


@dataclass(frozen=True)
class Suspects:
    """candidates: the most probable first, one for each set of runs. sound: whether the best explains the runs.

    kinds: the faults of the best candidate's runs that are probable too. next_run: the run whose masses are to be on
    the rotor in the one further run that tells the candidates apart best, `AS_FOUND` for none; None where one is named
    alone, or no run tells.
    """

    candidates: tuple[Candidate, ...]
    kinds: tuple[Fault, ...]
    sound: bool
    next_run: int | None

    @property
    def named(self) -> bool:
        """Whether one candidate stands alone."""
        return self.sound and len(self.candidates) == 1


def suspects_of(runs: RunSet, fit: InfluenceFit, nominal_rpm: FloatArray | None = None) -> Suspects:
    """Weigh every single fault of runs that do not follow one linear model.

    runs: scatter as fitted, nan or 0 where it is unknown; then the least is taken. nominal_rpm: (S,), of rows.
    """
    columns, about = _worst(runs, fit)
    small = replace(runs, vibration=runs.vibration[:, columns], scatter=runs.scatter[:, columns])
    sigma = _sigma(small, fit.initial[columns])
    rows = None if nominal_rpm is None else nominal_rpm[columns]
    found = [_renumbered(one, columns) for one in _weighed(small, sigma, rows, about)]
    if not found:
        return Suspects((), (), False, None)
    log = np.array([one.log_weight for one in found])
    share = np.exp(log - log.max())
    share /= share.sum()
    best = found[int(np.argmax(share))]
    groups = _grouped(found, share)
    listed = _listed(groups, small)
    sound = _probability(best) > SOUND
    kinds = tuple(one.undone.fault for one, part in groups[0][1] if part >= 0.1 * groups[0][0])
    names = sound and len(listed) == 1
    return Suspects(listed, kinds, sound, None if names or not sound else _next_run(small, sigma, listed))


def _worst(runs: RunSet, fit: InfluenceFit) -> tuple[IntArray, tuple[int, ...]]:
    """Sensors and runs that miss the model most, as many as are weighed, in their order."""
    size = typical_amplitude(runs.vibration)
    missed = np.where(np.isfinite(fit.residuals), np.abs(fit.residuals), 0.0) / np.where(size > 0.0, size, np.inf)
    # In a long session a wrong run stands out by itself, and few need be weighed.
    most = max(MIN_WEIGHED, min(MAX_WEIGHED, LONG_SESSION // len(runs.masses)))
    columns = np.sort(np.argsort(-missed.max(axis=0), kind="stable")[:most])
    rows = np.sort(np.argsort(-missed.max(axis=1), kind="stable")[:most])
    return columns, tuple(int(k) for k in rows)


def _renumbered(one: Weighed, columns: IntArray) -> Weighed:
    fault = replace(one.undone.fault, sensors=tuple(int(columns[s]) for s in one.undone.fault.sensors))
    return replace(one, undone=replace(one.undone, fault=fault))


def _sigma(runs: RunSet, initial: ComplexArray) -> FloatArray:
    """Standard deviation (K, S) per real component that a sound run may err by."""
    present = np.isfinite(runs.vibration)
    amplitude = np.where(present, np.abs(runs.vibration), 0.0)
    typical = typical_amplitude(runs.vibration)
    own = np.maximum(np.where(runs.scatter > 0.0, runs.scatter, 0.0), LEAST_REPEATABILITY * amplitude)
    effect = np.where(present & np.isfinite(initial), np.abs(runs.vibration - initial), 0.0)
    floor = np.maximum(LEAST_SCATTER * typical, 1e-9 * np.max(amplitude, initial=1e-150))
    return np.asarray(np.sqrt(own**2 + floor**2 + (PLACEMENT * np.minimum(effect, typical)) ** 2))


def _weighed(runs: RunSet, sigma: FloatArray, nominal_rpm: FloatArray | None, about: tuple[int, ...]) -> list[Weighed]:
    out = _of_slips(list(islice(discrete(runs, nominal_rpm, about), MAX_FAULTS)), sigma)
    out += _of_left_out(list(left_out(runs, about)), runs, sigma)
    out += _of_values(runs, sigma, about)
    return [one for one in out if np.isfinite(one.log_weight)]


def _of_slips(slips: Sequence[Undone], sigma: FloatArray) -> list[Weighed]:
    if not slips:
        return []
    found = chi_squares(
        np.array([one.masses for one in slips]),
        np.array([one.vibration for one in slips]),
        np.array([one.weight for one in slips]),
        sigma,
    )
    prior = float(np.log(_SLIPS / len(slips)))
    return [
        Weighed(one, float(chi), prior - 0.5 * float(chi), freedom(one, 0))
        for one, chi in zip(slips, found, strict=True)
    ]


def _of_left_out(outs: Sequence[Undone], runs: RunSet, sigma: FloatArray) -> list[Weighed]:
    weighted = fit_influence(replace(runs, scatter=sigma), "leave_out")
    free = np.where(np.isfinite(weighted.residuals), 1.0 - weighted.leverage, 0.0)
    testable = free > 1e-6
    size = np.maximum(typical_amplitude(runs.vibration), np.nan_to_num(np.abs(runs.vibration)))
    missed = np.divide(np.abs(weighted.residuals), free, out=np.zeros(free.shape), where=testable)
    # A wrong reading is off by about its own size: evidence of an error with that variance beside `sigma`.
    wider = free * size**2
    needless = -np.log1p(wider / sigma**2) - 0.5 * free * missed**2 / (sigma**2 + wider)
    kept = []
    for one in outs:
        (k,) = one.fault.runs
        gone = np.isfinite(runs.vibration[k]) & (one.weight[k] == 0.0) & testable[k]
        if gone.any():
            members = sum(other.fault.kind == one.fault.kind for other in outs)
            kept.append((one, float(np.log(_CLASS[one.fault.kind] / members) + needless[k, gone].sum())))
    if not kept:
        return []
    found = chi_squares(
        np.array([one.masses for one, _ in kept]),
        np.array([one.vibration for one, _ in kept]),
        np.array([one.weight for one, _ in kept]),
        sigma,
    )
    return [
        Weighed(one, float(chi), prior - 0.5 * float(chi), freedom(one, 0))
        for (one, prior), chi in zip(kept, found, strict=True)
    ]


def _of_values(runs: RunSet, sigma: FloatArray, about: tuple[int, ...]) -> list[Weighed]:
    """Faults with an angle, a size or both that are not known: of a mass, and of all readings of a run."""
    pieces = list(turned_masses(runs, about))
    whole = [Fault("gain", (k,)) for k in about if np.isfinite(runs.vibration[k]).sum() > 1]
    forms = [
        Form(replace(fault, kind=kind), *free, float(np.log(_CLASS[kind] / len(pieces))))
        for fault in pieces
        for kind, free in _FREE_OF_A_MASS
    ]
    forms += [
        Form(replace(fault, kind=kind), *free, float(np.log(_CLASS[kind] / len(whole))))
        for fault in whole
        for kind, free in _FREE_OF_A_RUN
    ]
    return best_values(runs, forms, sigma) if forms else []


def _probability(one: Weighed) -> float:
    from scipy.special import chdtrc

    return 1.0 if one.freedom <= 0 else float(chdtrc(one.freedom, one.chi_square))


def _grouped(found: Sequence[Weighed], share: FloatArray) -> list[tuple[float, list[tuple[Weighed, float]]]]:
    """Faults by the runs that they are about, the most probable first."""
    groups: dict[tuple[int, ...], list[tuple[Weighed, float]]] = {}
    for one, part in zip(found, share.tolist(), strict=True):
        groups.setdefault(one.undone.fault.runs, []).append((one, part))
    out = [(sum(part for _, part in each), sorted(each, key=lambda pair: -pair[1])) for each in groups.values()]
    return sorted(out, key=lambda group: -group[0])


def _listed(groups: Iterable[tuple[float, list[tuple[Weighed, float]]]], runs: RunSet) -> tuple[Candidate, ...]:
    out: list[Candidate] = []
    total = 0.0
    for share, each in groups:
        if out and (total >= NAMED or share < LEAST):
            break
        one = each[0][0].undone
        counts = one.weight > 0.0
        scatter = np.divide(runs.scatter, one.weight, out=np.full(runs.scatter.shape, np.nan), where=counts)
        vibration = np.where(counts, one.vibration, np.nan)
        out.append(Candidate(one.fault, share, RunSet(one.masses, vibration, scatter, runs.labels)))
        total += share
    return tuple(out)


def _next_run(runs: RunSet, sigma: FloatArray, listed: Sequence[Candidate]) -> int | None:
    """Of the states that runs had, with one plane's mass at most, the one in which the candidates differ most."""
    fits, shares = [], []
    for one in listed:
        try:
            fits.append(fit_influence(replace(one.undone, scatter=sigma), "leave_out"))
        except NumericsError:
            continue
        shares.append(one.share)
    if len(fits) < 2:
        return None
    single = [k for k in range(len(runs.masses)) if np.count_nonzero(runs.masses[k]) == 1]
    states = np.concatenate([np.zeros((1, runs.masses.shape[1]), dtype=complex), runs.masses[single]])
    typical = np.median(sigma, axis=0)
    told = np.array([fit.initial + states @ fit.influence.T for fit in fits]) / typical  # (N, U, S)
    apart = np.nan_to_num(np.abs(told[:, None] - told[None])).max(axis=3)  # (N, N, U)
    weight = np.outer(shares, shares)
    confusion = (weight[:, :, None] * np.exp(-0.125 * np.minimum(apart, 40.0) ** 2)).sum(axis=(0, 1))
    return (AS_FOUND, *single)[int(np.argmin(confusion))]
