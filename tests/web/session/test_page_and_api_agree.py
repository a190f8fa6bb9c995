"""Pages and API say the same of a session after every action: the step, what is on the rotor, what to change."""

from __future__ import annotations

import os
import re
from collections import Counter
from typing import Any

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule, run_state_machine_as_test

from tests.support.http.workshop import DRUM, POSITIONS, Workshop, mass
from tests.web.session.test_undoing import HTML, LOCKED, RELEASED, send

ACTIONS = {"off": "remove", "on": "add", "stay": "keep"}
PAGE_OF = {"closed": "decide", "fit": "plan"}
"""A plan that may be fitted is begun on the plan's page."""
FOUND = {"plane": "1", "position_deg": 100.0, "mass_g": 35.0, "may": "move"}
OPEN = ("proposed", "unfitted")
MOVE = re.compile(
    r'<li class="(off|on|stay)">.*?Plane (\w+)\s(?:<small>hole</small> <b class="hole">\d+</b>)?\s?'
    r"<small>([\d.]+)\s?°</small>.*?<b>([\d.,]+)\sg</b>",
    re.S,
)
PLANES = st.sampled_from("12")
EXAMPLES, STEPS = int(os.environ.get("DRUMTRUE_STATEFUL_EXAMPLES", "4")), 14


class Session(RuleBasedStateMachine):
    """One session of the published drum, driven over HTTP and by forms at random."""

    shop: Workshop

    def __init__(self) -> None:
        super().__init__()
        self.key = self.shop.session(self.taught(), on_rotor=[FOUND])

    def taught(self) -> str:
        """A machine that has saved influence coefficients, from one session before."""
        machine = self.shop.machine()
        before = self.shop.session(machine)
        self.shop.learn(before)
        self.shop.correct(before)
        self.shop.post(f"/machines/{machine}/influence", {"session_id": before})
        return machine

    @property
    def seen(self) -> Any:
        return self.shop.get(f"/sessions/{self.key}")

    def ask(self, method: str, path: str, body: Any = None) -> Any:
        """What the API answers; a refusal is as good as an answer here."""
        answer = self.shop.client.request(method, f"/api/v1{path}", json=body)
        assert answer.status_code < 500, answer.text
        return answer.json()

    def form(self, path: str, **fields: str) -> None:
        assert send(self.shop, self.key, path, **fields).status_code < 500

    # ------------------------------------------------------------ by the API
    @rule()
    def initial(self) -> None:
        self.ask("POST", f"/sessions/{self.key}/runs", {"kind": "initial", "readings": DRUM.readings()})

    @rule(
        plane=st.sampled_from("12"), grams=st.sampled_from([100.0, 200.0]), angle=st.sampled_from([40.0, 47.5, 360.0])
    )
    def trial(self, plane: str, grams: float, angle: float) -> None:
        masses = [mass(plane, grams, angle)]
        body = {"kind": "trial", "masses": masses, "readings": DRUM.readings(masses)}
        self.ask("POST", f"/sessions/{self.key}/runs", body)

    @rule()
    def check(self) -> None:
        seen = self.seen
        body = {"kind": "check", "readings": DRUM.readings(seen["masses_on_rotor"])}
        self.ask("POST", f"/sessions/{self.key}/runs", body)

    @precondition(lambda self: self.seen["runs"])
    @rule(which=st.integers(0, 9), excluded=st.booleans())
    def exclude(self, which: int, excluded: bool) -> None:
        runs = self.seen["runs"]
        run = runs[which % len(runs)]["id"]
        self.ask("PATCH", f"/sessions/{self.key}/runs/{run}", {"excluded": excluded, "reason": "tried"})

    @rule()
    def fit_correction(self) -> None:
        self.ask("POST", f"/sessions/{self.key}/corrections", {"source": "fit"})

    @rule()
    def saved_influence(self) -> None:
        self.ask("POST", f"/sessions/{self.key}/corrections", {"source": "saved_influence"})

    @rule(grams=st.sampled_from([120.0, 310.0]))
    def balancer_answer(self, grams: float) -> None:
        masses = [mass("1", grams, 200.0), mass("2", 0.5 * grams, 80.0)]
        self.ask("POST", f"/sessions/{self.key}/corrections", {"source": "balancer", "masses": masses})

    @precondition(lambda self: self.seen["corrections"])
    @rule(base=st.sampled_from(["as_found", "present"]))
    def plan(self, base: str) -> None:
        correction = self.seen["corrections"][-1]
        body = {"correction_id": correction["id"], "objective": "components", "max_masses_per_plane": 1, "base": base}
        self.ask("POST", f"/sessions/{self.key}/plans", {**body, "method": "exact"})

    @precondition(lambda self: self.seen["plans"])
    @rule(weighed=st.sampled_from([None, 0.4, -0.3]))
    def fitted(self, weighed: float | None) -> None:
        plan = self.seen["plans"][-1]
        body: dict[str, Any] = {"accept_stale": True}
        if weighed is not None:
            body["actual"] = [
                {key: p[key] for key in ("plane", "position_deg", "mass_g")} | {"weighed_g": p["mass_g"] + weighed}
                for p in plan["placements"]
                if p["from_box"]
            ]
        self.ask("POST", f"/plans/{plan['id']}/fitted", body)

    @precondition(lambda self: self.seen["fitted_plan_id"])
    @rule()
    def unfit(self) -> None:
        self.ask("POST", f"/plans/{self.seen['fitted_plan_id']}/unfit")

    @precondition(lambda self: self.seen["step"] == "decide")
    @rule()
    def close(self) -> None:
        self.ask("PATCH", f"/sessions/{self.key}", {"state": "closed"})

    # ------------------------------------------------------------ by the pages
    @rule(plane=PLANES)
    def stop_for_a_trial(self, plane: str) -> None:
        self.form("stops", purpose="trial", plane=plane)
        number = self._number()
        self.form(f"stops/{number}/lock", **LOCKED)
        self.form(f"stops/{number}/trial", **{"masses.mass_g": "150", "masses.angle_deg": str(POSITIONS[3])})

    @precondition(lambda self: self.seen["plans"])
    @rule()
    def stop_for_a_plan(self) -> None:
        self.form("stops", purpose="plan", plan_id=self.seen["plans"][-1]["id"])
        number = self._number()
        self.form(f"stops/{number}/lock", **LOCKED)
        self.form(f"stops/{number}/plan")

    @rule()
    def take_everything_off(self) -> None:
        self.form("stops", purpose="bare")
        number = self._number()
        self.form(f"stops/{number}/lock", **LOCKED)
        self.form(f"stops/{number}/bare")

    @rule()
    def release(self) -> None:
        self.form(f"stops/{self._number()}/release", **RELEASED)

    @rule()
    def cancel(self) -> None:
        self.form(f"stops/{self._number()}/cancel")

    def _number(self) -> int:
        return max(1, len(self.shop.get(f"/sessions/{self.key}/log")["record"]["stops"]))

    # ------------------------------------------------------------ and both agree
    @invariant()
    def the_step_is_the_same(self) -> None:
        page = self.shop.client.get(f"/sessions/{self.key}", headers=HTML).text
        moment = re.search(r'data-moment="(\w+) (\d+) ', page)
        assert moment is not None
        step = self.seen["step"]
        begun = step == "fit" and moment[2] != "0"
        assert moment[1] == (step if begun else PAGE_OF.get(step, step))

    @invariant()
    def the_list_of_changes_is_the_same(self) -> None:
        page = self.shop.client.get(f"/sessions/{self.key}/step/plan", headers=HTML)
        plans = self.seen["plans"]
        if page.status_code != 200 or not plans or plans[-1]["stale"] or plans[-1]["state"] not in OPEN:
            return
        shown = Counter(
            (ACTIONS[action], plane, float(angle.replace(",", "")), float(grams.replace(",", "")))
            for action, plane, angle, grams in MOVE.findall(page.text)
        )
        wanted = Counter(
            (change["action"], piece["plane"], round(piece["position_deg"], 1), round(grams_of(piece), 1))
            for change in plans[-1]["changes"]
            for piece in [change["placement"]]
        )
        assert shown == wanted

    @invariant()
    def changes_lead_from_what_is_on_to_what_is_planned(self) -> None:
        seen = self.seen
        on = Counter(
            (one["plane"], round(one["angle_deg"] % 360.0, 3), round(one["mass_g"], 3))
            for one in (*seen["masses_on_rotor"], {**FOUND, "angle_deg": FOUND["position_deg"]})
        )
        for plan in seen["plans"]:
            if plan["state"] not in OPEN or seen["state"] == "closed":
                continue
            for change in plan["changes"]:
                piece = change["placement"]
                place = (piece["plane"], round(piece["position_deg"] % 360.0, 3), round(grams_of(piece), 3))
                assert change["action"] == "add" or on[place] > 0


def grams_of(piece: Any) -> float:
    """What a placement is on the rotor, g."""
    return float((piece["weighed_g"] or piece["mass_g"]) + piece["fastener_g"])


def test_page_and_api_agree_after_every_action(shared_shop: Workshop) -> None:
    machine = type("OfThisShop", (Session,), {"shop": shared_shop})
    run_state_machine_as_test(
        machine,
        settings=settings(
            max_examples=EXAMPLES,
            stateful_step_count=STEPS,
            deadline=None,
            suppress_health_check=list(HealthCheck),
        ),
    )
