"""Raw waveforms over HTTP: measured, stored as readings, taken into a run."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from drivers.signal import chain, directions
from drivers.signal.block import Block
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.sensors import Sensor
from drivers.simulator.spec import DrumSpec, true_readings
from drivers.simulator.waveforms import Disturbance, simulate_block
from service.model import findings
from service.usecases.readings.retention import retain
from tests.support.http.workshop import Workshop, reading

NOON = "2025-12-01T12:00:00+00:00"
QUIET = Disturbance(electronics=0.002)


def simulated(spec: DrumSpec, seconds: float = 6.0, disturbance: Disturbance = QUIET) -> Block:
    rng = np.random.default_rng(4)
    return simulate_block(spec, seconds=seconds, sample_rate_hz=512.0, rng=rng, disturbance=disturbance)


def body(block: Block, **changes: Any) -> dict[str, Any]:
    """The block as a client sends it."""
    channels = [
        {"sensor": channel.sensor, "samples": samples.tolist()}
        for channel, samples in zip(block.channels, block.samples, strict=True)
    ]
    stamp = {"source": "box", "sequence": 10, "taken_at": NOON, "sample_rate_hz": block.sample_rate_hz}
    whole = {**stamp, "channels": channels, "edges_s": block.edges_s.tolist(), **changes}
    return {name: value for name, value in whole.items() if value is not ...}


def silent(sensor: str, count: int) -> dict[str, Any]:
    """A channel that feels nothing."""
    return {"sensor": sensor, "samples": [0.0] * count}


@pytest.fixture
def machine(shop: Workshop) -> str:
    """A machine with a box that sends blocks."""
    stored = shop.machine()
    shop.ask("PUT", "/sources/box", {"machine_id": stored})
    return stored


@pytest.mark.usefixtures("machine")
class TestBlocks:
    def test_a_block_becomes_the_readings_of_its_channels_once(self, shop: Workshop) -> None:
        spec = threshing_drum_example()
        sent = body(simulated(spec))
        receipt = shop.post("/blocks", sent)
        assert (receipt["accepted"], receipt["duplicates"], receipt["refused"]) == (2, 0, [])
        for sequence, one in enumerate(receipt["measured"], start=10):
            amplitude, phase_deg = true_readings(spec, speed_rpm=one["speed_rpm"])[one["sensor"]]
            assert one["sequence"] == sequence
            assert one["amplitude"] == pytest.approx(amplitude, rel=0.005)
            assert one["phase_deg"] == pytest.approx(phase_deg, abs=0.5)
            assert [c["order"] for c in one["components"]] == [1, 2, 3, 4, 5]
            assert one["scatter"] > 0.0
        again = shop.post("/blocks", sent)
        assert (again["accepted"], again["duplicates"]) == (0, 2)
        assert again["measured"] == receipt["measured"]
        assert shop.count("reading") == 2

    def test_a_run_is_taken_from_them(self, shop: Workshop, machine: str) -> None:
        spec = threshing_drum_example()
        shop.post("/blocks", body(simulated(spec)))
        take = {"source": "box", "from": NOON, "to": "2025-12-01T12:01:00+00:00"}
        run = shop.post(f"/sessions/{shop.session(machine)}/runs", {"kind": "initial", "take": take})
        for one in run["readings"]:
            assert one["amplitude"] == pytest.approx(true_readings(spec)[one["sensor"]][0], rel=0.005)

    def test_what_was_found_beside_a_reading_is_kept_with_it(self, shop: Workshop, machine: str) -> None:
        block = simulated(threshing_drum_example(), disturbance=replace(QUIET, full_scale=0.2))
        sent = body(block, accept_clipped=True)
        measured = shop.post("/blocks", sent)["measured"]
        shop.post("/blocks", sent)
        assert shop.count("reading_findings") == 2
        kept = ("turns", "components", "neighbour", "flags")
        told = [{**{name: one[name] for name in kept}, "directions": None} for one in measured]
        listed = shop.get("/sources/box/readings")
        assert [(one["sequence"], one["findings"]) for one in listed] == [(11, told[1]), (10, told[0])]
        assert shop.get("/sources/box/readings?offset=1&limit=1") == listed[1:]
        assert shop.get("/sources/box/readings?from=2025-12-01T12:00:01Z") == []
        session = shop.session(machine)
        shop.post("/blocks", {**sent, "sequence": 20, "taken_at": "2025-12-01T12:00:10Z"})
        shop.post("/readings", {**reading("Q", 1.0 + 0j), "source": "box", "sequence": 30, "taken_at": NOON})
        take = {"source": "box", "from": NOON, "to": "2025-12-01T12:01:00Z"}
        run = shop.post(f"/sessions/{session}/runs", {"kind": "initial", "take": take})
        now = shop.get(f"/sessions/{session}/now")["sensors"]
        assert [one["findings"]["turns"] for one in now] == [one["turns"] for one in told]
        for one, single in zip(run["readings"], told, strict=True):
            assert one["findings"]["turns"] == 2 * single["turns"]
            assert one["findings"]["flags"] == ["clipped"]
            for mean, part in zip(one["findings"]["components"], single["components"], strict=True):
                assert mean == pytest.approx(part)
        shop.now.clock.advance(400 * 86_400.0)
        assert retain(shop.work, 30).readings == 5
        assert shop.count("reading_findings") == 0
        assert shop.get(f"/sessions/{session}/log")["runs"][0]["readings"] == run["readings"]

    def test_the_flags_of_the_chain_are_those_that_are_stored(self) -> None:
        assert get_args(findings.Flag) == get_args(chain.Flag)
        assert get_args(findings.Doubt) == get_args(directions.Doubt)

    def test_a_tachometer_signal_does_as_well_as_edges(self, shop: Workshop) -> None:
        spec = threshing_drum_example()
        block = simulated(spec)
        since = np.arange(block.samples.shape[1])[:, None] / 512.0 - block.edges_s[None, :]
        pulses = np.where(((since >= 0.0) & (since < 0.02)).any(axis=1), 24.0, 0.3)
        sent = body(block, edges_s=..., tachometer={"samples": pulses.tolist()})
        for one in shop.post("/blocks", sent)["measured"]:
            amplitude, phase_deg = true_readings(spec, speed_rpm=one["speed_rpm"])[one["sensor"]]
            assert one["amplitude"] == pytest.approx(amplitude, rel=0.005)
            # a step is seen half a sample too late on average at most: 512 Hz at 460 r/min are 5.4 degrees a sample
            assert one["phase_deg"] == pytest.approx(phase_deg, abs=1.0)

    def test_a_dead_channel_is_named_and_the_others_are_stored(self, shop: Workshop) -> None:
        sent = body(simulated(threshing_drum_example()))
        sent["channels"][0]["samples"] = [None] * len(sent["channels"][0]["samples"])
        receipt = shop.post("/blocks", sent)
        assert [(one["sensor"], one["code"]) for one in receipt["refused"]] == [("P", "dropout")]
        assert [(one["sensor"], one["sequence"]) for one in receipt["measured"]] == [("Q", 11)]
        assert shop.count("reading") == 1

    def test_a_clipped_channel_is_taken_only_where_the_client_says_so(self, shop: Workshop) -> None:
        clipped = body(simulated(threshing_drum_example(), disturbance=Disturbance(full_scale=0.2)))
        problem = shop.refused("POST", "/blocks", clipped, 422, "signal_clipped")
        assert problem["field"] == "channels"
        receipt = shop.post("/blocks", {**clipped, "accept_clipped": True})
        assert [one["flags"] for one in receipt["measured"]] == [["clipped"], ["clipped"]]

    def test_the_machines_phase_sense_and_the_sensors_units_are_kept(self, shop: Workshop) -> None:
        sensors = [
            {"name": "P", "quantity": "displacement", "unit": "mil", "detection": "peak_to_peak"},
            {"name": "Q", "unit": "in/s", "detection": "peak"},
        ]
        shop.ask("PUT", "/sources/box", {"machine_id": shop.machine(sensors=sensors, phase_sense="lead")})
        spec = replace(
            threshing_drum_example(),
            phase_sense="lead",
            sensors=(
                Sensor("P", -480.0, 0.0, "displacement", "mil", "peak_to_peak"),
                Sensor("Q", 440.0, 0.0, "velocity", "in/s", "peak"),
            ),
        )
        sent = body(simulated(spec))
        for channel in sent["channels"]:
            channel["samples"] = [value / 9.80665 for value in channel["samples"]]
            channel["unit"] = "g"
        for one in shop.post("/blocks", sent)["measured"]:
            amplitude, phase_deg = true_readings(spec, speed_rpm=one["speed_rpm"])[one["sensor"]]
            assert one["amplitude"] == pytest.approx(amplitude, rel=0.005)
            assert one["phase_deg"] == pytest.approx(phase_deg, abs=0.5)

    def test_directions_at_a_bearing_are_compared(self, shop: Workshop) -> None:
        sensors = [
            {"name": name, "bearing": "P", "direction": direction, "unit": unit}
            for name, direction, unit in (("H", "horizontal", "mm/s"), ("V", "vertical", "mm/s"))
        ]
        shop.ask("PUT", "/sources/box", {"machine_id": shop.machine(sensors=sensors)})
        spec = replace(threshing_drum_example(), sensors=(Sensor("H", -480.0, 0.0), Sensor("V", -480.0, 90.0)))
        (bearing,) = shop.post("/blocks", body(simulated(spec)))["directions"]
        true = true_readings(spec)
        assert bearing["bearing"] == "P"
        assert bearing["h_to_v"] == pytest.approx(true["H"][0] / true["V"][0], rel=0.01)
        apart = (true["H"][1] - true["V"][1] + 180.0) % 360.0 - 180.0
        assert bearing["h_minus_v_deg"] == pytest.approx(apart, abs=1.0)
        assert bearing["axial_to_radial"] is None
        kept = shop.get("/sources/box/readings")
        assert [one["findings"]["directions"] for one in kept] == [bearing, bearing]


class TestRefusals:
    """Nothing is stored by any of them."""

    @pytest.mark.parametrize(
        ("changes", "code"),
        [
            ({"edges_s": [0.0, 0.1, 0.2]}, "signal_too_short"),
            ({"edges_s": [float(x) for x in np.sort(np.random.default_rng(1).uniform(0.0, 6.0, 60))]}, "signal_tacho"),
            ({"nominal_rpm": 920.0}, "signal_speed"),
            ({"sample_rate_hz": 12.0, "edges_s": [i / 10.0 for i in range(60)]}, "signal_sampling"),
            ({"edges_s": [0.3, 0.2, 0.4, 0.5, 0.6]}, "invalid_input"),
            ({"edges_s": ...}, "invalid_input"),
            ({"tachometer": {"samples": [0.0, 1.0]}}, "invalid_input"),
            ({"channels": []}, "invalid_input"),
            ({"channels": [silent("P", 9), silent("Q", 8)]}, "invalid_input"),
            ({"channels": [silent("P", 9), silent("P", 9)]}, "invalid_input"),
            ({"channels": [silent("X", 9)]}, "invalid_input"),
            ({"channels": [{**silent("P", 9), "unit": "mm/s"}]}, "invalid_input"),
            ({"band_hz": [20.0, 10.0]}, "invalid_input"),
            ({"sample_rate_hz": 0.0}, "invalid_input"),
            ({"taken_at": "2025-12-01T12:00:00"}, "invalid_input"),
            ({"surprise": 1}, "invalid_input"),
        ],
    )  # fmt: skip
    def test_with_the_reason(self, shop: Workshop, machine: str, changes: dict[str, Any], code: str) -> None:
        shop.refused("POST", "/blocks", body(simulated(threshing_drum_example()), **changes), 422, code)

    @pytest.mark.parametrize(
        ("changes", "field", "value"),
        [
            ({"edges_s": [0.1, 0.2, 0.2, 0.5]}, "edges_s[2]", 0.2),
            ({"band_hz": [20.0, 10.0]}, "band_hz", [20.0, 10.0]),
            ({"channels": [silent("P", 9), silent("P", 9)]}, "channels", ["P", "P"]),
        ],
    )
    def test_with_the_field_and_its_value(
        self, shop: Workshop, machine: str, changes: dict[str, Any], field: str, value: object
    ) -> None:
        sent = body(simulated(threshing_drum_example()), **changes)
        problem = shop.refused("POST", "/blocks", sent, 422, "invalid_input")
        assert (problem["field"], problem["value"]) == (field, value)

    def test_an_unbound_source(self, shop: Workshop) -> None:
        sent = body(simulated(threshing_drum_example()), source="nobody")
        shop.refused("POST", "/blocks", sent, 404, "source_not_bound")

    def test_a_number_used_for_another_block(self, shop: Workshop, machine: str) -> None:
        spec = threshing_drum_example()
        shop.post("/blocks", body(simulated(spec)))
        louder = body(simulated(replace(spec, unbalances=(replace(spec.unbalances[0], amount_g_mm=9e4),))))
        shop.refused("POST", "/blocks", louder, 409, "sequence_reused")

    @pytest.mark.parametrize("number", ["NaN", "Infinity", "1e400", '"1"', "true"])
    def test_samples_that_are_no_numbers(self, shop: Workshop, machine: str, number: str) -> None:
        text = (
            f'{{"source": "box", "sequence": 1, "taken_at": "{NOON}", "sample_rate_hz": 512.0, "edges_s": [],'
            f' "channels": [{{"sensor": "P", "samples": [0.0, {number}]}}]}}'
        )
        answer = shop.client.post("/api/v1/blocks", content=text, headers={"content-type": "application/json"})
        assert answer.status_code == 422, answer.text
        assert shop.count("reading") == 0
