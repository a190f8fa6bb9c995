"""What an answer says: one text of the catalogue for each status and each reason, with named values."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from service.balancing.arrangement import ArrangementResult
from service.messages import Message

Details = Mapping[str, float | str]

_REASONS: dict[str, Callable[[Details], Message]] = {
    "no_part_fits": lambda d: Message("no_part_fits", place=d["place"]),
    "too_few_parts": lambda d: Message("too_few_parts", places=d["places"], parts=d["parts"]),
    "max_moves_excludes": lambda d: Message("max_moves_excludes", limit=d["limit"]),
    "max_new_parts_excludes": lambda d: Message("max_new_parts_excludes", limit=d["limit"]),
    "group_limits_exclude": lambda _: Message("group_limits_exclude"),
    "sets_exclude": lambda _: Message("sets_exclude"),
    "limits_exclude_each_other": lambda _: Message("limits_exclude_each_other"),
    "limit_not_met": lambda d: Message("limit_not_met", limit=d["limit"], best=d["best"]),
    "none_found": lambda _: Message("none_found"),
    "no_mass_meets": lambda d: Message("no_mass_meets", limit=d["limit"]),
}


def status_message(result: ArrangementResult) -> Message:
    """What is proved of a result."""
    if result.arrangement is None:
        return Message("arrangement.infeasible") if result.status == "infeasible" else Message("arrangement.none_found")
    if result.code:
        return Message("arrangement.all_equal")
    if result.moves_bound is not None:
        if result.status == "optimal":
            return Message("arrangement.fewest")
        return Message("arrangement.fewest_not_proved", moves=result.moves, bound=result.moves_bound)
    if result.status == "optimal":
        return Message("arrangement.optimal")
    if result.status == "within_uncertainty":
        return Message("arrangement.within_uncertainty", gap=result.gap)
    return Message("arrangement.limit_reached", gap=result.gap)


def reason_message(code: str, details: Details) -> Message:
    """Why there is no arrangement."""
    return _REASONS[code](details)
