"""Optimising a design document: methods by name, one outcome with evidence, fronts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from service.design.findings import refusal
from service.design.reading import listed
from service.design.registry import study_of
from service.design.study import DesignProblem, Document, Simulation
from service.messages import Message
from service.optimize.differential_evolution import VARIANTS, DifferentialEvolution
from service.optimize.differential_search import DifferentialSearch
from service.optimize.epsilon import EpsilonConstraint, FrontPoint, TwoObjectives
from service.optimize.front import hypervolume
from service.optimize.jaya import Jaya
from service.optimize.kkt import residuals
from service.optimize.problem import FloatArray
from service.optimize.search import Clock, Evidence, Progress, Search, SearchResult, Stop, never, no_clock, run
from service.optimize.sqp import MultiStart

ENUMERATION, SQP = "enumeration", "sqp"
_DE = {f"de_{variant}": variant for variant in VARIANTS}
METHODS = (ENUMERATION, SQP, *_DE, "differential_search", "jaya")
STEPS = {ENUMERATION: 1, SQP: 30}
"""Starts of the default method; searches by values take `GENERATIONS`."""
CONVEX_STARTS = 3
END_STARTS = 20
"""Random starts for each end of a front: the whole front lies between them."""
GENERATIONS, MEMBERS = 300, 60
MAX_STEPS, MAX_POINTS = 100_000, 500
FRONT_POINTS = 60
AGREED = 1e-6


@dataclass(frozen=True)
class Outcome:
    """An optimised design. value: of the objective as it is shown. after: what `document`, the design found, does.

    sensitivities: limit -> change of the objective, part of itself, for a limit raised by one part of itself.
    """

    method: str
    objective: str
    quantity: str
    value: float
    result: SearchResult
    before: Simulation
    after: Simulation
    document: Document
    sensitivities: dict[str, float] = field(default_factory=dict)

    @property
    def evidence(self) -> Evidence:
        """What speaks for the answer; the bound as it is shown."""
        return self.result.evidence


@dataclass(frozen=True)
class FrontOutcome:
    """Designs that no other dominates: objectives (k, 2) as shown, designs (k, d), the best first objective first."""

    names: tuple[str, str]
    objectives: FloatArray
    x: FloatArray
    documents: tuple[Document, ...]
    evaluations: int
    seconds: float
    seed: int
    complete: bool

    def volume(self, reference: tuple[float, float]) -> float:
        """Hypervolume below a reference point."""
        return hypervolume(self.objectives, reference)


def default_method(problem: DesignProblem) -> str:
    """Enumeration where it settles the problem, else gradients from many starts."""
    return ENUMERATION if problem.exact is not None else SQP


def optimise(
    document: Document,
    method: str | None = None,
    seed: int = 1,
    steps: int | None = None,
    *,
    stop: Stop = never,
    clock: Clock = no_clock,
    deadline_s: float = math.inf,
    watch: Callable[[Progress], None] = lambda _: None,
) -> Outcome:
    """The best design that a method finds; its own when None. Raises RefusedDesign for a document or method refused.

    steps: starts of `sqp`, generations of the others. watch: called after each step.
    """
    study = study_of(document)
    problem = study.problem(document)
    before = study.simulate(document)
    name = default_method(problem) if method is None else method
    search = _search(problem, name, seed)
    budget = _budget(problem, name) if steps is None else steps
    result = run(search, budget, seed, stop=stop, clock=clock, deadline_s=deadline_s, watch=watch)
    sensitivities: dict[str, float] = {}
    if isinstance(search, MultiStart):
        result = _with_evidence(result, search)
        sensitivities = _sensitivities(problem, result)
    elif isinstance(search, _Enumeration) and result.feasible and problem.proved:
        result = replace(result, status="optimal", evidence=Evidence("proved_bound", bound=result.value))
    found = problem.apply(result.x)
    after = study.simulate(found)
    value = after.value(problem.objective_name)
    if problem.maximise and result.evidence.bound is not None:
        result = replace(result, evidence=replace(result.evidence, bound=-result.evidence.bound))
    return Outcome(
        name, problem.objective_name, problem.objective_quantity, value, result, before, after, found, sensitivities
    )


def front(
    document: Document,
    points: int = FRONT_POINTS,
    seed: int = 1,
    *,
    ceiling: float = math.inf,
    stop: Stop = never,
    clock: Clock = no_clock,
    deadline_s: float = math.inf,
    watch: Callable[[FrontPoint], None] = lambda _: None,
) -> FrontOutcome:
    """The front of the two responses that a document trades off; ceiling: greatest second one of interest.

    Raises RefusedDesign for a document without two such responses.
    """
    problem = study_of(document).problem(document)
    pair, names = _two_objectives(problem)
    began = clock()
    convex = all(region.convex for region in pair.regions)
    search = EpsilonConstraint(
        pair,
        points,
        np.random.default_rng(seed),
        starts=0 if convex else 1,
        end_starts=2 if convex else END_STARTS,
        ceiling=ceiling,
    )
    complete = False
    while not stop() and clock() - began < deadline_s:
        try:
            watch(next(search))
        except StopIteration:
            complete = True
            break
    objectives, designs = search.front()
    return FrontOutcome(
        names=names,
        objectives=objectives,
        x=designs,
        documents=tuple(problem.apply(x) for x in designs),
        evaluations=search.evaluations,
        seconds=clock() - began,
        seed=seed,
        complete=complete,
    )


def require_optimum(document: Document, method: str | None = None) -> None:
    """Raise RefusedDesign for a document that cannot be optimised, or not by this method."""
    problem = study_of(document).problem(document)
    _require_method(problem, default_method(problem) if method is None else method)


def require_front(document: Document) -> None:
    """Raise RefusedDesign for a document without two responses to trade off."""
    _two_objectives(study_of(document).problem(document))


def _two_objectives(problem: DesignProblem) -> tuple[TwoObjectives, tuple[str, str]]:
    if problem.front is None or problem.front_names is None:
        raise refusal(Message("design_no_front", field="aim.front"))
    return problem.front, problem.front_names


def _budget(problem: DesignProblem, method: str) -> int:
    """Steps where none are asked for; of a convex problem any start leads to the optimum."""
    if method == SQP and problem.alternatives[0].convex:
        return CONVEX_STARTS
    return STEPS.get(method, GENERATIONS)


class _Enumeration:
    """The proved or exact optimum in one step."""

    def __init__(self, problem: DesignProblem) -> None:
        self._problem, self._done = problem, False

    def __iter__(self) -> _Enumeration:
        return self

    def __next__(self) -> Progress:
        if self._done or self._problem.exact is None:
            raise StopIteration
        self._done = True
        found = self._problem.exact()
        if found is None:
            present = np.array([one.present for one in self._problem.variables])
            return Progress(1, present, math.inf, math.inf, 1)
        return Progress(1, found[0], found[1], 0.0, 1)


def methods(document: Document) -> tuple[str, ...]:
    """Names of the methods that can optimise a document, the best known first. Raises RefusedDesign."""
    problem = study_of(document).problem(document)
    best = default_method(problem)
    return (best, *(name for name in _known(problem) if name != best))


def _known(problem: DesignProblem) -> list[str]:
    return [
        name
        for name in METHODS
        if (name == ENUMERATION and problem.exact is not None)
        or (name == SQP and problem.alternatives)
        or (name not in (ENUMERATION, SQP) and problem.mixed is not None)
    ]


def _require_method(problem: DesignProblem, method: str) -> None:
    known = _known(problem)
    if method not in known:
        raise refusal(Message("design_name_unknown", field="method", value=method, known=listed(known)))


def _search(problem: DesignProblem, method: str, seed: int) -> Search:
    _require_method(problem, method)
    rng = np.random.default_rng(seed)
    if method == ENUMERATION:
        return _Enumeration(problem)
    if method == SQP:
        return MultiStart(problem.alternatives, rng)
    assert problem.mixed is not None  # noqa: S101  such a method is known only then
    if method in _DE:
        return DifferentialEvolution(problem.mixed, MEMBERS, rng, _DE[method])
    if method == "differential_search":
        return DifferentialSearch(problem.mixed, MEMBERS, rng)
    return _Generations(Jaya(problem.mixed, MEMBERS, rng))


class _Generations:
    """Jaya's generations as progress."""

    def __init__(self, jaya: Jaya) -> None:
        self._jaya = jaya

    def __iter__(self) -> _Generations:
        return self

    def __next__(self) -> Progress:
        state = next(self._jaya)
        return Progress(state.number, state.x, state.value, state.violation, state.evaluations)


def _with_evidence(result: SearchResult, search: MultiStart) -> SearchResult:
    """The result with what speaks for it; optimal where a bound proves it to a millionth."""
    evidence = search.evidence()
    if not result.feasible:
        return replace(result, evidence=evidence)
    status = result.status
    if evidence.kind == "proved_bound" and evidence.bound is not None:
        near = result.value - evidence.bound <= AGREED * max(abs(result.value), 1e-9)
        status = "optimal" if near else status
    elif evidence.residual is not None and evidence.residual < AGREED and (evidence.agreeing or 0) > 1:
        status = "converged"
    return replace(result, status=status, evidence=evidence)


def _sensitivities(problem: DesignProblem, result: SearchResult) -> dict[str, float]:
    """From the multipliers: what the objective gains, part of itself, for each limit raised by one part of itself."""
    labels = problem.alternatives[0].labels
    if not labels or not result.feasible or result.value == 0.0:
        return {}
    smooth = problem.alternatives[0]
    multipliers = residuals(smooth, result.x).multipliers[: len(smooth.constraints(result.x)[0])]
    held = multipliers[: len(labels)].tolist()
    held[-1] += float(multipliers[len(labels) :].sum())
    return {label: value / abs(result.value) for label, value in zip(labels, held, strict=True) if value > 0.0}
