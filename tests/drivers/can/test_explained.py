"""What `drumtrue check` says of a frame is what the decoder does with it."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.can.decoder import FrameDecoder, Vector
from drivers.can.explained import Explainer
from drivers.can.mapping_file import standard_mapping

MAPPING = standard_mapping(("P", "Q"), ("1",))
IDENTIFIERS = [*sorted({message.frame_id for message in MAPPING.messages()}), 0x7FF]
frames = st.tuples(
    st.sampled_from(IDENTIFIERS), st.binary(max_size=12), st.booleans(), st.floats(0.0, 0.5, allow_nan=False)
)


@given(st.lists(frames, max_size=30))
@settings(max_examples=60, deadline=None)
def test_reasons_and_readings_are_the_decoders(given_frames: list[tuple[int, bytes, bool, float]]) -> None:
    explainer, decoder, at = Explainer(MAPPING), FrameDecoder(MAPPING), 0.0
    for identifier, data, is_data, later in given_frames:
        at += later
        before = dict(decoder.counts)
        found = decoder.feed(identifier, False, data, at, is_data=is_data)
        one = explainer.take(identifier, False, data, at, is_data=is_data)
        assert list(one.found) == found
        assert set(one.reasons) == {reason for reason, count in decoder.counts.items() if count > before[reason]}
        assert (one.message is None) == (identifier == 0x7FF)
        refused = {shown.why for shown in one.signals} - {""}
        if "out_of_range" in refused and not {"not_data", "wrong_length"} & set(one.reasons):
            assert one.reasons == ("out_of_range",)
        if "out_of_range" in one.reasons:
            assert "out_of_range" in refused
    assert explainer.decoder.counts == decoder.counts


def test_a_good_frame_is_shown_with_values_in_the_machines_units() -> None:
    explainer = Explainer(MAPPING)
    data = (3000 | 1120 << 20 | 3500 << 32 | 0b111 << 52 | 7 << 56).to_bytes(8, "little")
    one = explainer.take(801, False, data, 0.0)
    shown = {signal.target: (round(signal.value, 6), signal.unit, signal.why) for signal in one.signals}
    assert shown == {
        "P amplitude": (3.0, "mm/s", ""),
        "P phase": (112.0, "deg", ""),
        "P overall": (3.5, "mm/s", ""),
    }
    (vector,) = one.found
    assert isinstance(vector, Vector)
    assert (vector.sensor, vector.amplitude) == ("P", 3.0)
