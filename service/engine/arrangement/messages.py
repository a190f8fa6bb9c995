"""What an answer says: one template a code, with named values."""

from __future__ import annotations

from collections.abc import Mapping

_STATUS = {
    "optimal": "proved: no arrangement within the limits is better",
    "fewest": "proved: no arrangement with fewer moves meets the limit, and none with as few is better",
    "within_uncertainty": "no arrangement can be better by more than {gap:.3g}, less than the scale can tell",
    "limit_reached": "stopped before the proof: up to {gap:.3g} better is not excluded",
    "fewest_not_proved": "stopped before the proof: {moves:g} moves meet the limit, fewer than {bound:g} do not",
    "none_found": "stopped before an arrangement within the limits was found",
    "infeasible": "no arrangement keeps the limits",
    "all_equal": "proved: all parts are equal, any order is as good",
}

_REASONS = {
    "no_part_fits": "no part fits place {place}: weigh one of its kind, or let the place be empty",
    "too_few_parts": "{places:g} places must be filled and only {parts:g} can be with the parts that fit: add "
    "parts, or let places be empty",
    "max_moves_excludes": "no arrangement keeps the limits with at most {limit:g} moves: allow more moves",
    "max_new_parts_excludes": "no arrangement keeps the limits with at most {limit:g} new parts: allow more",
    "group_limits_exclude": "no arrangement keeps the differences of masses within the groups: weigh further parts, or "
    "allow a greater difference",
    "sets_exclude": "no choice of whole sets fills the places: take a set apart, or add parts",
    "limits_exclude_each_other": "the limits exclude each other: leave one of moves, new parts, groups and sets out",
    "limit_not_met": "no arrangement meets the limit {limit:.6g}: the best leaves {best:.6g}",
    "none_found": "no arrangement within the limits was found in the time: allow more time, or fewer limits",
    "no_mass_meets": "no arrangement with stock masses meets the limit {limit:.6g}",
}


def status_message(code: str, **values: float) -> str:
    """Sentence of a status."""
    return _STATUS[code].format(**values)


def reason_message(code: str, values: Mapping[str, float | str]) -> str:
    """Sentence of a reason."""
    return _REASONS[code].format(**values)
