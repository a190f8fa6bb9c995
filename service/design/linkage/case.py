"""A linkage document, read: the chain in motion, what may change, and the aim as a function of the masses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from service.design.findings import of_error
from service.design.heading import Heading, begin
from service.design.linkage.chain_reading import StatedLinkage, read_linkage
from service.design.linkage.stated_design import StatedAim, StatedDesign, read_aim, read_design
from service.design.reading import Problems, refused
from service.design.study import Document
from service.errors import NumericsError
from service.mechanics.bodies import FloatArray
from service.mechanics.dynamics import Features, Quantity, features, mass_numbers
from service.mechanics.kinematics import Motion, motion, require_turning, whole_turn

SMALLEST = 1e-12
"""A root mean square below this part of its scale is taken as this when it is divided by."""


@dataclass(frozen=True)
class LinkageCase:
    """A document that was read without a refusal. p: mass numbers (4 links,) of its design."""

    heading: Heading
    stated: StatedLinkage
    design: StatedDesign | None
    aim: StatedAim
    moving: Motion

    @cached_property
    def features(self) -> Features:
        """What each mass number gives over the turn."""
        return features(self.stated.linkage, self.moving)

    @cached_property
    def base(self) -> FloatArray:
        """Mass numbers (4 links,) of the linkage without the design."""
        return mass_numbers(self.stated.linkage)

    @property
    def p(self) -> FloatArray:
        """Mass numbers (4 links,) of the design."""
        return self.base if self.design is None else self.design.p

    @cached_property
    def base_rms(self) -> Mapping[Quantity, float]:
        """Root mean squares over the turn without the design."""
        return {name: self.rms(name, self.base) for name in self.aim.weights}

    @cached_property
    def scales(self) -> Mapping[Quantity, float]:
        """What each quantity is divided by in the aim: N, N m."""
        if self.aim.scale == "none":
            return dict.fromkeys(self.aim.weights, 1.0)
        if self.aim.scale == "present":
            return {name: value or 1.0 for name, value in self.base_rms.items()}
        layout = self.stated.linkage.layout
        crank = self.stated.linkage.links[layout.crank]
        radius = max(abs(place - layout.pivot.on_link) for place in crank.points.values())
        force = crank.body.mass * radius * self.stated.speed**2
        return {"force": force, "moment": force * radius, "torque": force * radius}

    def rms(self, quantity: Quantity, p: FloatArray) -> float:
        """Root mean square over the turn for mass numbers p (4 links,)."""
        return float(np.sqrt(self.features.mean_square(quantity, p)))

    def aimed(self, p: FloatArray) -> FloatArray:
        """The weighted aim (...) for mass numbers p (..., 4 links)."""
        total = np.zeros(p.shape[:-1])
        for name, weight in self.aim.weights.items():
            if weight > 0.0:
                ratio = self.features.mean_square(name, p) / self.scales[name] ** 2
                total += weight * ratio ** (self.aim.power / 2.0)
        return total

    def aimed_with_slope(self, p: FloatArray) -> tuple[float, FloatArray]:
        """The aim and its slopes (4 links,); the square of a single root, which is smooth and has the same optimum."""
        total, slope = 0.0, np.zeros_like(p)
        counted = [(name, weight) for name, weight in self.aim.weights.items() if weight > 0.0]
        power = 2 if len(counted) == 1 else self.aim.power
        for name, weight in counted:
            gram = self.features.gram[name] / self.scales[name] ** 2
            along = gram @ p
            square = max(float(p @ along), SMALLEST**2)
            if power == 2:
                total += weight * square
                slope += 2.0 * weight * along
            else:
                total += weight * float(np.sqrt(square))
                slope += weight * along / np.sqrt(square)
        return total, slope


def read_case(document: Document) -> tuple[LinkageCase | None, Problems]:
    """The case of a document, or None, and what was noted while it was read."""
    root, problems, heading = begin(document)
    stated = read_linkage(root)
    aim = read_aim(root)
    design = None
    if stated is not None:
        design = read_design(root, stated)
    else:
        root.table("design", optional=True)
    root.close()
    if stated is None or refused(problems):
        return None, problems
    try:
        require_turning(stated.linkage)
        moving = motion(stated.linkage, whole_turn(stated.samples), stated.speed)
    except NumericsError as error:
        problems.found.append(of_error(error, "linkage"))
        return None, problems
    return LinkageCase(heading, stated, design, aim, moving), problems
