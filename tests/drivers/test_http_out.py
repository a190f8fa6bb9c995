"""The way out: what is sent, in which pieces, and which failure is called what."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime, timedelta, timezone

import httpx2
import pytest

from drivers.clock import ManualClock
from drivers.errors import BrokenSource, DeliveryFailed, DeliveryRefused, InvalidSetting
from drivers.http_out import HttpOut
from drivers.reading import Reading
from drivers.simulated import SimulatedDrum, threshing_drum_example
from drivers.wire import reading_to_dict

READING = Reading("sim", 3, datetime(2026, 7, 1, 14, 0, 0, 250000, timezone(timedelta(hours=2))), "P", 3.1, 99.5)


def out(answer: Callable[[httpx2.Request], httpx2.Response], *, batch_size: int = 500) -> HttpOut:
    client = httpx2.Client(transport=httpx2.MockTransport(answer))
    return HttpOut("http://service.test/", batch_size=batch_size, client=client)


def some_readings(count: int) -> list[Reading]:
    with SimulatedDrum(threshing_drum_example(), seed=1, clock=ManualClock()) as drum:
        return drum.measure(count // 2)


def test_a_reading_as_json_leaves_out_what_is_not_known_and_states_utc() -> None:
    assert reading_to_dict(READING) == {
        "source": "sim",
        "sequence": 3,
        "taken_at": "2026-07-01T12:00:00.250000Z",
        "sensor": "P",
        "amplitude": 3.1,
        "phase_deg": 99.5,
    }


def test_readings_go_to_the_contract_s_address_in_bounded_batches_and_in_order() -> None:
    seen: list[httpx2.Request] = []

    def accept(request: httpx2.Request) -> httpx2.Response:
        seen.append(request)
        return httpx2.Response(202)

    readings = some_readings(10)
    with out(accept, batch_size=4) as outlet:
        assert outlet.post(readings) == 10
        assert outlet.post([]) == 0
    assert {(one.method, str(one.url)) for one in seen} == {("POST", "http://service.test/api/v1/readings")}
    assert {one.headers["content-type"] for one in seen} == {"application/json"}
    batches = [json.loads(one.content) for one in seen]
    assert [len(batch) for batch in batches] == [4, 4, 2]
    assert [one for batch in batches for one in batch] == [reading_to_dict(one) for one in readings]


@pytest.mark.parametrize("status", [500, 502, 503, 408, 425, 429])
def test_not_now_is_a_failure_that_may_be_tried_again(status: int) -> None:
    with out(lambda _: httpx2.Response(status)) as outlet, pytest.raises(DeliveryFailed, match=f"status {status}"):
        outlet.post([READING])


@pytest.mark.parametrize("status", [307, 400, 404, 409, 413, 422])
def test_not_this_is_a_refusal_with_the_service_s_words(status: int) -> None:
    with (
        out(lambda _: httpx2.Response(status, text="sensor 'P' is unknown" + 9000 * "!")) as outlet,
        pytest.raises(DeliveryRefused, match="sensor 'P' is unknown") as refused,
    ):
        outlet.post([READING])
    assert refused.value.status == status
    assert len(refused.value.detail) == 500


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            '{"title": "Not Found", "detail": "bound to\\n none", "advice": "bind it"}',
            "bound to none; what to do: bind it",
        ),
        ('{"title": "Not Found", "detail": 7, "advice": null}', '{"title": "Not Found", "detail": 7, "advice": null}'),
        ('{"title": "Not Found"}', "Not Found"),
        ("[1]", "[1]"),
        ("<p>\n no </p>", "<p> no </p>"),
    ],
)
def test_problem_json_is_told_in_one_line(body: str, words: str) -> None:
    with out(lambda _: httpx2.Response(404, text=body)) as outlet, pytest.raises(DeliveryRefused) as refused:
        outlet.post([READING])
    assert refused.value.detail == words
    assert str(refused.value).endswith(f"(status 404): {words}")


@pytest.mark.parametrize("error", [httpx2.ConnectError, httpx2.ReadTimeout, httpx2.RemoteProtocolError])
def test_a_lost_link_is_a_failure(error: type[httpx2.TransportError]) -> None:
    def broken(request: httpx2.Request) -> httpx2.Response:
        raise error("the cable is out", request=request)

    with out(broken) as outlet, pytest.raises(DeliveryFailed, match="is the service running") as failed:
        outlet.post([READING])
    assert isinstance(failed.value.__cause__, error)


@pytest.mark.parametrize("amplitude", [math.nan, math.inf])
def test_a_number_that_json_does_not_have_is_not_sent(amplitude: float) -> None:
    with out(lambda _: httpx2.Response(202)) as outlet, pytest.raises(BrokenSource, match="sequences 3 to 3"):
        outlet.post([replace(READING, amplitude=amplitude)])


def test_bad_options_are_refused() -> None:
    makers: tuple[Callable[[], HttpOut], ...] = (
        lambda: HttpOut("service.test"),
        lambda: HttpOut("http://service.test", batch_size=0),
        lambda: HttpOut("http://service.test", timeout_s=0.0),
    )
    for make in makers:
        with pytest.raises(InvalidSetting):
            make()
