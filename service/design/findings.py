"""What is wrong with a design document, or worth knowing: a code with the values of its template."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from service.errors import InvalidInput

Severity = Literal["refusal", "warning"]

TEMPLATES: Mapping[str, tuple[str, str]] = {
    "design_not_a_document": ("the document must be {format}, got {value}", "correct the file"),
    "design_too_large": ("the document must have at most {most} bytes, got {value}", "leave out what is not needed"),
    "design_study_unknown": ("study must be one of {known}, got {value}", "name one of them"),
    "design_version_unknown": ("version must be {known}, got {value!r}", "state the version of the format"),
    "design_field_missing": ("{field} must be stated", "add it"),
    "design_field_unknown": ("{field} must not be stated here, known are {known}", "correct its spelling or remove it"),
    "design_not_a_number": ("{field} must be a number, got {value}", "correct the value"),
    "design_not_finite": ("{field} must be a finite number, got {value}", "correct the value"),
    "design_not_whole": ("{field} must be a whole number, got {value}", "correct the value"),
    "design_not_text": ("{field} must be a text, got {value}", "put it in quotes"),
    "design_not_a_flag": ("{field} must be true or false, got {value}", "correct the value"),
    "design_not_a_table": ("{field} must be a table, got {value}", "state it as a table with its own fields"),
    "design_not_a_list": ("{field} must be a list of {count} numbers, got {value}", "correct the list"),
    "design_not_names": ("{field} must be a list of {count} names, got {value}", "correct the list"),
    "design_not_a_choice": ("{field} must be one of {known}, got {value!r}", "choose one of them"),
    "design_out_of_range": ("{field} must be {rule}, got {value:g}", "correct the value"),
    "design_count_out_of_range": ("{field} must hold {rule}, got {value}", "state as many"),
    "design_bounds_crossed": (
        "{field} must state the lower bound first, got {lower:g} above {upper:g}",
        "exchange the two numbers",
    ),
    "design_not_rising": ("{field} must rise, got a step of {value:g}", "sort them, each once"),
    "design_energy_unreachable": (
        "{field} of {value:.6g} {unit} must be at most {most:.6g} {unit}, what the bounds allow",
        "lower the energy or widen the bounds",
    ),
    "design_name_unknown": ("{field} must be one of {known}, got {value!r}", "name one of them"),
    "design_name_twice": ("{field} must differ from the others, got {value!r} twice", "rename one of them"),
    "design_unit_missing": (
        "units.{quantity} must be stated, since {field} is a {quantity}",
        "add the unit, one of {known}",
    ),
    "design_unit_unknown": ("{field} must be one of {known}, got {value!r}", "choose one of them"),
    "design_weights": ("the weights must be 0 or more and not all 0, got {value}", "state how much each aim counts"),
    "design_speed_zero": ("{field} must not be 0", "state the speed: at rest nothing shakes and nothing is stored"),
    "design_nothing_to_vary": (
        "a design to optimise must leave something free, got {value}",
        "state [design] with bounds of what may change",
    ),
    "design_no_front": (
        "a front needs two responses to trade off, got {value}",
        "state two names at aim.front, or leave out the limit that fixes one of them",
    ),
    "design_infeasible_bounds": (
        "{limit} of {value:.6g} {unit} must be at least {least:.6g} {unit}, what the bounds allow",
        "raise the limit or widen the bounds",
    ),
    "flywheel_limit_implausible": (
        "the stress limit of {value:.6g} Pa is far below what any disc has at this speed, {typical:.6g} Pa",
        "check its unit",
    ),
    "flywheel_not_thin": (
        "plane stress is assumed, but {what} is {value:.3g}",
        "near such places the stresses of a real disc differ: check them by another method",
    ),
    "gear_hardness_unit": (
        "a hardness of {value:g} N/mm2 is low for steel: a number of Brinell units must be multiplied by 9.81",
        "check its unit",
    ),
    "gear_module_not_standard": (
        "a module of {value:g} mm is not among the standard ones, {known}",
        "take a standard module if the gear is cut with stock tools",
    ),
    "gear_undercut": (
        "{value:g} teeth are fewer than the {least:.3g} below which the pinion is undercut",
        "take more teeth or shift the profile",
    ),
    "gear_fast": ("the pitch line runs at {value:.3g} m/s, above 25 m/s", "dynamic factors of this kind end there"),
    "gear_teeth_ratio": (
        "whole teeth {teeth} and {other} give a ratio of {value:.6g} instead of {ratio:g}",
        "take a pinion whose teeth times the ratio are whole if the ratio must be exact",
    ),
    "gear_printed_model": (
        "the printed model is not sound mechanics: angles in radians, velocity in mm/s, penalties that hide limits",
        "use it to reproduce its tables, and model = sound for a design",
    ),
    "shaft_ill_conditioned": (
        "the sensors hardly tell the planes numbered {planes} apart, the condition is {value:.3g}",
        "expect large masses that oppose each other; leave out a plane or add a sensor",
    ),
    "shaft_silent_sensor": ("sensor {value} shows no vibration at all", "check that it is connected"),
    "shaft_nothing_to_gain": (
        "there is nothing to gain for the aim {value}: its worst accepted value is no worse than the best attainable",
        "its membership counts as 1; state other limits",
    ),
    "shaft_spread_dominates": (
        "the spread counts for {value:.3g} of the aim: an even vibration can be evenly bad",
        "give the energy or the largest more weight",
    ),
    "linkage_sharp_transmission": (
        "the links of dyad {joint} come within {value:.3g} degrees of a dead point",
        "joint forces grow there: keep at least 20 degrees",
    ),
    "linkage_body_not_real": (
        "link {field} with this design cannot be made as a rigid body: {value}",
        "correct its mass, centre or inertia",
    ),
    "linkage_no_three_points": (
        "link {field} cannot be stood for by three point masses without a negative one, the least is {value:.4g} kg",
        "judge it by its mass numbers",
    ),
    "design_present_breaks_limit": (
        "the present design breaks {limit}: {value:.6g} {unit} against {bound:.6g} {unit}",
        "the search begins elsewhere; look at the limit if the present design is known to work",
    ),
    "design_bounds_exclude_present": (
        "the present design lies outside the bounds: {field} is {value:.6g}, the bounds are {lower:.6g} to {upper:.6g}",
        "the search begins elsewhere; widen the bounds to have the present design among the candidates",
    ),
}


@dataclass(frozen=True)
class Finding:
    """One problem of a document. field: dotted path; params: values of the message's template."""

    code: str
    message: str
    advice: str
    severity: Severity = "refusal"
    field: str | None = None
    value: object = None
    params: Mapping[str, object] | None = None


def finding(
    code: str,
    *,
    field: str | None = None,
    value: object = None,
    severity: Severity = "refusal",
    params: Mapping[str, object] | None = None,
) -> Finding:
    """A finding by its code; params: what its template names besides field and value."""
    rule, advice = TEMPLATES[code]
    values = {"field": field, "value": value, **(params or {})}
    return Finding(code, rule.format(**values), advice.format(**values), severity, field, value, values)


def of_error(error: InvalidInput, prefix: str = "") -> Finding:
    """A refusal of the numerics as a finding; prefix: path of the table that the numerics call theirs."""
    field = ".".join(part for part in (prefix, error.field) if part) or None
    params = getattr(error, "params", None)
    return Finding(error.code, error.message, error.advice or "", "refusal", field, error.value, params)


class RefusedDesign(InvalidInput):
    """A design document that breaks a rule; findings: all that were found."""

    code = "design_refused"

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings = tuple(findings)
        first = self.findings[0]
        super().__init__(
            first.message, code=first.code, field=first.field, value=_plain(first.value), advice=first.advice
        )


def _plain(value: object) -> object:
    """A value that can be shown in a problem document."""
    return value if isinstance(value, str | int | bool) or value is None else str(value)
