"""What concurrent clients asked and were answered, and whether one service could have answered so.

The events are of one session, one box, one source: a round. Times are of one clock; an event without an answer may have
been done or not.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["note", "run", "fit", "unfit", "read", "stock", "read_stock", "bind", "read_source", "readings"]
CHANGES: tuple[Kind, ...] = ("note", "run", "fit", "unfit")
"""What makes a new version of the session."""


@dataclass(frozen=True)
class Event:
    """One request: who asked what, when, and what was answered; status None: nothing was.

    key: the idempotency key. sent and got hold, by kind: note: `note`, `if_match` | `version`, `note`. run: | `id`.
    fit, unfit: |. read: | `version`, `note`, `runs` (ids), `fitted`, `fitted_plans` (ids of plans that say they are
    fitted). stock: `pieces` |. read_stock: | `on_hand`, `moved` (sum of all movements). bind: `machine` |.
    read_source: | `machine`. readings: `sequences` | `accepted`, `duplicates`.
    """

    client: int
    kind: Kind
    begun: float
    ended: float = math.inf
    status: int | None = None
    key: str | None = None
    sent: Mapping[str, Any] = field(default_factory=dict)
    got: Mapping[str, Any] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        """Whether it was answered that it was done."""
        return self.status is not None and 200 <= self.status < 300

    @property
    def unknown(self) -> bool:
        """Whether it may have been done."""
        return self.status is None or self.status >= 500


def check(events: Sequence[Event], *, killed: bool) -> list[str]:
    """Everything that no order of the requests one after the other explains; the last events read what is left.

    killed: services were killed meanwhile, so that requests may have no answer, or 503.
    """
    found = itertools.chain(
        _failures(events, killed=killed),
        _torn(events),
        _lost(events),
        _doubled(events),
        _versions(events),
        _register(events),
    )
    return list(found)


def _failures(events: Iterable[Event], *, killed: bool) -> Iterator[str]:
    for event in events:
        if event.status is None and not killed:
            yield f"no answer: {event.kind} of client {event.client}"
        if event.status is not None and event.status >= 500 and not (killed and event.status == 503):
            yield f"answered {event.status}: {event.kind} of client {event.client}"


def _torn(events: Iterable[Event]) -> Iterator[str]:
    """Answers that are put together from more than one moment."""
    seen: dict[int, Mapping[str, Any]] = {}
    for event in _done(events, "read"):
        got = event.got
        if got["fitted_plans"] != ([got["fitted"]] if got["fitted"] else []):
            yield f"torn read: version {got['version']} has {got['fitted']} fitted, its plans say {got['fitted_plans']}"
        if seen.setdefault(got["version"], got) != got:
            yield f"torn read: version {got['version']} was read with two contents"
    for event in _done(events, "note"):
        read = seen.get(event.got["version"])
        if read is not None and read["note"] != event.sent["note"]:
            yield f"torn read: version {event.got['version']} has another note than the change that made it"
    for event in _done(events, "read_stock"):
        if event.got["on_hand"] != event.got["moved"]:
            yield f"torn read: {event.got['on_hand']} pieces on hand, the movements come to {event.got['moved']}"


def _lost(events: Sequence[Event]) -> Iterator[str]:
    """What was acknowledged and is not there."""
    won = Counter(event.sent["if_match"] for event in _done(events, "note"))
    yield from (
        f"lost update: {count} changes made on version {version}" for version, count in won.items() if count > 1
    )
    last = _last(events, "read")
    if last is not None:
        runs = {event.got["id"] for event in _done(events, "run")}
        yield from (f"lost: run {run} was acknowledged" for run in sorted(runs - set(last["runs"])))
        notes = {event.got["version"]: event.sent["note"] for event in _done(events, "note")}
        unknown = {event.sent["note"] for event in events if event.kind == "note" and event.unknown}
        if notes and last["note"] != notes[max(notes)] and last["note"] not in unknown:
            yield f"lost update: the note is {last['note']!r}, the last change made it {notes[max(notes)]!r}"


def _doubled(events: Sequence[Event]) -> Iterator[str]:
    """What was done more than once."""
    answers: defaultdict[str, set[str]] = defaultdict(set)
    for event in _done(events, "run"):
        answers[str(event.key)].add(event.got["id"])
    yield from (f"doubled: key {key} has the runs {sorted(ids)}" for key, ids in answers.items() if len(ids) > 1)
    last, stock = _last(events, "read"), _last(events, "read_stock")
    asked = {event.key for event in events if event.kind == "run" and (event.done or event.unknown)}
    first: Sequence[str] = next((event.got["runs"] for event in _done(events, "read")), [])
    if last is not None and len(last["runs"]) > len(asked) + len(first):
        yield f"doubled: {len(asked)} runs were asked for, {len(last['runs']) - len(first)} are there"
    if stock is not None:
        yield from _stock_doubled(events, stock["on_hand"])
    accepted: Counter[int] = Counter()
    for event in _done(events, "readings"):
        if event.got["accepted"] + event.got["duplicates"] != len(event.sent["sequences"]):
            yield f"doubled: {event.got} of {len(event.sent['sequences'])} readings"
        if event.got["accepted"] == len(event.sent["sequences"]):
            accepted.update(event.sent["sequences"])
    yield from (f"doubled: reading {number} was new {count} times" for number, count in accepted.items() if count > 1)


def _stock_doubled(events: Sequence[Event], on_hand: int) -> Iterator[str]:
    """Each key books once; those without an answer may have."""
    booked = {event.key: event.sent["pieces"] for event in _done(events, "stock")}
    maybe = {event.key: event.sent["pieces"] for event in events if event.kind == "stock" and event.unknown}
    surely = sum(booked.values())
    possible = {surely}
    for key, pieces in maybe.items():
        if key not in booked:
            possible |= {total + pieces for total in possible}
    if on_hand not in possible:
        yield f"doubled or lost: {surely} pieces were booked, {on_hand} are on hand"


def _versions(events: Sequence[Event]) -> Iterator[str]:
    """Versions that are skipped, given twice, or older than what was seen before."""
    for event in _done(events, "note"):
        if event.got["version"] != event.sent["if_match"] + 1:
            yield f"version skipped: a change on {event.sent['if_match']} made {event.got['version']}"
    seen = [event for event in events if event.done and "version" in event.got]
    by_end = sorted(seen, key=lambda event: event.ended)
    newest, at = 0, 0
    for event in sorted(seen, key=lambda event: event.begun):
        while at < len(by_end) and by_end[at].ended < event.begun:
            newest, at = max(newest, by_end[at].got["version"]), at + 1
        if event.got["version"] < newest:
            yield f"stale: version {event.got['version']} was answered after {newest}"
    reads = _done(events, "read")
    if len(reads) > 1:
        grown = reads[-1].got["version"] - reads[0].got["version"]
        surely = len({(event.kind, event.key) for event in events if event.kind in CHANGES and event.done})
        maybe = sum(event.kind in CHANGES and event.unknown for event in events)
        if not surely <= grown <= surely + maybe:
            yield f"version skipped: {surely} changes were made, {maybe} maybe, the version grew by {grown}"


def _register(events: Sequence[Event]) -> Iterator[str]:
    """What a source is bound to, as it is read: by the last binding, or one under way."""
    writes = [event for event in events if event.kind == "bind" and (event.done or event.unknown)]
    for read in _done(events, "read_source"):
        before = [write for write in writes if write.begun <= read.ended]
        if before and not any(
            write.sent["machine"] == read.got["machine"] and not _overwritten(write, read, before) for write in before
        ):
            yield f"lost update: the source is bound to {read.got['machine']}, which was overwritten before"


def _overwritten(write: Event, read: Event, writes: Iterable[Event]) -> bool:
    """Whether another write surely came between this one and the read."""
    return any(other.done and write.ended < other.begun and other.ended < read.begun for other in writes)


def _done(events: Iterable[Event], kind: Kind) -> list[Event]:
    return [event for event in events if event.kind == kind and event.done]


def _last(events: Sequence[Event], kind: Kind) -> Mapping[str, Any] | None:
    found = _done(events, kind)
    return found[-1].got if found else None
