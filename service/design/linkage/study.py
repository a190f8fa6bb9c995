"""The linkage study: shaking force, shaking moment and driving torque of any planar linkage of dyads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from service.design.findings import Finding, RefusedDesign, refusal, warning
from service.design.linkage.case import LinkageCase, read_case
from service.design.linkage.mass_designs import PointMasses
from service.design.linkage.mass_limits import angle_check
from service.design.linkage.problem import linkage_problem
from service.design.reading import Asked
from service.design.study import Curve, DesignProblem, Document, LimitCheck, Scalar, Simulation, limit_check
from service.errors import NumericsError
from service.mechanics.bodies import Body, as_three_points, check_body
from service.mechanics.dynamics import Quantity
from service.mechanics.reactions import reactions
from service.messages import Message

SHARP = math.radians(20.0)
"""An angle between the links of a dyad nearer than this to a dead point is warned of."""
_UNITS: Mapping[Quantity, str] = {"force": "force", "moment": "moment", "torque": "moment"}


class LinkageStudy:
    """Masses of a linkage and what they do to its frame."""

    name = "linkage"

    def check(self, document: Document) -> tuple[Finding, ...]:
        """Everything that is wrong with a document, and warnings."""
        case, problems = read_case(document)
        return tuple(problems.found) if case is None else (*problems.found, *_warnings(case))

    def asked(self, document: Document) -> Mapping[str, Asked]:
        """The fields of a document by path, with their quantities and choices."""
        return read_case(document)[1].asked

    def simulate(self, document: Document) -> Simulation:
        """Responses of the design; raises RefusedDesign."""
        case = _read(document)
        at = reactions(case.stated.linkage, case.moving, case.p)
        force = case.features.shaking_force(case.p)
        moment, torque = case.features.shaking_moment(case.p), case.features.driving_torque(case.p)
        peaks = [
            Scalar(f"joint_force_peak.{one.joint} {one.by}-{one.on}", float(np.abs(one.force).max()), "force")
            for one in at.joints
        ]
        extremes = [
            Scalar("force_peak", float(np.abs(force).max()), "force"),
            Scalar("moment_least", float(moment.min()), "moment"),
            Scalar("moment_greatest", float(moment.max()), "moment"),
            Scalar("torque_least", float(torque.min()), "moment"),
            Scalar("torque_greatest", float(torque.max()), "moment"),
        ]
        angles = case.moving.angles
        curves = [
            Curve("force_x", angles, force.real, "angle", "force"),
            Curve("force_y", angles, force.imag, "angle", "force"),
            Curve("moment", angles, moment, "angle", "moment"),
            Curve("torque", angles, torque, "angle", "moment"),
        ]
        return Simulation(
            scalars=(*_means(case), *extremes, *_swings(case), *peaks),
            curves=tuple(curves),
            limits=_limits(case),
            warnings=_warnings(case),
            drawing=_drawing(case),
        )

    def problem(self, document: Document) -> DesignProblem:
        """The document as an optimisation problem; raises RefusedDesign."""
        case = _read(document)
        if case.design is None or not case.design.variation.variables:
            raise refusal(Message("design_nothing_to_vary", field="design"))
        return linkage_problem(case, case.design, document)


def _read(document: Document) -> LinkageCase:
    case, problems = read_case(document)
    problems.raise_any()
    if case is None:
        raise RefusedDesign(problems.found)
    return case


def _means(case: LinkageCase) -> list[Scalar]:
    """Root mean squares, their ratios to the linkage without the design, the aim and the mass added."""
    found = []
    for name, quantity in _UNITS.items():
        now, before = case.rms(name, case.p), case.base_rms[name]
        found.append(Scalar(f"{name}_rms", now, quantity))
        found.append(Scalar(f"{name}_ratio", now / before if before > 0.0 else math.nan))
    found.append(Scalar("aim", float(case.aimed(case.p))))
    found.append(Scalar("mass_added", float((case.p - case.base)[::4].sum()), "mass"))
    return found


def _swings(case: LinkageCase) -> list[Scalar]:
    """Swing of every link that does not turn, and the least and greatest angle between the links of each dyad."""
    found = []
    for k, link in enumerate(case.stated.linkage.links):
        directions = np.unwrap(np.angle(case.moving.axis[k]))
        if k != case.stated.linkage.layout.crank and np.ptp(directions) < 1.9 * math.pi:
            found.append(Scalar(f"swing.{link.name}", float(np.ptp(directions)), "angle"))
    for pair, angle in zip(case.stated.linkage.layout.pairs, case.moving.transmission, strict=True):
        found.append(Scalar(f"transmission_least.{pair.joint}", float(angle.min()), "angle"))
        found.append(Scalar(f"transmission_greatest.{pair.joint}", float(angle.max()), "angle"))
    return found


def _body(case: LinkageCase, link: int) -> Body:
    return Body(*case.p[4 * link : 4 * link + 4].tolist())


def _limits(case: LinkageCase) -> tuple[LimitCheck, ...]:
    if case.design is None:
        return ()
    links = case.stated.linkage.links
    found = [limit.checked(_body(case, limit.link), links[limit.link].name) for limit in case.design.limits]
    for link, lower, upper in case.design.angles:
        found.append(angle_check(_body(case, link), lower, upper, links[link].name))
    variables = case.design.variation.variables
    for one, value in zip(variables, case.design.present.tolist(), strict=True):
        if case.design.variation.linear:
            continue
        found.append(limit_check("lower_bound", value, one.lower, "at_least", one.quantity, one.name))
        found.append(limit_check("upper_bound", value, one.upper, "at_most", one.quantity, one.name))
    return tuple(found)


def _warnings(case: LinkageCase) -> tuple[Finding, ...]:
    found = []
    for pair, angle in zip(case.stated.linkage.layout.pairs, case.moving.transmission, strict=True):
        margin = np.minimum(angle, math.pi - angle)
        if margin.min() < SHARP:
            found.append(
                warning(
                    Message(
                        "linkage_sharp_transmission",
                        field=f"linkage.dyad.{pair.joint}",
                        value=math.degrees(margin.min()),
                        joint=pair.joint,
                    )
                )
            )
    for k, link in enumerate(case.stated.linkage.links):
        body = _body(case, k)
        try:
            check_body(body, f"link {link.name}")
        except NumericsError as refused:
            found.append(
                warning(Message("linkage_body_not_real", field=link.name, value=refused.data or refused.message))
            )
        if _in_points(case) and as_three_points(body)[0].min() < 0.0:
            least = float(as_three_points(body)[0].min())
            found.append(warning(Message("linkage_no_three_points", field=link.name, value=least)))
    return tuple(found)


def _in_points(case: LinkageCase) -> bool:
    return case.design is not None and isinstance(case.design.variation, PointMasses)


def _drawing(case: LinkageCase) -> dict[str, Any]:
    """Joints, mass centres and discs over the turn, for the animation; lengths in m, complex as pairs."""
    links = case.stated.linkage.links
    centres = [_body(case, k).centre for k in range(len(links))]
    return {
        "kind": "linkage",
        "joints": {name: _pairs(place) for name, place in case.moving.points.items()},
        "links": [{"name": link.name, "points": list(link.points)} for link in links],
        "ground": list(case.stated.linkage.ground),
        "centres": {
            link.name: _pairs(case.moving.origin[k] + case.moving.axis[k] * centres[k]) for k, link in enumerate(links)
        },
    }


def _pairs(places: Any) -> list[list[float]]:
    return [[round(float(one.real), 9), round(float(one.imag), 9)] for one in places]
