"""Every module of the kernel and of the exact search has a unit test beside it that reads as its documentation."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = ("engine", "balancing/selection/exact")
TESTED_FROM_OUTSIDE = frozenset(
    {
        # Through the routes of arrangements, tests/api/arrangements, and against brute force.
        "engine/arrangement/answers.py",
        "engine/arrangement/frame.py",
        "engine/arrangement/messages.py",
        "engine/arrangement/parts.py",
        "engine/arrangement/request_checks.py",
        "engine/arrangement/solver.py",
        "engine/arrangement/with_box.py",
        # Through sessions with their check runs, tests/api/sessions, and coverage campaigns.
        "engine/evidence/follow_up.py",
        "engine/evidence/verdict.py",
        "engine/plan_survival.py",
        # Through sessions of rotors that need nothing, tests/engine/test_trust_cases.py.
        "engine/nothing_to_do.py",
    }
)
"""Modules whose tests still stand elsewhere: none may be added."""


def modules() -> list[str]:
    """Modules of the rooms, below `service`."""
    found = (path for room in ROOMS for path in (ROOT / "service" / room).rglob("*.py"))
    return sorted(path.relative_to(ROOT / "service").as_posix() for path in found if path.name != "__init__.py")


@pytest.mark.parametrize("module", modules())
def test_a_module_has_its_test_beside_it(module: str) -> None:
    path = ROOT / "tests" / module
    there = path.with_name(f"test_{path.name}").exists()
    assert there != (module in TESTED_FROM_OUTSIDE), f"tests/{module}: write test_{path.name}, or take it off the list"
