"""The session as a state machine: what is next follows from what is stored, and a closed one stays closed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from service.engine import correct, plan
from service.engine.session_state import Progress, after, next_step
from service.errors import OutOfOrder
from service.messages import render
from tests.support.numerics.drum_log import RUNS, session

LOG = session()
CORRECTION = correct(LOG)


@dataclass(frozen=True)
class Facts:
    id: str = "s"
    state: str = "open"
    fitted_plan_id: str | None = None


def said(found: Progress) -> str:
    """The next step in English."""
    return render(next_step(found))


def progress(count: int, **changes: object) -> Progress:
    bare = Progress(state="open", machine=LOG.machine, runs=LOG.runs[:count], corrections=(), plans=())
    return replace(bare, **changes)  # type: ignore[arg-type]


def test_runs_come_first_then_corrections_then_a_plan_then_the_masses() -> None:
    made = plan(LOG, CORRECTION)
    steps = [
        progress(0),
        progress(1),
        progress(3),
        progress(3, state="corrected", corrections=(CORRECTION,)),
        progress(3, state="planned", corrections=(CORRECTION,), plans=(made,)),
        progress(3, state="fitted", corrections=(CORRECTION,), plans=(made,)),
        progress(3, state="checked", corrections=(CORRECTION,), plans=(made,)),
        progress(3, state="closed"),
    ]
    wanted = ["initial", "trial", "correction", "plan", "fit", "check", "decide", "closed"]
    assert [one.step for one in steps] == wanted
    assert len({said(one) for one in steps}) == len(steps)


def test_what_is_missing_is_named() -> None:
    assert said(progress(1)) == 'take a trial run in plane "1" and a trial run in plane "2", then ask for corrections'
    second = progress(0, runs=LOG.runs[2:])
    assert said(second) == 'take an initial run and a trial run in plane "1", then ask for corrections'
    assert progress(2).planes_to_try == ("2",)


def test_an_excluded_run_is_missing() -> None:
    wrong = replace(LOG.runs[2], excluded=True, reason="typed wrong")
    found = progress(0, runs=(*LOG.runs[:2], wrong))
    assert (found.step, found.planes_to_try) == ("trial", ("2",))


def test_without_phase_five_runs_are_needed_for_two_planes() -> None:
    blind = tuple(replace(r, readings=tuple(replace(o, phase_deg=None) for o in r.readings)) for r in LOG.runs)
    found = progress(0, runs=blind)
    assert found.without_phase
    assert (found.runs_missing, found.can_fit, found.step) == (2, False, "trial")
    assert "2 more trial runs" in said(found)


def test_a_correction_that_a_run_has_overtaken_is_asked_for_again() -> None:
    stale = progress(3, corrections=(replace(CORRECTION, stale=True),))
    assert (stale.correction, stale.step) == (None, "correction")
    assert said(stale) == "ask for corrections again: the runs changed since"


def test_a_plan_that_is_mounted_or_stale_is_not_to_be_fitted() -> None:
    made = plan(LOG, CORRECTION)
    assert progress(3, plans=(made,)).plan == made
    assert progress(3, plans=(replace(made, state="unfitted"),)).plan is not None
    assert progress(3, plans=(replace(made, state="fitted"),)).plan is None
    assert progress(3, plans=(replace(made, stale=True),)).plan is None


def test_events_lead_from_state_to_state() -> None:
    assert after(Facts(), "correction") == "corrected"
    assert after(Facts(), "run") == "open"
    assert after(Facts(state="fitted", fitted_plan_id="p"), "run") == "fitted"
    assert after(Facts(state="fitted", fitted_plan_id="p"), "check") == "checked"


def test_a_closed_session_takes_nothing_and_a_check_needs_a_plan() -> None:
    with pytest.raises(OutOfOrder):
        after(Facts(state="closed"), "run")
    with pytest.raises(OutOfOrder):
        after(Facts(), "check")
    assert len(RUNS) == len(LOG.runs)
