"""A session on the tiny drum whose every selection is known: what the tests of plans and offers ask it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tests.support.http.every_selection import BOX, EverySelection, tiny_machine
from tests.support.http.workshop import DRUM, LinearDrum, Workshop

EVERYTHING = EverySelection()
ALL = [
    ("components", None),
    ("bearing_force", None),
    ("residual_vibration", None),
    ("residual_vibration", "sum"),
    ("residual_vibration", "max"),
    ("residual_vibration", "rms"),
]
SAME = 1e-9


@dataclass(frozen=True)
class Bench:
    """A session on the tiny drum, with its correction."""

    shop: Workshop
    session: str
    box: str
    correction: Any

    def plan(self, **request: Any) -> Any:
        """A plan by the exact search unless the request says otherwise."""
        usual = {"method": "exact", "max_masses_per_plane": None}
        return self.shop.plan(self.session, self.correction, **{**usual, **request})

    def refused(self, status: int = 422, code: str = "invalid_input", **request: Any) -> Any:
        """The problem that a request for a plan is answered with."""
        body = {"correction_id": self.correction["id"], "objective": "residual_vibration", **request}
        return self.shop.refused("POST", f"/sessions/{self.session}/plans", body, status, code)

    def what_if(self, plan: Any, **asked: Any) -> Any:
        """The plan under other circumstances."""
        return self.shop.post(f"/plans/{plan['id']}/what-if", asked)

    def front(self, plan: Any) -> Any:
        """The front of a plan."""
        return self.shop.get(f"/plans/{plan['id']}/front")


def tiny_box(shop: Workshop, box: dict[float, int | None]) -> str:
    """A stored box with these counts."""
    items = [{"mass_g": grams, "count": count} for grams, count in box.items()]
    return str(shop.post("/catalogues", {"name": f"tiny {shop.count('catalogue')}", "items": items})["id"])


def bench_on(shop: Workshop, box: dict[float, int | None] | None = None, drum: LinearDrum = DRUM) -> Bench:
    """A bench of its own."""
    stored = tiny_box(shop, box or dict(BOX))
    session = shop.session(shop.machine(**tiny_machine()), stored)
    shop.learn(session, drum)
    return Bench(shop, session, stored, shop.correct(session))


def answer_of(plan: Any) -> Any:
    """A plan without what differs from one to the next by its nature."""
    return {key: value for key, value in plan.items() if key not in ("id", "number", "created_at", "seconds")} | {
        "per_method": [{**part, "seconds": None} for part in plan["per_method"]]
    }


def chosen(offer: Any) -> tuple[tuple[str, float, float], ...]:
    """The selection of an offer."""
    return tuple((p["plane"], p["position_deg"], p["mass_g"]) for p in offer["placements"])


def pieces_of_none() -> int:
    """Index of the selection without any piece."""
    return EVERYTHING.all.index(())
