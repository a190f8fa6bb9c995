"""The package installs whole: into a fresh environment, used from another folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import httpx2
import pytest

ROOT = Path(__file__).parents[2]
NO_REGISTRY = (
    "dns error",
    "error sending request",
    "Failed to fetch",
    "Could not connect",
    "Failed to establish a new",
)
"""What uv and pip say when no package registry can be reached."""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The command `drumtrue` of a fresh environment; uv makes it where there is one, for speed."""
    folder = tmp_path_factory.mktemp("install")
    source = folder / "source"
    shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(".*", "__pycache__", "build", "dist"))
    venv, lock = folder / "venv", str(source / "requirements.lock")
    uv = shutil.which("uv", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))
    if uv is None:
        run([sys.executable, "-m", "venv", str(venv)], folder)
        command = [str(venv / "bin" / "python"), "-m", "pip", "install", "--quiet", "-c", lock, str(source)]
    else:
        run([uv, "venv", "--quiet", "--python", sys.executable, str(venv)], folder)
        command = [uv, "pip", "install", "--quiet", "--python", str(venv / "bin" / "python"), "-c", lock, str(source)]
    done = run(command, folder, check=False, timeout=300)
    if done.returncode != 0 and any(word in done.stderr for word in NO_REGISTRY):
        pytest.skip(f"no package registry can be reached: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    take_bytecode(venv)
    return venv / "bin" / "drumtrue"


def take_bytecode(venv: Path) -> None:
    """Link what this test's own interpreter has compiled of the same packages, which else takes seconds.

    Python takes it only where size and time of the source agree; where nothing can be linked, it compiles.
    """
    here, (there,) = Path(sysconfig.get_path("purelib")), venv.glob("lib/python*/site-packages")
    for folder, _, _ in os.walk(there):
        cached = here / Path(folder).relative_to(there) / "__pycache__"
        if cached.is_dir():
            with suppress(OSError, shutil.Error):
                shutil.copytree(cached, Path(folder) / "__pycache__", copy_function=os.link)


def run(
    command: list[str], folder: Path, *, check: bool = True, timeout: float = 120
) -> subprocess.CompletedProcess[str]:
    """A command that has ended, run in a folder of its own and without this repository on its path."""
    done = subprocess.run(
        command, cwd=folder, env=clean(), capture_output=True, text=True, timeout=timeout, check=False
    )
    assert not check or done.returncode == 0, done.stderr
    return done


def clean() -> dict[str, str]:
    """The environment without what leads Python to this repository or to this test's own interpreter."""
    return {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "VIRTUAL_ENV", "PYTHONHOME")}


def test_nothing_is_imported_from_the_repository(installed: Path, tmp_path: Path) -> None:
    script = "import service, drivers, db; print(service.__file__, drivers.__file__, db.__file__)"
    done = run([str(installed.parent / "python"), "-c", script], tmp_path)
    assert all(str(installed.parents[1]) in place for place in done.stdout.split())


@contextmanager
def served(installed: Path, url: str, folder: Path) -> Iterator[str]:
    """The address of a service on a free port."""
    command = [str(installed), "serve", "--port", "0", "--database-url", url]
    environment = {**clean(), "PYTHONUNBUFFERED": "1"}
    with (folder / "errors").open("w") as errors:
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=errors, text=True
        )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert "http://" in line, (folder / "errors").read_text()
        yield next(word for word in line.split() if word.startswith("http://"))
    finally:
        process.terminate()
        process.communicate(timeout=60)


def test_migrate_demo_serve_and_solve(installed: Path, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'drumtrue.db'}"
    assert "schema empty -> " in run([str(installed), "migrate", "--database-url", url], tmp_path).stdout
    demo = json.loads(run([str(installed), "demo", "--json", "--database-url", url], tmp_path).stdout)
    assert demo["ok"] is True
    with served(installed, url, tmp_path) as address, httpx2.Client(base_url=address, timeout=60) as client:
        assert client.get("/health").json()["status"] == "ok"
        assert client.get("/openapi.json").json()["info"]["title"] == "Drumtrue"
        log = client.get(f"/api/v1/sessions/{demo['session_id']}/log")
    (tmp_path / "log.json").write_bytes(log.content)
    solved = json.loads(run([str(installed), "solve", "log.json", "--json"], tmp_path).stdout)
    assert solved["changed"] == []
    assert [plan["placements"] for plan in solved["plans"]] == [plan["placements"] for plan in log.json()["plans"]]
