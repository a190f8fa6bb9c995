"""The tutorial's walk-through, run as it stands against a served instance."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from service.cli.commands.serve import serving
from service.settings import Settings

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial" / "first-session.md"


@pytest.mark.skipif(
    shutil.which("curl") is None or shutil.which("bash") is None, reason="the walk-through needs bash and curl"
)
def test_the_walk_through_of_the_tutorial_balances_its_drum(tmp_path: Path) -> None:
    block = re.search(r"<!-- walk-through.*?-->\n```bash\n(.*?)```", TUTORIAL.read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    script = "set -euo pipefail\n" + block.group(1)
    with serving(Settings(database_url=f"sqlite:///{tmp_path / 'readme.db'}")) as address:
        done = subprocess.run(
            ["bash", "-c", script],
            cwd=tmp_path,
            env={"API": f"{address}/api/v1", "PATH": "/usr/local/bin:/usr/bin:/bin"},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    assert done.returncode == 0, done.stdout + done.stderr
    log = json.loads((tmp_path / "session.json").read_text())
    assert [run["kind"] for run in log["runs"]] == ["initial", "trial", "trial", "check"]
    plan = log["plans"][0]
    assert plan["state"] == "fitted"
    assert all(vector["amplitude"] < 0.7 for vector in plan["predicted"])
