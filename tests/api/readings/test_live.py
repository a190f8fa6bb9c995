"""Live: what the stream says of steady, unsteady and drifting readings; bounded; gone when the service stops."""

from __future__ import annotations

import cmath
import itertools
import json
import math
import threading
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import httpx2
import pytest

from drivers.reading import Reading
from drivers.reading_json import readings_to_json
from drivers.simulator.example import threshing_drum_example
from service.api.routers import live as router
from service.cli.commands.serve import serving
from service.cli.support.demo_machine import machine_of
from service.settings import Settings

NUMBERS = itertools.count()


class Stage:
    """A service with one session; readings are posted 0.1 s apart, from its opening on."""

    def __init__(self, url: str) -> None:
        self.api = httpx2.Client(base_url=f"{url}/api/v1", trust_env=False, timeout=10.0)
        self.name = f"drum {next(NUMBERS)}"
        machine = self.api.post("/machines", json=machine_of(threshing_drum_example(1), self.name)).json()
        self.api.put(f"/sources/{self.name}", json={"machine_id": machine["id"]})
        self.session = self.api.post("/sessions", json={"machine_id": machine["id"]}).json()["id"]
        self.sequence = 0
        self.moment = datetime.now(UTC)

    def send(self, vectors: list[complex], sensors: tuple[str, ...] = ("P", "Q")) -> None:
        """The same vector from each sensor."""
        some = []
        for vector in vectors:
            self.moment += timedelta(seconds=0.1)
            for sensor in sensors:
                self.sequence += 1
                phase = math.degrees(cmath.phase(vector)) % 360.0
                some.append(Reading(self.name, self.sequence, self.moment, sensor, abs(vector), phase, 460.0))
        answer = self.api.post(
            "/readings", content=readings_to_json(some), headers={"content-type": "application/json"}
        )
        assert answer.status_code == 201, answer.text

    def now(self) -> dict[str, Any]:
        found: dict[str, Any] = self.api.get(f"/sessions/{self.session}/now").json()
        return found

    def stream(self, events: int = 0) -> Iterator[dict[str, Any]]:
        with self.api.stream("GET", f"/sessions/{self.session}/live", params={"events": events}) as answer:
            assert answer.headers["content-type"].startswith("text/event-stream")
            for line in answer.iter_lines():
                if line.startswith("data: "):
                    yield json.loads(line.removeprefix("data: "))


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder: Path = tmp_path_factory.mktemp("live")
    with serving(Settings(database_url=f"sqlite:///{folder / 'live.db'}")) as address:
        yield address


@pytest.fixture
def stage(url: str) -> Iterator[Stage]:
    stage = Stage(url)
    yield stage
    stage.api.close()


def around(vector: complex, spread: complex, count: int) -> list[complex]:
    return [vector * (1.0 + spread * (1 if index % 2 else -1)) for index in range(count)]


@pytest.mark.parametrize(
    ("vectors", "words"),
    [
        ([cmath.rect(3.0, 1.0)] * 4, "4 readings so far, 5 are needed"),
        (around(cmath.rect(3.0, 1.0), 0.04 + 0.0j, 20), None),
        (around(cmath.rect(3.0, 1.0), 0.06 + 0.0j, 20), "the amplitude varies by 6%"),
        (around(cmath.rect(3.0, 0.0), 0.07j, 20), None),  # 4 degrees either side of the mark, where 359 follows 0
        (around(cmath.rect(3.0, 0.0), 0.12j, 20), "the phase varies by 7 degrees"),
        ([cmath.rect(3.0 + 0.02 * index, 1.0) for index in range(20)], "the vibration drifts by 6%"),
    ],
)
def test_when_a_run_may_be_taken(stage: Stage, vectors: list[complex], words: str | None) -> None:
    stage.send(vectors)
    now = stage.now()
    assert [sensor["sensor"] for sensor in now["sensors"]] == ["P", "Q"]
    assert now["steady"] is (words is None)
    for sensor in now["sensors"]:
        assert sensor["readings"] == len(vectors)
        assert sensor["amplitude"] == pytest.approx(abs(sum(vectors) / len(vectors)), rel=1e-9)
        assert (sensor["why_not"] or "").startswith(words or "")
        assert (sensor["why_not"] is None) == (words is None)


def test_only_the_last_ten_seconds_count(stage: Stage) -> None:
    stage.send([cmath.rect(9.0, 3.0)] * 50)
    stage.send([cmath.rect(3.0, 1.0)] * 101)
    now = stage.now()
    assert now["steady"]
    assert now["sensors"][0]["readings"] == 101
    length = datetime.fromisoformat(now["newest_at"]) - datetime.fromisoformat(now["since"])
    assert length == timedelta(seconds=10)


def test_a_sensor_that_is_silent_keeps_a_run_from_being_taken(stage: Stage) -> None:
    stage.send([cmath.rect(3.0, 1.0)] * 10, sensors=("P",))
    now = stage.now()
    assert [(sensor["sensor"], sensor["steady"]) for sensor in now["sensors"]] == [("P", True)]
    assert not now["steady"]


def test_the_stream_follows_what_is_stored(stage: Stage) -> None:
    events = stage.stream(events=2)
    first = next(events)
    assert (first["newest_at"], first["sensors"], first["steady"]) == (None, [], False)
    stage.send([cmath.rect(3.0, 1.0)] * 10)
    second = next(events)
    assert second["steady"]
    assert next(events, None) is None


def test_an_unknown_session_is_a_problem_not_a_stream(stage: Stage) -> None:
    answer = stage.api.get("/sessions/none/live")
    assert (answer.status_code, answer.json()["code"]) == (404, "not_found")


def test_there_are_only_so_many_streams(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(router, "MAX_STREAMS", 1)
    with stage.api.stream("GET", f"/sessions/{stage.session}/live") as one:
        lines = one.iter_lines()
        next(lines)
        refused = stage.api.get(f"/sessions/{stage.session}/live")
        assert (refused.status_code, refused.json()["code"]) == (503, "too_many_streams")
        lines.close()  # type: ignore[attr-defined]
    end = time.monotonic() + 10.0
    while stage.api.get(f"/sessions/{stage.session}/live", params={"events": 1}).status_code != 200:
        assert time.monotonic() < end, "a stream that was left still counts"


def test_a_stream_ends_with_the_service(tmp_path: Path) -> None:
    ended = threading.Event()

    def listen(stage: Stage) -> None:
        try:
            for _ in stage.stream():
                pass
        except httpx2.HTTPError:
            pass
        ended.set()

    with serving(Settings(database_url=f"sqlite:///{tmp_path / 'live.db'}")) as url:
        stage = Stage(url)
        next(stage.stream(events=1))
        thread = threading.Thread(target=listen, args=(stage,))
        thread.start()
    assert ended.wait(10.0)
    thread.join()
    stage.api.close()
