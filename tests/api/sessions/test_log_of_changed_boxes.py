"""A session whose box changed gives its older answers again, from its log alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from service.batch.comparing import compare_one
from service.engine.logs.replay import read_log, resolve
from service.model.base import to_plain
from tests.support.http.tiny_bench import answer_of, bench_on, tiny_box
from tests.support.http.workshop import Workshop


def session_of_three_boxes(shop: Workshop) -> tuple[str, list[Any]]:
    """Plans from one box before and after it was counted, from another, and from the first once more."""
    one = bench_on(shop)
    other, small = tiny_box(shop, {30.0: 3, 150.0: 2, 210.0: 2}), tiny_box(shop, {90.0: None})
    plans = [one.plan(), one.plan(slack=2.0, blocked=[{"plane": "1", "position_deg": 130.0}])]
    shop.ask("PATCH", f"/catalogues/{one.box}", {"counted": [{"mass_g": 200.0, "pieces": 1}]})
    plans.append(one.plan(method="certified"))
    shop.ask("PATCH", f"/sessions/{one.session}", {"catalogue_id": other})
    plans += [one.plan(alternatives=2), one.plan(objective="components", mode="fewest", limit=3e4)]
    shop.fit(plans[-1])
    plans.append(one.plan(base="present"))
    shop.post(f"/plans/{plans[-2]['id']}/unfit", {})
    shop.ask("PATCH", f"/sessions/{one.session}", {"catalogue_id": small})
    plans.append(one.plan(method="modified_jaya"))
    return one.session, plans


def test_every_plan_is_solved_again_from_its_own_box(shop: Workshop, tmp_path: Path) -> None:
    session, plans = session_of_three_boxes(shop)
    log = shop.get(f"/sessions/{session}/log")
    assert [item["mass_g"] for item in log["catalogue"]["items"]] == [90.0]
    assert [len(box["catalogue"]["items"]) for box in log["earlier_boxes"]] == [3, 3]
    text = json.dumps(log)
    resolved = resolve(read_log(text), shop.work.monotonic)
    assert resolved.changed == ()
    again = to_plain(resolved)["plans"]
    assert len(again) == len(plans)
    for plan, new in zip(plans, again, strict=True):
        assert answer_of(new) == answer_of(plan)
    path = tmp_path / "session.json"
    path.write_text(text)
    compared = compare_one(str(path))
    assert (compared.error, compared.changed, compared.answers) == (None, (), 1 + len(plans))


def test_a_plan_from_the_wrong_box_is_noticed(shop: Workshop) -> None:
    """Without its own box an older plan comes out otherwise, and the comparison says so."""
    session, _ = session_of_three_boxes(shop)
    log = shop.get(f"/sessions/{session}/log")
    log["earlier_boxes"][0]["catalogue"]["items"][2]["mass_g"] += 1.0
    changed = resolve(read_log(json.dumps(log)), shop.work.monotonic).changed
    assert [line.split(":")[0] for line in changed][:1] == ["plan 1"]


def test_a_log_of_before_is_still_read(shop: Workshop) -> None:
    """One box for the whole session, as logs were once written."""
    one = bench_on(shop)
    plan = one.plan()
    log = shop.get(f"/sessions/{one.session}/log")
    assert log.pop("earlier_boxes") == []
    for made in log["plans"]:
        del made["slack_proved"]
    again = resolve(read_log(json.dumps(log)), shop.work.monotonic)
    assert again.changed == ()
    assert answer_of(to_plain(again)["plans"][0]) == answer_of(plan)
