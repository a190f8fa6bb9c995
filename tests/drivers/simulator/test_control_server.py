"""The control port over real HTTP: what it does, and what it refuses without doing anything."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict

import httpx2
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.clock import ManualClock
from drivers.errors import InvalidSetting, PortUnavailable
from drivers.simulator.control_schema import COMMANDS
from drivers.simulator.control_server import MAX_BYTES, ControlPort
from drivers.simulator.drum_driver import Faults, FittedMass, LooseMass, SimulatedDrum, threshing_drum_example
from drivers.simulator.rotor import Bend


@pytest.fixture
def drum() -> Iterator[SimulatedDrum]:
    with SimulatedDrum(threshing_drum_example(), seed=1, clock=ManualClock()) as drum:
        yield drum


@pytest.fixture
def client(drum: SimulatedDrum) -> Iterator[httpx2.Client]:
    with ControlPort(drum) as port, httpx2.Client(base_url=port.url, trust_env=False) as client:
        yield client


class TestCommands:
    def test_masses_are_bolted_on_and_taken_off(self, drum: SimulatedDrum, client: httpx2.Client) -> None:
        pieces = [{"plane": "1", "mass_g": 100, "angle_deg": 40.5}, {"plane": "2", "mass_g": 20.0, "angle_deg": 360}]
        answer = client.put("/masses", json=pieces)
        assert answer.status_code == 200
        assert answer.json()["masses"] == pieces
        assert drum.masses == (FittedMass("1", 100.0, 40.5), FittedMass("2", 20.0, 360.0))
        assert drum.run == 2
        assert client.put("/masses", json=[]).json()["masses"] == []

    def test_speed_and_new_run(self, drum: SimulatedDrum, client: httpx2.Client) -> None:
        assert client.put("/speed", json={"speed_rpm": 500}).json()["speed_rpm"] == 500.0
        assert drum.speed_rpm == 500.0
        assert client.put("/new-run").json()["run"] == 2
        assert client.put("/new-run", json={}).json()["run"] == 3

    def test_all_faults_can_be_stated_and_healed(self, drum: SimulatedDrum, client: httpx2.Client) -> None:
        faults = Faults(
            0.1, ("P",), ("Q",), ("P", "Q"), True, True, 20.0, True, LooseMass("1", 5.0, 2.0, True), Bend(3.0, 40.0)
        )
        assert client.put("/faults", json=asdict(faults)).status_code == 200
        assert drum.faults == faults
        assert client.put("/faults", json={"swapped": None, "loose_trial_mass": {"plane": "2"}}).status_code == 200
        assert drum.faults == Faults(loose_trial_mass=LooseMass("2"))
        assert client.put("/faults", json={}).status_code == 200
        assert drum.faults == Faults()

    def test_the_state_tells_the_counters(self, drum: SimulatedDrum, client: httpx2.Client) -> None:
        drum.measure(2)
        state = client.get("/state").json()
        assert (state["source"], state["run"]) == ("sim", 1)
        assert state["health"] == {
            "state": "open", "delivered": 4, "refused": 0, "missed": 0, "last_taken_at": "2026-01-01T00:00:00+00:00",
        }  # fmt: skip


class TestRefusals:
    @pytest.mark.parametrize(
        ("path", "body", "status", "says"),
        [
            ("/masses", b'{"plane": "1"}', 422, "give a list of objects"),
            ("/masses", b'["1"]', 422, "masses[0] is '1': give an object"),
            ("/masses", b'[{"plane": "1", "mass_g": 5}]', 422, "must include angle_deg"),
            ("/masses", b'[{"plane": "9", "mass_g": 5, "angle_deg": 0}]', 422, "plane '9' is not on this drum"),
            ("/masses", b'[{"plane": "1", "mass_g": -5, "angle_deg": 0}]', 422, "mass_g -5.0 in plane '1' must be > 0"),
            ("/masses", b'[{"plane": "1", "mass_g": "5", "angle_deg": 0}]', 422, "give a number"),
            ("/masses", b'[{"plane": "1", "mass_g": true, "angle_deg": 0}]', 422, "give a number"),
            ("/masses", b'[{"plane": "1", "mass_g": 5, "angle_deg": 0, "x": 1}]', 422, "field 'x' of masses[0]"),
            ("/masses", b'[{"plane": "1", "mass_g": NaN, "angle_deg": 0}]', 422, "holds NaN: give a finite number"),
            ("/masses", b'[{"plane": "1", "mass_g": 1e999, "angle_deg": 0}]', 422, "must be a finite number"),
            (
                "/masses",
                b'[{"plane": "1", "mass_g": 1' + 400 * b"0" + b', "angle_deg": 0}]',
                422,
                "more than 300 digits",
            ),
            ("/masses", b"[" + 1001 * b"1," + b"1]", 422, "must be at most 1000"),
            ("/masses", b"[" * 100_000, 400, "is not JSON"),
            ("/masses", b"\xff\xfe\x00", 400, "is not JSON"),
            ("/speed", b"", 422, "give an object"),
            ("/speed", b'{"speed_rpm": 0}', 422, "must be a number above 0"),
            ("/speed", b'{"speed": 5}', 422, "field 'speed' of speed is unknown"),
            ("/faults", b'{"stuck": "P"}', 422, "give a list of names"),
            ("/faults", b'{"stuck": ["R"]}', 422, "sensor 'R' is not on this drum: use one of P, Q"),
            ("/faults", b'{"swapped": ["P"]}', 422, "be two names, or null"),
            ("/faults", b'{"wrong_phase_sense": 1}', 422, "give true or false"),
            ("/faults", b'{"loose_trial_mass": {"lost": true}}', 422, "must include plane"),
            ("/faults", b'{"gremlins": true}', 422, "field 'gremlins' of faults is unknown"),
            ("/new-run", b"[1]", 422, "must be empty"),
            ("/state", b"{}", 405, "use GET"),
            ("/", b"{}", 404, "use GET /state, PUT /masses"),
            ("/masses", b" " * (MAX_BYTES + 1), 413, "is too large"),
        ],
    )
    def test_a_bad_request_is_named_and_changes_nothing(
        self, drum: SimulatedDrum, client: httpx2.Client, path: str, body: bytes, status: int, says: str
    ) -> None:
        before = (drum.masses, drum.speed_rpm, drum.faults, drum.run)
        answer = client.put(path, content=body)
        assert answer.status_code == status
        assert answer.headers["content-type"] == "application/problem+json"
        assert answer.json()["status"] == status
        assert says in answer.json()["detail"]
        assert (drum.masses, drum.speed_rpm, drum.faults, drum.run) == before

    def test_other_methods_and_a_body_without_length_are_refused(self, client: httpx2.Client) -> None:
        assert client.post("/masses", json=[]).status_code == 405
        assert client.delete("/state").status_code == 405
        assert client.put("/masses", content=iter([b"[]"])).status_code == 411

    @given(st.sampled_from(sorted(COMMANDS)), st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
            st.sampled_from(["plane", "mass_g", "angle_deg", "speed_rpm", "stuck", "loose_trial_mass"]), inner
        ),
    ))  # fmt: skip
    @settings(max_examples=200)
    def test_any_json_is_done_or_refused_as_documented(self, command: str, body: object) -> None:
        drum = SimulatedDrum(threshing_drum_example(), seed=1, clock=ManualClock())
        before = (drum.masses, drum.speed_rpm, drum.faults, drum.run)
        try:
            COMMANDS[command](drum, body)
        except InvalidSetting:
            assert (drum.masses, drum.speed_rpm, drum.faults, drum.run) == before


class TestPort:
    def test_a_port_in_use_is_refused_and_opening_twice_too(self, drum: SimulatedDrum) -> None:
        with ControlPort(drum) as port:
            taken = int(port.url.rsplit(":", 1)[1])
            with pytest.raises(PortUnavailable, match=f"{taken} cannot be opened"):
                ControlPort(drum, port=taken).open()
            with pytest.raises(PortUnavailable, match="open already"):
                port.open()

    @pytest.mark.parametrize("port", [-1, 70000])
    def test_a_number_that_is_no_port_is_refused(self, drum: SimulatedDrum, port: int) -> None:
        with pytest.raises(PortUnavailable):
            ControlPort(drum, port=port).open()

    def test_it_closes_for_good_and_can_be_opened_again(self, drum: SimulatedDrum) -> None:
        port = ControlPort(drum)
        port.close()
        with port:
            url = port.url
        with pytest.raises(PortUnavailable, match="not open"):
            _ = port.url
        with pytest.raises(httpx2.ConnectError):
            httpx2.get(f"{url}/state", trust_env=False)
        with port:
            assert httpx2.get(f"{port.url}/state", trust_env=False).status_code == 200
