"""Small random arrangement problems with every kind of limit, and the judge that tries every arrangement of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from service.balancing.arrangement import EMPTY, ArrangementProblem, GroupLimit, end_gains, part_effects, plane_shares
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.problem import Norm, Objective

NORMS: tuple[Norm, ...] = ("sum", "max", "rms", "components")
FEATURES = ("plain", "spares", "empties", "kinds", "fixed", "sets", "groups", "moves", "new", "gone", "mixed")


@dataclass(frozen=True)
class Judged:
    """What trying every arrangement found: least value, and for each number of moves the least; inf for none."""

    value: float
    by_moves: tuple[float, ...]
    fewest: tuple[int, int, float] | None


def random_problem(feature: str, norm: Norm, seed: int, most: int = 5) -> ArrangementProblem:
    """Up to `most` places, one to three components of the residual, the offset from nothing to out of reach."""
    rng = np.random.default_rng([seed, FEATURES.index(feature), NORMS.index(norm)])
    mixed = feature == "mixed"

    def has(name: str) -> bool:
        return feature == name or (mixed and bool(rng.random() < 0.4))

    places = int(rng.integers(2, most + 1))
    parts = places + (int(rng.integers(1, 3)) if has("spares") or has("sets") else 0)
    empties = rng.random(places) < (0.4 if has("empties") else 0.0)
    parts = max(1, parts - int(rng.integers(0, int(empties.sum()) + 1)))
    mass = np.round(rng.normal(600.0, 25.0, parts), 0)
    effects, size = _effects(rng, mass, places)
    allowed = np.ones((parts, places), dtype=np.bool_)
    if has("kinds"):
        allowed = rng.integers(2, size=parts)[:, None] == rng.integers(2, size=places)[None, :]
    present = np.full(places, EMPTY, dtype=np.int64)
    mounted = rng.permutation(parts)[:places]
    present[: len(mounted)] = mounted
    if has("gone"):
        present[rng.random(places) < 0.3] = EMPTY
    new = rng.random(parts) < 0.3
    if has("fixed") and present[0] != EMPTY:
        allowed[present[0]], allowed[:, 0], empties[0] = False, False, False
        allowed[present[0], 0] = True
    offset = rng.normal(size=size) + 1j * rng.normal(size=size)
    return ArrangementProblem(
        objective=Objective(
            matrix=np.eye(size, dtype=np.complex128),
            offset=np.asarray(offset * float(rng.choice([0.0, 3e3, 2e4, 1e6])), dtype=np.complex128),
            weights=np.ones(size) if rng.random() < 0.5 else rng.uniform(0.5, 2.0, size),
            norm=norm,
        ),
        effects=effects,
        allowed=allowed,
        may_be_empty=empties,
        present=present,
        new=new,
        masses_g=mass,
        sets=_sets(rng, parts) if has("sets") else (),
        groups=_groups(rng, places) if has("groups") else (),
        max_moves=int(rng.integers(0, 5)) if has("moves") else None,
        max_new=int(rng.integers(0, 3)) if has("new") else None,
    )


def every(problem: ArrangementProblem) -> Iterator[list[int]]:
    """Every arrangement of a problem, written down plainly: place by place, then the limits."""

    def fill(chosen: list[int]) -> Iterator[list[int]]:
        place = len(chosen)
        if place == problem.places:
            yield chosen
            return
        for part in range(problem.parts):
            if problem.allowed[part, place] and part not in chosen:
                yield from fill([*chosen, part])
        if problem.may_be_empty[place]:
            yield from fill([*chosen, EMPTY])

    return (found for found in fill([]) if _kept(problem, found))


def judge(problem: ArrangementProblem, limit: float = math.inf) -> Judged:
    """Try them all."""
    by_moves = [math.inf] * (problem.places + 1)
    fewest: tuple[int, int, float] | None = None
    for found in every(problem):
        value, moved = value_of(problem, found), moved_of(problem, found)
        by_moves[moved] = min(by_moves[moved], value)
        if value <= limit:
            rank = (moved, sum(bool(problem.new[k]) for k in found if k != EMPTY), value)
            fewest = rank if fewest is None else min(fewest, rank)
    return Judged(min(by_moves), tuple(by_moves), fewest)


def value_of(problem: ArrangementProblem, found: list[int]) -> float:
    """Objective of one arrangement."""
    r = [complex(x) for x in problem.objective.offset]
    for place, part in enumerate(found):
        if part != EMPTY:
            r = [x + complex(e) for x, e in zip(r, problem.effects[part, place], strict=True)]
    weighted = [w * x for w, x in zip(problem.objective.weights, r, strict=True)]
    if problem.objective.norm == "components":
        return float(sum(abs(x.real) + abs(x.imag) for x in weighted))
    size = [abs(x) for x in weighted]
    if problem.objective.norm == "rms":
        return math.sqrt(sum(s * s for s in size) / len(size))
    return float(sum(size) if problem.objective.norm == "sum" else max(size))


def moved_of(problem: ArrangementProblem, found: list[int]) -> int:
    """Places whose part is another."""
    return sum(int(a) != int(b) for a, b in zip(found, problem.present, strict=True))


def _kept(problem: ArrangementProblem, found: list[int]) -> bool:
    for members in problem.sets:
        if 0 < len(set(members) & set(found)) < len(members):
            return False
    for group in problem.groups:
        masses = [problem.masses_g[found[p]] for p in group.places if found[p] != EMPTY]
        if masses and max(masses) - min(masses) > group.max_difference_g:
            return False
    if problem.max_moves is not None and moved_of(problem, found) > problem.max_moves:
        return False
    return problem.max_new is None or sum(bool(problem.new[k]) for k in found if k != EMPTY) <= problem.max_new


def _effects(rng: np.random.Generator, mass: FloatArray, places: int) -> tuple[ComplexArray, int]:
    """Effects in one plane or two, of one mass or both ends; or of any kind, as behind influence coefficients."""
    kind = int(rng.integers(4))
    if kind == 3:
        size = int(rng.integers(1, 4))
        shape = (len(mass), places, size)
        return np.asarray(1e3 * (rng.normal(size=shape) + 1j * rng.normal(size=shape)), dtype=np.complex128), size
    step = math.pi if rng.random() < 0.2 else math.pi / 6.0
    angles = np.asarray(rng.permutation(12)[:places] * step, dtype=np.float64)
    radius = np.full(places, 300.0) if rng.random() < 0.5 else rng.uniform(250.0, 320.0, places)
    axial = np.stack([rng.uniform(-600.0, -400.0, places), rng.uniform(400.0, 600.0, places)], axis=1)
    shares = np.ones((places, 2, 1)) if kind == 0 else plane_shares(axial, np.array([-500.0, 500.0]))
    ends = np.zeros((len(mass), places, 2))
    ends[:, :, 0] = mass[:, None]
    if kind == 2:
        ends[:, :, 0] /= 2.0
        ends[:, :, 1] = np.round(rng.normal(300.0, 12.0, len(mass)))[:, None]
    return part_effects(ends, end_gains(radius, angles, axial, shares)), shares.shape[2]


def _sets(rng: np.random.Generator, parts: int) -> tuple[tuple[int, ...], ...]:
    pairs = list(combinations(rng.permutation(parts).tolist(), 2))
    return (tuple(pairs[0]),) if pairs else ()


def _groups(rng: np.random.Generator, places: int) -> tuple[GroupLimit, ...]:
    members = tuple(int(p) for p in rng.permutation(places)[: max(2, places // 2)])
    return (GroupLimit(members, float(rng.integers(5, 80))),)
