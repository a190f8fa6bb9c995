"""Migrations that are killed: a database of an older version, brought up to date with interruptions."""

from __future__ import annotations

import itertools
import json
import random
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from sqlalchemy import text

from db import migrate
from db.database import Database
from service import bootstrap
from service.chaos.load import MACHINE
from service.chaos.server import Server
from service.settings import Settings
from service.usecases import audit

READINGS = 20_000
OLD = "0003"
"""Revision of the database that is migrated."""
MAX_KILLS = 3
TIMEOUT_S = 600.0
_MACHINE = "INSERT INTO machine (id, name, spec, created_at, updated_at) VALUES ('m', 'old', :spec, :at, :at)"
_READING = (
    "INSERT INTO reading (source, sequence, machine_id, taken_at, sensor, amplitude) "
    "VALUES ('old', :number, 'm', :at, 'P', :number)"
)
_AT = "2026-01-01 00:00:00.000000"


class OldDatabases:
    """Copies of one database of an older version, each migrated by processes that are killed."""

    def __init__(self, folder: Path, server: Server | None, rng: random.Random) -> None:
        self._folder, self._server, self._rng = folder, server, rng
        self._numbers = itertools.count(1)
        self._seconds = 0.0
        self._template = self._fresh()

    def killed(self) -> list[str]:
        """Migrate a copy, killed up to three times on the way; what is wrong with it afterwards."""
        url = self._copy()
        for _ in range(self._rng.randint(1, MAX_KILLS)):
            process = _migrating(url)
            try:
                process.wait(self._rng.uniform(0.0, self._seconds or 3.0))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait(TIMEOUT_S)
        begun = time.monotonic()
        if status := _migrating(url).wait(TIMEOUT_S):
            return [f"a killed migration was not made good by the next: status {status}"]
        self._seconds = time.monotonic() - begun
        return [f"killed migration: {line}" for line in _wrong_with(url)]

    def _fresh(self) -> str:
        url = self._address(f"old_{next(self._numbers)}")
        with closing(Database(url)) as database:
            migrate.upgrade(database, OLD)
            spec: dict[str, Any] = {"angle_sense": "against_rotation", "phase_sense": "lag", **MACHINE}
            with database.engine.begin() as connection:
                connection.execute(text(_MACHINE), {"spec": json.dumps(spec), "at": _AT})
                rows = [{"number": number, "at": _AT} for number in range(1, READINGS + 1)]
                connection.execute(text(_READING), rows)
        return url

    def _address(self, name: str) -> str:
        if self._server is not None:
            return self._server.create(name)
        return f"sqlite:///{self._folder / name}.sqlite"

    def _copy(self) -> str:
        name = f"old_{next(self._numbers)}"
        if self._server is not None:
            return self._server.create(name, template=self._template)
        shutil.copy(self._folder / "old_1.sqlite", self._folder / f"{name}.sqlite")
        return self._address(name)


def _migrating(url: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "service", "migrate", "--database-url", url]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # noqa: S603 - ours


def _wrong_with(url: str) -> Iterator[str]:
    work = bootstrap.build_work(Settings(database_url=url))
    with closing(work.database):
        if migrate.drift(work.database):
            yield "the tables are not what this version needs"
        with work.database.engine.connect() as connection:
            query = "SELECT count(*), sum(CASE WHEN amplitude = sequence THEN 1 ELSE 0 END) FROM reading"
            count, same = connection.execute(text(query)).one()
        if (count, same) != (READINGS, READINGS):
            yield f"{READINGS} readings before, {count} after, {same} of them as they were"
        yield from (f"{finding.code}: {finding.detail}" for finding in audit.verify(work).findings)
