"""The way out: what is sent, in which pieces, and which failure is called what."""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import datetime, timedelta, timezone

import httpx2
import pytest

from drivers.bridge.http import HttpOut
from drivers.clock import ManualClock
from drivers.errors import BrokenSource, DeliveryFailed, DeliveryRefused, InvalidSetting
from drivers.reading import Reading
from drivers.reading_json import reading_to_dict
from drivers.simulator.drum_driver import SimulatedDrum, threshing_drum_example
from tests.drivers.answering import answering

READING = Reading("sim", 3, datetime(2026, 7, 1, 14, 0, 0, 250000, timezone(timedelta(hours=2))), "P", 3.1, 99.5)


def out(answer: Callable[[httpx2.Request], httpx2.Response], *, batch_size: int = 500) -> HttpOut:
    client = answering(answer)
    return HttpOut("http://service.test/", batch_size=batch_size, client=client)


def receipt(accepted: int, duplicates: int = 0, status: int = 201) -> httpx2.Response:
    return httpx2.Response(status, json={"accepted": accepted, "duplicates": duplicates})


def problem(answered: int, **fields: object) -> httpx2.Response:
    body = {"status": answered, "code": "refused", "title": "Refused", **fields}
    return httpx2.Response(answered, json=body, headers={"content-type": "application/problem+json"})


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
        return receipt(len(json.loads(request.content)) - 1, 1)

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


@pytest.mark.parametrize("status", [400, 404, 409, 413, 422])
def test_not_this_is_a_refusal_with_the_service_s_words(status: int) -> None:
    with (
        out(lambda _: problem(status, detail="sensor 'P' is unknown" + 9000 * "!")) as outlet,
        pytest.raises(DeliveryRefused, match="sensor 'P' is unknown") as refused,
    ):
        outlet.post([READING])
    assert refused.value.status == status
    assert len(refused.value.detail) == 500


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"detail": "bound to\n none", "advice": "bind it"}, "bound to none; what to do: bind it"),
        ({"detail": "bound to none", "advice": None}, "bound to none"),
        ({"title": "Not Found"}, "Not Found"),
    ],
)
def test_problem_json_is_told_in_one_line(fields: dict[str, object], words: str) -> None:
    with out(lambda _: problem(404, **fields)) as outlet, pytest.raises(DeliveryRefused) as refused:
        outlet.post([READING])
    assert refused.value.detail == words
    assert str(refused.value).endswith(f"(status 404): {words}")


WRONG = [
    *(receipt(a, d) for a, d in ((0, 0), (2, 0), (1, 1), (-1, 2))),
    *(httpx2.Response(201, json=body) for body in (dict[str, int](), list[int](), None, {"accepted": 1})),
    httpx2.Response(201, json={"accepted": True, "duplicates": 0}),
    httpx2.Response(201, json={"accepted": "1", "duplicates": 0}),
    httpx2.Response(201, text='{"accepted": 1, "duplicates": 0}'),
    receipt(1, status=202),
    *(httpx2.Response(status, html="<p>\n Welcome </p>") for status in (200, 201, 301, 400, 403, 404, 409, 413, 422)),
    *(httpx2.Response(status) for status in (200, 201, 204, 304, 422)),
    httpx2.Response(302, headers={"location": "http://portal.test/"}),
    httpx2.Response(422, json={"code": "refused", "status": 422, "detail": "another's JSON"}),
    problem(422, code=None),
    problem(422, status=404),
    httpx2.Response(201, text="[" * 60_000, headers={"content-type": "application/json"}),
]


@pytest.mark.parametrize("answer", WRONG, ids=lambda one: f"{one.status_code} {one.text[:40]}")
def test_anything_but_a_receipt_over_all_or_a_problem_of_ours_acknowledges_and_refuses_nothing(
    answer: httpx2.Response,
) -> None:
    with out(lambda _: answer) as outlet, pytest.raises(DeliveryFailed, match="is no Drumtrue"):
        outlet.post([READING])


@pytest.mark.parametrize("answer", [receipt(1), receipt(0, 1), receipt(1, status=200)])
def test_a_receipt_over_all_that_was_sent_acknowledges_it(answer: httpx2.Response) -> None:
    with out(lambda _: answer) as outlet:
        assert outlet.post([READING]) == 1


@pytest.mark.parametrize("body", [{"id": "a", "accepted": True}, {"id": "a", "accepted": False}])
def test_an_answer_is_acknowledged_by_what_is_stored_of_it(body: dict[str, object]) -> None:
    with out(lambda _: httpx2.Response(201, json=body)) as outlet:
        outlet.post_answer(b"{}", 7)
    with out(lambda _: receipt(1)) as outlet, pytest.raises(DeliveryFailed, match="is no Drumtrue"):
        outlet.post_answer(b"{}", 7)


class Drip(httpx2.SyncByteStream):
    """An answer without end, one kilobyte at a time; told: called for each."""

    def __init__(self, told: Callable[[], None]) -> None:
        self.sent, self._told = 0, told

    def __iter__(self) -> Iterator[bytes]:
        while True:
            self.sent += 1
            self._told()
            yield 1024 * b"x"


def test_no_more_is_read_of_an_answer_than_one_of_ours_may_have() -> None:
    drip = Drip(lambda: None)
    with out(lambda _: httpx2.Response(200, stream=drip)) as outlet, pytest.raises(DeliveryFailed, match="no Drumtrue"):
        outlet.post([READING])
    assert drip.sent <= 66


def test_an_answer_that_drips_is_given_up_in_time() -> None:
    now = [0.0]

    def later() -> None:
        now[0] += 3.0

    drip = Drip(later)
    client = answering(lambda _: httpx2.Response(200, stream=drip))
    with (
        HttpOut("http://service.test", client=client, monotonic=lambda: now[0]) as outlet,
        pytest.raises(DeliveryFailed, match="no whole answer within 10 s"),
    ):
        outlet.post([READING])
    assert drip.sent == 4


def test_a_packed_answer_is_not_unpacked() -> None:
    bomb = gzip.compress(10_000_000 * b" " + b'{"accepted": 1, "duplicates": 0}')
    headers = {"content-type": "application/json", "content-encoding": "gzip"}
    seen: list[str] = []

    def answer(request: httpx2.Request) -> httpx2.Response:
        seen.append(request.headers["accept-encoding"])
        return httpx2.Response(201, stream=httpx2.ByteStream(bomb), headers=headers)

    with out(answer) as outlet, pytest.raises(DeliveryFailed, match="no Drumtrue"):
        outlet.post([READING])
    assert seen == ["identity"]


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
