"""The checker finds each kind of fault in a history that was made up with it, and none in one that is in order."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from service.chaos.history_checks import Event, Kind, check

History = list[Event]


class Service:
    """A service that does one request after the other, and writes down what it was asked and answered."""

    def __init__(self) -> None:
        self.version, self.note, self.runs, self.fitted, self.stock, self.machine = 1, "", ["r0"], "", 0, "m1"
        self.sequences: set[int] = set()
        self.events: History = []

    def _event(self, kind: Kind, key: str | None, sent: dict[str, Any], got: dict[str, Any], status: int) -> None:
        at = 10.0 * len(self.events)
        self.events.append(Event(1, kind, at, at + 9.0, status, key, sent, got))

    def read(self) -> None:
        fitted = [self.fitted] if self.fitted else []
        got = {"version": self.version, "note": self.note, "runs": list(self.runs), "fitted": self.fitted}
        self._event("read", None, {}, {**got, "fitted_plans": fitted}, 200)
        self._event("read_stock", None, {}, {"on_hand": self.stock, "moved": self.stock}, 200)
        self._event("read_source", None, {}, {"machine": self.machine}, 200)

    def change_note(self, note: str) -> None:
        seen, self.version, self.note = self.version, self.version + 1, note
        self._event("note", note, {"note": note, "if_match": seen}, {"version": self.version, "note": note}, 200)

    def add_run(self, key: str) -> None:
        if f"r-{key}" not in self.runs:
            self.runs.append(f"r-{key}")
            self.version += 1
        self._event("run", key, {}, {"id": f"r-{key}"}, 201)

    def fit(self, plan: str) -> None:
        self.version, self.fitted = self.version + 1, plan
        self._event("fit", f"fit-{plan}", {}, {}, 200)

    def book(self, key: str, pieces: int) -> None:
        self.stock += pieces
        self._event("stock", key, {"pieces": pieces}, {}, 201)

    def bind(self, machine: str) -> None:
        self.machine = machine
        self._event("bind", None, {"machine": machine}, {}, 200)

    def send(self, *sequences: int) -> None:
        new = set(sequences) - self.sequences
        self.sequences |= new
        got = {"accepted": len(new), "duplicates": len(sequences) - len(new)}
        self._event("readings", None, {"sequences": list(sequences)}, got, 201)


def in_order() -> History:
    """A history with every kind of request; that of key `twice` was sent twice."""
    service = Service()
    service.read()
    service.change_note("a")
    service.read()
    service.add_run("one")
    service.add_run("twice")
    service.add_run("twice")
    service.change_note("b")
    service.read()
    service.fit("p1")
    service.book("three", 3)
    service.book("five", 5)
    service.bind("m2")
    service.send(1, 2)
    service.send(2, 1)
    service.read()
    return service.events


def changed(kind: Kind, at: int, **fields: Any) -> Callable[[History], History]:
    """The history with one event of a kind altered; fields named got_x are those of its answer, sent_x of its body."""

    def change(events: History) -> History:
        index = [number for number, event in enumerate(events) if event.kind == kind][at]
        event = events[index]
        got = {**event.got, **{name[4:]: value for name, value in fields.items() if name.startswith("got_")}}
        sent = {**event.sent, **{name[5:]: value for name, value in fields.items() if name.startswith("sent_")}}
        plain = {name: value for name, value in fields.items() if not name.startswith(("got_", "sent_"))}
        return [*events[:index], replace(event, got=got, sent=sent, **plain), *events[index + 1 :]]

    return change


def without(kind: Kind, at: int) -> Callable[[History], History]:
    """The history without the answer to one event of a kind."""
    return changed(kind, at, status=None, ended=float("inf"))


def lost_note(events: History) -> History:
    """Two changes on one version, both acknowledged."""
    first = next(event for event in events if event.kind == "note")
    other = replace(first, client=2, key="c", sent={"note": "c", "if_match": first.sent["if_match"]})
    return [*events, other]


FAULTS: dict[str, tuple[Callable[[History], History], str]] = {
    "a 500": (changed("stock", 0, status=500), "answered 500"),
    "a 503 without kills": (changed("stock", 0, status=503), "answered 503"),
    "silence without kills": (without("read", 0), "no answer"),
    "fitted, and no plan says so": (changed("read", -1, got_fitted_plans=[]), "torn read"),
    "two plans fitted": (changed("read", -1, got_fitted_plans=["p1", "p2"]), "torn read"),
    "one version, two contents": (changed("read", 1, got_version=1), "torn read"),
    "the note of another version": (changed("read", 1, got_note="z"), "torn read"),
    "stock without its movement": (changed("read_stock", -1, got_moved=3), "torn read"),
    "two changes of one version": (lost_note, "lost update"),
    "the last note is gone": (changed("read", -1, got_note="a"), "lost update"),
    "a run is gone": (changed("read", -1, got_runs=["r0", "r-one"]), "lost: run r-twice"),
    "a key with two runs": (changed("run", 2, got_id="r-more"), "doubled: key twice"),
    "a run too many": (changed("read", -1, got_runs=["r0", "r-one", "r-twice", "r-x"]), "doubled: 2 runs"),
    "a booking done twice": (changed("read_stock", -1, got_on_hand=11, got_moved=11), "doubled or lost"),
    "a booking gone": (changed("read_stock", -1, got_on_hand=3, got_moved=3), "doubled or lost"),
    "readings new twice": (changed("readings", 1, got_accepted=2, got_duplicates=0), "was new 2 times"),
    "a receipt of too few": (changed("readings", 1, got_duplicates=1), "doubled: {'accepted'"),
    "a version left out": (changed("note", 1, got_version=6), "version skipped"),
    "versions left out at the end": (changed("read", -1, got_version=9), "version skipped"),
    "a change without a version": (changed("read", -1, got_version=5), "version skipped"),
    "a read of what was before": (changed("read", 2, got_version=1, got_note="", got_runs=["r0"]), "stale"),
    "a binding overwritten": (changed("read_source", -1, got_machine="m1"), "lost update: the source"),
}


def test_a_history_in_order_has_nothing_wrong() -> None:
    assert check(in_order(), killed=False) == []


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_found(name: str) -> None:
    change, words = FAULTS[name]
    found = check(change(in_order()), killed=False)
    assert any(words in line for line in found), found


def test_what_was_not_answered_may_have_been_done() -> None:
    """After kills any request but the first and last looks may have no answer, or 503."""
    events = in_order()
    for index, event in list(enumerate(events))[3:-3]:
        for status in (None, 503):
            unanswered = replace(event, status=status, ended=float("inf") if status is None else event.ended, got={})
            # What is known to have been done by a second answer to the same key stays known.
            assert check([*events[:index], unanswered, *events[index + 1 :]], killed=True) == [], event


def test_what_was_not_answered_may_not_have_been_done() -> None:
    events = in_order()
    index = next(number for number, event in enumerate(events) if event.key == "five")
    silent = replace(events[index], status=None, ended=float("inf"))
    left = changed("read_stock", -1, got_on_hand=3, got_moved=3)([*events[:index], silent, *events[index + 1 :]])
    assert check(left, killed=True) == []


def test_any_order_of_answers_of_requests_one_after_the_other_is_in_order() -> None:
    """The checker goes by times, not by the order in which clients wrote down; the last reads stay last."""
    events = in_order()
    rng = random.Random(1)
    for _ in range(20):
        mixed = events[1:-3]
        rng.shuffle(mixed)
        assert check([events[0], *mixed, *events[-3:]], killed=False) == []
