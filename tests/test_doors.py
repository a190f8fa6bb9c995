"""The two public doors export what they say, and the examples of the documents run as they stand."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import service.balancing
import service.engine

DOCS = Path(__file__).parents[1] / "docs"
EXAMPLES = re.findall(
    r"<!-- executed by the tests -->\n```python\n(.*?)```", (DOCS / "reference" / "python.md").read_text(), re.S
)


@pytest.mark.parametrize("door", [service.balancing, service.engine])
def test_every_public_name_is_there_and_stated_once(door: object) -> None:
    names = door.__all__  # type: ignore[attr-defined]
    assert len(names) == len(set(names))
    assert set(names) == set(door._HOME)  # type: ignore[attr-defined]
    for name in names:
        assert getattr(door, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        door.nothing  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.parametrize("example", EXAMPLES, ids=["documents", "arrays"])
def test_the_examples_run(example: str, capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(example, "example", "exec"), {})
    assert capsys.readouterr().out


def test_a_door_loads_nothing_before_it_is_used() -> None:
    code = "import sys, service.engine, service.balancing; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_links_between_the_documents_lead_somewhere() -> None:
    missing = []
    for page in [*DOCS.rglob("*.md"), *DOCS.parent.glob("*.md")]:
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if not re.match(r"[a-z]+:", target) and not (page.parent / target).exists():
                missing.append(f"{page.name}: {target}")
    assert missing == []


def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    done = subprocess.run(command, cwd=DOCS.parent, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "site" / "index.html").is_file()
