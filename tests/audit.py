"""`make audit`: the pinned dependencies looked up among known vulnerabilities, by pip-audit.

pip-audit passes over a package that it cannot look up and then says that nothing was found. Here such a package is told
as not checked, and the command does not end well: status 1 where something is vulnerable, 2 where something was not
checked, 0 only where everything was looked up and nothing found. Without a network it says that nothing was.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LOCK = Path(__file__).parents[1] / "requirements.lock"
TIMEOUT_S = 600


@dataclass(frozen=True)
class Audit:
    """Packages by what became of them; why: name -> reason it was not checked; found: name -> known vulnerabilities."""

    checked: tuple[str, ...]
    why: dict[str, str]
    found: dict[str, tuple[str, ...]]

    @property
    def status(self) -> int:
        """For the shell: 0 only where everything was checked and nothing found."""
        return 1 if self.found else 2 if self.why else 0

    def lines(self) -> Iterable[str]:
        """The audit in words."""
        for name, vulnerabilities in sorted(self.found.items()):
            yield f"VULNERABLE   {name}: {', '.join(vulnerabilities)}"
        for name, reason in sorted(self.why.items()):
            yield f"not checked  {name}: {reason}"
        total = len(self.checked) + len(self.why)
        yield (
            f"{total} packages: {len(self.checked)} checked, {len(self.found)} of them with known vulnerabilities, "
            f"{len(self.why)} not checked"
        )


def pinned(lock: str) -> tuple[str, ...]:
    """The packages that a lock file names."""
    return tuple(found[1].lower() for found in re.finditer(r"^([A-Za-z0-9_.-]+)(?:\[[^]]*\])?==", lock, re.MULTILINE))


def read(output: str, wanted: Iterable[str], reason: str) -> Audit:
    """What pip-audit's JSON says of the wanted packages; one that it does not speak of was not checked: `reason`."""
    try:
        entries: list[dict[str, Any]] = json.loads(output)["dependencies"]
    except (ValueError, KeyError, TypeError):
        entries = []
    spoken = {_plain(entry["name"]): entry for entry in entries}
    checked, why, found = [], {}, {}
    for name in wanted:
        entry = spoken.get(_plain(name), {"skip_reason": reason})
        if "vulns" not in entry:
            why[name] = str(entry.get("skip_reason") or reason)
            continue
        checked.append(name)
        if entry["vulns"]:
            found[name] = tuple(str(one["id"]) for one in entry["vulns"])
    return Audit(tuple(checked), why, found)


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def main() -> int:
    """Audit the lock file; returns the status for the shell."""
    command = [sys.executable, "-m", "pip_audit", "--requirement", str(LOCK), "--no-deps", "--disable-pip"]
    command += ["--format", "json", "--progress-spinner", "off", "--timeout", "15"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
        said = done.stderr.strip().splitlines()
        output, reason = (
            done.stdout,
            f"pip-audit could not look it up ({said[-1][:200] if said else 'it said nothing'})",
        )
    except subprocess.TimeoutExpired:
        output, reason = "", f"pip-audit did not end within {TIMEOUT_S} s"
    audit = read(output, pinned(LOCK.read_text(encoding="utf-8")), reason)
    print("\n".join(audit.lines()))  # noqa: T201
    return audit.status


if __name__ == "__main__":
    raise SystemExit(main())
