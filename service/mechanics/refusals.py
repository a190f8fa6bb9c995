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
    "disc_radius": (
        "the inner radius must be above 0, got {value:g} m",
        "a solid disc has another boundary condition: state a hole",
    ),
    "disc_radii_order": ("the control radii must rise, got a step of {value:g} m", "sort them, each once"),
    "disc_poisson": ("the Poisson ratio must be from 0 to below 0.5, got {value:g}", "correct the value"),
    "disc_density": ("the density must be above 0, got {value:g} kg/m3", "correct the value"),
    "disc_thickness": (
        "the thickness must be above 0 everywhere on the curve, got {value:g} m",
        "raise the control thicknesses",
    ),
    "disc_thickness_count": (
        "the control thicknesses must be {count} finite numbers, one a control radius, got {value}",
        "state one for each",
    ),
    "gear_not_positive": ("{field} must be a finite number above 0, got {value:g}", "correct the value"),
    "gear_ratio": ("the ratio must be at least 1, got {value:g}", "state the ratio of a gear that slows down"),
    "gear_overlap": ("the overlap ratio must be at least 1, got {value:g}", "below it the pair loses contact"),
    "gear_helix": (
        "the helix angle must be from 0 to below 45 degrees, got {value:g} degrees",
        "0 is a spur gear; take a smaller angle",
    ),
    "shaft_shapes": (
        "the influence must have one row a sensor, got {value} rows for {sensors} sensors",
        "state a row for every sensor in the order of the vibration",
    ),
    "shaft_too_few_sensors": (
        "there must be at least as many sensors as planes, got {value} sensors for {planes} planes",
        "measure at more places or speeds, or leave out planes",
    ),
    "shaft_planes_alike": (
        "the sensors must tell the planes apart, got a condition of {value:.3g} for the planes numbered {planes}",
        "leave out one of these planes or add a sensor near one of them",
    ),
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
