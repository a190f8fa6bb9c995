"""Published designs evaluated again: what they claim, what they do, which limits they break, and the optimum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from service.design.documents import patched
from service.design.heading import Published, begin
from service.design.optimising import Outcome, optimise
from service.design.registry import study_of
from service.design.study import Document, LimitCheck, Simulation
from service.design.units import UNITS, unit_of

CHANGE = "_change"
"""Ending of a claim about a response: its change from the document's own design, part of that."""


@dataclass(frozen=True)
class ClaimCheck:
    """A claimed response and what it is, both in SI; deviation: part of the claim."""

    response: str
    quantity: str
    claimed: float
    computed: float

    @property
    def deviation(self) -> float:
        """How far the computed value lies from the claim, as part of it."""
        return (self.computed - self.claimed) / abs(self.claimed) if self.claimed != 0.0 else self.computed


@dataclass(frozen=True)
class PublishedVerdict:
    """A published design. objective: its value of what is optimised; optimum: the best of the same problem."""

    name: str
    claims: tuple[ClaimCheck, ...]
    broken: tuple[LimitCheck, ...]
    objective: float
    simulation: Simulation
    optimum: Outcome

    @property
    def better(self) -> bool:
        """Whether the optimum is better, or the design breaks a limit that the optimum keeps."""
        return bool(self.broken) or self.optimum.value != self.objective


@dataclass(frozen=True)
class Verdict:
    """What is to be said about the published designs of a document."""

    title: str
    objective: str
    optimum: Outcome
    designs: tuple[PublishedVerdict, ...]


def verdict(document: Document, seed: int = 1, steps: int | None = None) -> Verdict:
    """Evaluate the published designs of a document and optimise it by the default method; raises RefusedDesign."""
    study = study_of(document)
    base = study.simulate(document)
    _, _, heading = begin(document)
    optimum = optimise(document, seed=seed, steps=steps)
    found = []
    for published in heading.published:
        patched_document = patched(document, published.patch)
        simulation = study.simulate(patched_document)
        best = optimise(patched_document, seed=seed, steps=steps) if published.problem else optimum
        found.append(
            PublishedVerdict(
                published.name,
                tuple(_claims(published, simulation, base, heading.units)),
                tuple(one for one in simulation.limits if one.violated),
                simulation.value(optimum.objective),
                simulation,
                best,
            )
        )
    return Verdict(heading.title, optimum.objective, optimum, tuple(found))


def _claims(
    published: Published, simulation: Simulation, base: Simulation, units: Mapping[str, str]
) -> list[ClaimCheck]:
    found = []
    for name, claimed in published.claims.items():
        if name.endswith(CHANGE):
            response = name.removesuffix(CHANGE)
            change = simulation.value(response) / base.value(response) - 1.0
            found.append(ClaimCheck(name, "1", claimed, change))
            continue
        scalar = next((one for one in simulation.scalars if one.name == name), None)
        if scalar is None:
            continue
        factor = 1.0 if scalar.quantity == "1" else UNITS[scalar.quantity][unit_of(scalar.quantity, units)]
        found.append(ClaimCheck(name, scalar.quantity, claimed * factor, scalar.value))
    return found
