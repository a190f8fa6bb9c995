"""Reasons why frames gave no reading: what each means, what to do, and the table that tells them."""

from __future__ import annotations

from collections.abc import Mapping

REASONS: Mapping[str, str] = {
    "foreign": "of a message or a node that the mapping does not name",
    "other_node": "of a mapped message, but not from the node that was heard first; state `node` in the mapping",
    "not_data": "remote request or error frame",
    "wrong_length": "too short for the mapped signals; see the message's length in the DBC",
    "undecodable": "not what the DBC describes",
    "out_of_range": "a value outside the range of the DBC or the mapping",
    "not_valid": "the balancer's own flag says that the value does not hold",
    "not_available": "the value stands for missing or error: named so in the DBC, J1939, all bits set, or not a number",
    "doubled": "its counter is that of the frame before",
    "late": "its counter is behind",
    "unpaired": "amplitude without phase, or phase without amplitude, of one round",
    "incomplete": "a message of several frames that did not all come",
}
"""What each reason means, in the order of the table."""
FOREIGN = frozenset(("foreign", "other_node"))
"""Of these nothing was expected: they do not count as refused."""


def counted(counts: Mapping[str, int]) -> dict[str, int]:
    """The reasons that there were, in the order of the table."""
    return {reason: counts[reason] for reason in REASONS if counts.get(reason)}


def in_short(counts: Mapping[str, int]) -> str:
    """The reasons in a few words, for a status line: `out_of_range 4, foreign 12`."""
    return ", ".join(f"{reason} {count}" for reason, count in counted(counts).items())


def table(counts: Mapping[str, int]) -> list[str]:
    """A line for each reason, with what it means."""
    found = counted(counts)
    width = max((len(str(count)) for count in found.values()), default=0)
    longest = max((len(reason) for reason in found), default=0)
    return [f"  {count:>{width}}  {reason:<{longest}}  {REASONS[reason]}" for reason, count in found.items()]
