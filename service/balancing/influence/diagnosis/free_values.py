"""Faults with a value that is not known, an angle, a size or both: the value that leaves least of the misfit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.influence.diagnosis.single_faults import Fault, Undone, undo_masses, undo_readings
from service.balancing.influence.fit import RunSet
from service.balancing.rotor.phasors import ComplexArray, FloatArray

_TURNS = np.radians(np.arange(0.0, 360.0, 15.0))
_SIZES = np.log(np.array([1.0 / 3.0, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0]))
_MAX_SIZE = float(np.log(3.0))
_RANGE = (2.0 * _MAX_SIZE, 2.0 * np.pi)
_ALIKE = 0.01
"""Probability of a piece that is off in all of several runs, beside one that is off in a single run."""
_BESIDE = np.array([-1.0, 0.0, 1.0])
_ZOOMS = 6
_STEP = 0.02
_MAX_NUMBERS = 1_000_000
"""Complex numbers of a design that are held at once."""


@dataclass(frozen=True)
class Weighed:
    """A fault undone, what is left, the logarithm of its probability, and real degrees of freedom."""

    undone: Undone
    chi_square: float
    log_weight: float
    freedom: int


@dataclass(frozen=True)
class Form:
    """A fault with a free size, a free turn or both, and the logarithm of its probability beforehand."""

    fault: Fault
    size: bool
    turn: bool
    prior: float

    def grid(self, zoom: int) -> FloatArray:
        """Values (N, 2) about the best one so far, closer at each zoom."""
        sizes, turns = (
            (_SIZES, _TURNS) if zoom == 0 else (0.4 * 0.5**zoom * _BESIDE, np.radians(15.0) * 0.5**zoom * _BESIDE)
        )
        return np.array([(a, t) for a in (sizes if self.size else (0.0,)) for t in (turns if self.turn else (0.0,))])


def best_values(runs: RunSet, forms: Sequence[Form], sigma: FloatArray) -> list[Weighed]:
    """The value of each fault that leaves least, by a grid that closes in; its width gives the Occam factor."""
    centres, best = np.zeros((len(forms), 2)), np.full(len(forms), np.inf)
    for zoom in range(_ZOOMS + 1):
        grids = [form.grid(zoom) + centre for form, centre in zip(forms, centres, strict=True)]
        for grid in grids:
            np.clip(grid[:, 0], -_MAX_SIZE, _MAX_SIZE, out=grid[:, 0])
        for k, (grid, chi) in enumerate(zip(grids, _of_grids(runs, forms, grids, sigma), strict=True)):
            at = int(np.argmin(chi))
            if chi[at] < best[k]:
                best[k], centres[k] = chi[at], grid[at]
    occam = _occam(runs, forms, centres, best, sigma)
    out = []
    for form, centre, least, less in zip(forms, centres, best.tolist(), occam.tolist(), strict=True):
        value = np.exp(centre[0] + 1j * centre[1])
        told = replace(form.fault, factor=float(abs(value)), turn=float(np.angle(value)))
        undone = _undone(runs, told, np.array([value]))
        out.append(Weighed(undone, least, form.prior + less - 0.5 * least, freedom(undone, form.size + form.turn)))
    return out


def _occam(runs: RunSet, forms: Sequence[Form], centres: FloatArray, best: FloatArray, sigma: FloatArray) -> FloatArray:
    """Logarithm (F,) of the share of its range that each free value may have, from the curve of the chi-square."""
    out = np.array([float(np.log(_ALIKE)) if len(form.fault.runs) > 1 else 0.0 for form in forms])
    for axis in range(2):
        step = np.zeros(2)
        step[axis] = _STEP
        beside = _of_grids(runs, forms, [centre + np.array([step, -step]) for centre in centres], sigma)
        curve = np.maximum(np.array([float(pair.sum()) for pair in beside]) - 2.0 * best, 1e-12)
        width = np.log(np.minimum(1.0, _STEP * np.sqrt(4.0 * np.pi / curve) / _RANGE[axis]))
        out += np.where([form.turn if axis else form.size for form in forms], width, 0.0)
    return out


def _of_grids(runs: RunSet, forms: Sequence[Form], grids: Sequence[FloatArray], sigma: FloatArray) -> list[FloatArray]:
    """Chi-square of each fault at each of its values (N, 2): logarithm of the size, and turn."""
    masses, vibration, weight = [], [], []
    present = np.where(np.isfinite(runs.vibration), 1.0, 0.0)
    for form, grid in zip(forms, grids, strict=True):
        factors = np.exp(grid[:, 0] + 1j * grid[:, 1])
        plain = np.repeat(present[None], len(grid), axis=0)
        if form.fault.planes:
            masses.append(undo_masses(runs, form.fault, factors))
            vibration.append(np.repeat(runs.vibration[None], len(grid), axis=0))
        else:
            plain[:, list(form.fault.runs)] *= np.abs(factors)[:, None, None]
            masses.append(np.repeat(runs.masses[None], len(grid), axis=0))
            vibration.append(undo_readings(runs, form.fault, factors))
        weight.append(plain)
    found = chi_squares(np.concatenate(masses), np.concatenate(vibration), np.concatenate(weight), sigma)
    return np.split(found, np.cumsum([len(grid) for grid in grids])[:-1])


def _undone(runs: RunSet, fault: Fault, value: ComplexArray) -> Undone:
    weight = np.where(np.isfinite(runs.vibration), 1.0, 0.0)
    if fault.planes:
        return Undone(fault, undo_masses(runs, fault, value)[0], runs.vibration, weight)
    weight[list(fault.runs)] *= np.abs(value)
    return Undone(fault, runs.masses, undo_readings(runs, fault, value)[0], weight)


def typical_amplitude(vibration: ComplexArray) -> FloatArray:
    """Median amplitude (S,) of the readings (K, S) of each sensor; 0 where it has none."""
    out = np.zeros(vibration.shape[1])
    for s, column in enumerate(vibration.T):
        seen = np.abs(column[np.isfinite(column)])
        out[s] = np.median(seen) if len(seen) else 0.0
    return out


def chi_squares(masses: ComplexArray, vibration: ComplexArray, factor: FloatArray, sigma: FloatArray) -> FloatArray:
    """Sum of squares (H,) that a fit leaves of masses (H, K, P) and vibration (H, K, S), in units of sigma / factor."""
    each = vibration.shape[1] * vibration.shape[2] * (1 + masses.shape[2])
    step = max(1, _MAX_NUMBERS // each)
    parts = [slice(at, at + step) for at in range(0, len(masses), step)]
    return np.concatenate([_chi_squares(masses[at], vibration[at], factor[at], sigma) for at in parts])


def _chi_squares(masses: ComplexArray, vibration: ComplexArray, factor: FloatArray, sigma: FloatArray) -> FloatArray:
    scale = np.maximum(np.abs(masses).max(axis=1, keepdims=True), 1e-300)
    design = np.concatenate([np.ones((*masses.shape[:2], 1)), masses / scale], axis=2)
    weight = factor / sigma
    weighted = weight.swapaxes(1, 2)[..., None] * design[:, None]  # (H, S, K, Q)
    seen = (np.where(factor > 0.0, vibration, 0.0) * weight).swapaxes(1, 2)  # (H, S, K)
    turned = weighted.conj().swapaxes(2, 3)
    normal = turned @ weighted
    # A direction that no run shows takes nothing away: a ridge far below the rounding of a chi-square keeps it finite.
    size = np.trace(normal, axis1=2, axis2=3).real
    normal += (1e-11 * np.maximum(size, 1e-300))[..., None, None] * np.eye(design.shape[2])
    solved = np.linalg.solve(normal, turned @ seen[..., None])
    rest = seen - (weighted @ solved)[..., 0]
    return np.asarray((np.abs(rest) ** 2).sum(axis=(1, 2)))


def freedom(undone: Undone, values: int) -> int:
    """Real degrees of freedom that are left."""
    unknowns = 1 + undone.masses.shape[1]
    return int(2 * np.maximum((undone.weight > 0.0).sum(axis=0) - unknowns, 0).sum()) - values
