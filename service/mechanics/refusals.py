"""Refusals of the mechanics: one code, one rule and one advice for each, with the values as parameters."""

from __future__ import annotations

from collections.abc import Mapping

from service.errors import NumericsError

TEMPLATES: Mapping[str, tuple[str, str]] = {
    "linkage_without_dyad": ("a linkage must have at least one dyad, got none", "state [[dyad]] with joint and links"),
    "linkage_name_twice": ("{kind} names must differ, got {value!r} twice", "rename one of them"),
    "linkage_unknown_link": ("link must be one of {known}, got {value!r}", "name a link that is stated"),
    "linkage_crank_pivot": (
        "the crank must have exactly one point on the ground, got {value}",
        "give the crank link one point with the name of a ground point",
    ),
    "linkage_joint_missing": (
        "link {link} of dyad {joint} must hold the point {joint}, got {value}",
        "state the point with its local coordinates, or correct the dyad",
    ),
    "linkage_dyad_support": (
        "link {link} of dyad {joint} must have exactly one point that is placed before it, got {value}",
        "list the dyads in the order in which they can be placed; a dyad needs one placed point on each link",
    ),
    "linkage_link_unplaced": ("every link must be the crank or belong to one dyad, got {value} besides", "add a dyad"),
    "linkage_link_twice": ("a link must be placed once, got {value} again in dyad {joint}", "correct the dyad"),
    "linkage_zero_length": (
        "points {first} and {second} of link {link} must lie apart, got {value:g} m",
        "correct their local coordinates",
    ),
    "linkage_does_not_close": (
        "dyad {joint} must close over the whole turn, got a gap at a crank angle of {value:.6g} degrees",
        "it closes for {closes}; change lengths or ground points",
    ),
    "linkage_singular": (
        "the links of dyad {joint} must not lie in line, got {margin:.3g} degrees between them at a crank angle of "
        "{value:.6g} degrees",
        "change lengths or ground points: at a dead point forces have no limit",
    ),
    "speed_zero": ("the crank speed must not be 0", "state the speed: at rest nothing shakes"),
    "not_finite": ("{field} must be a finite number, got {value}", "correct the value"),
    "body_mass_negative": ("the mass of {body} must be 0 or more, got {value:g} kg", "correct the mass"),
    "body_inertia_impossible": (
        "the inertia of {body} about its own origin must be at least mass times squared centre radius, {least:.6g} "
        "kg m2, got {value:.6g} kg m2",
        "state the inertia about the point you name, or correct the mass centre",
    ),
}


class Refusal(NumericsError):
    """Input that the mechanics cannot take; params: the values of the message's template."""

    def __init__(self, code: str, *, field: str | None = None, value: object = None, **params: object) -> None:
        rule, advice = TEMPLATES[code]
        self.params = {"field": field, "value": value, **params}
        super().__init__(
            rule.format(**self.params), code=code, field=field, value=value, advice=advice.format(**self.params)
        )
