"""What is stored and cannot be read: listed, and mended where that needs no guess."""

from __future__ import annotations

from db.store import Store
from service.model.base import document
from service.runtime.context import AppContext


@document
class UnreadablePart:
    """A stored document that cannot be read."""

    kind: str
    """Table: machine, catalogue, session, run, correction, plan, stop ..."""
    key: str
    """Identifier of the row."""
    field: str
    """Column and field that break a rule, such as run.readings[0].scatter."""
    rule: str
    """The rule."""
    value: str | None
    """The value, shortened; null where it is missing."""


@document
class Repaired:
    """What a repair found."""

    mended: tuple[tuple[str, str], ...]
    """Kind and key of each thing that was mended."""
    unreadable: tuple[UnreadablePart, ...]
    """What cannot be read still."""


def repair(work: AppContext, *, mend: bool = True) -> Repaired:
    """Mend what needs no guess, all in one unit of work with its lines of history, and list what is unreadable.

    Mended is a scatter that is rounding error: it becomes null. mend: False only lists.
    """
    mended: tuple[tuple[str, str], ...] = ()
    if mend:
        with work.write() as store:
            mended = tuple(store.mend())
    with work.read() as store:
        return Repaired(mended=mended, unreadable=_unreadable(store))


def _unreadable(store: Store) -> tuple[UnreadablePart, ...]:
    return tuple(
        UnreadablePart(
            kind=fault.table,
            key=fault.key,
            field=".".join(part for part in (fault.column, fault.field) if part),
            rule=fault.rule,
            value=fault.value,
        )
        for fault in store.faults()
    )
