"""The audit never takes a package that was not looked up for one that passed."""

from __future__ import annotations

import json

from tests import audit

WANTED = ("alpha", "beta-lib", "gamma")


def told(*entries: object) -> str:
    return json.dumps({"dependencies": entries, "fixes": []})


def test_checked_skipped_and_vulnerable_are_told_apart() -> None:
    output = told(
        {"name": "Alpha", "version": "1.0", "vulns": []},
        {"name": "beta_lib", "version": "2.0", "vulns": [{"id": "PYSEC-1"}, {"id": "PYSEC-2"}]},
        {"name": "gamma", "skip_reason": "not found on the index"},
    )
    found = audit.read(output, WANTED, "?")
    assert found.status == 1
    assert list(found.lines()) == [
        "VULNERABLE   beta-lib: PYSEC-1, PYSEC-2",
        "not checked  gamma: not found on the index",
        "3 packages: 2 checked, 1 of them with known vulnerabilities, 1 not checked",
    ]


def test_all_clear_only_where_all_were_checked() -> None:
    clear = [{"name": name, "version": "1", "vulns": []} for name in WANTED]
    assert audit.read(told(*clear), WANTED, "?").status == 0
    missing = audit.read(told(*clear[:2]), WANTED, "it was not spoken of")
    assert (missing.status, missing.why) == (2, {"gamma": "it was not spoken of"})


def test_without_an_answer_nothing_was_checked() -> None:
    for output in ("", "no JSON", "[]", "{}", "null"):
        found = audit.read(output, WANTED, "no network")
        assert (found.status, found.checked, len(found.why)) == (2, (), 3)


def test_every_package_of_the_lock_is_wanted() -> None:
    text = audit.LOCK.read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line and not line.startswith(("#", " "))]
    assert len(audit.pinned(text)) == len(lines) > 50
