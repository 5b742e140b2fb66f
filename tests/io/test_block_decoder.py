"""The block decoder must give what the library's decoder gives, bit for bit, or refuse."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.io.readers.message_layout import Layout, find_layout
from friction_audit.io.readers.message_stream import Block, BrokenError, block_of_payloads
from tests.io.bag_writing import header, ros1_store, ros2_store

STORES = {"ros1": ros1_store(), "cdr": ros2_store()}
KIND = "sensor_msgs/msg/JointState"
NUMBERS = ("header.stamp.sec", "header.stamp.nanosec", "position", "velocity", "effort")

any_float = st.floats(width=64, allow_nan=True)
any_name = st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=12)


@st.composite
def same_layout(draw: st.DrawFn) -> tuple[str, list[Any]]:
    """Messages with the same names and array lengths, other values."""
    encoding = draw(st.sampled_from(sorted(STORES)))
    store = STORES[encoding]
    names = draw(st.lists(any_name, max_size=5))
    frame = draw(any_name)
    lengths = [draw(st.integers(0, 5)) for _ in range(3)]
    kind: Any = store.types[KIND]
    messages = []
    for index in range(draw(st.integers(1, 6))):
        arrays = [np.array(draw(st.lists(any_float, min_size=k, max_size=k)), np.float64) for k in lengths]
        messages.append(kind(header(store, index, frame), names, *arrays))
    return encoding, messages


def serialise(encoding: str, message: Any) -> bytes:
    store = STORES[encoding]
    return bytes((store.serialize_cdr if encoding == "cdr" else store.serialize_ros1)(message, KIND))


def deserialise(encoding: str, payload: bytes) -> Any:
    store = STORES[encoding]
    return (store.deserialize_cdr if encoding == "cdr" else store.deserialize_ros1)(payload, KIND)


def layout_of(encoding: str, payload: bytes) -> Layout:
    return find_layout(payload, KIND, STORES[encoding].fielddefs, encoding=encoding)


@given(same_layout())
def test_equals_the_librarys_decoder_bit_for_bit(case: tuple[str, list[Any]]) -> None:
    encoding, messages = case
    payloads = [serialise(encoding, message) for message in messages]
    layout = layout_of(encoding, payloads[0])
    records = layout.records(block_of_payloads(0, range(len(payloads)), payloads), NUMBERS)
    assert records is not None
    for record, payload in zip(records, payloads, strict=True):
        reference = deserialise(encoding, payload)
        assert list(layout.strings["name"]) == reference.name
        assert layout.strings["header.frame_id"] == (reference.header.frame_id,)
        assert record["header.stamp.nanosec"][0] == reference.header.stamp.nanosec
        for field in ("position", "velocity", "effort"):
            assert record[field].tobytes() == getattr(reference, field).tobytes()


@given(same_layout(), st.data())
def test_any_other_string_or_length_is_refused(case: tuple[str, list[Any]], data: st.DataObject) -> None:
    encoding, messages = case
    payloads = [bytearray(serialise(encoding, message)) for message in messages]
    layout = layout_of(encoding, bytes(payloads[0]))
    victim = data.draw(st.sampled_from(payloads))
    at = data.draw(st.sampled_from(layout.fixed.tolist()))
    victim[at] ^= data.draw(st.integers(1, 255))
    block = block_of_payloads(0, range(len(payloads)), [bytes(p) for p in payloads])
    assert layout.records(block, NUMBERS) is None


def joint_state_payload(encoding: str = "cdr", names: Sequence[str] = ("a_joint1", "a_joint2")) -> bytes:
    kind: Any = STORES[encoding].types[KIND]
    values = np.arange(1.0, len(names) + 1)
    return serialise(encoding, kind(header(STORES[encoding], 0, "base"), list(names), values, -values, 10 * values))


@pytest.mark.parametrize("gaps", [(0, 0), (5, 5), (3, 11)], ids=["joined", "even", "uneven"])
def test_payloads_apart_in_the_buffer(gaps: tuple[int, int]) -> None:
    payload = joint_state_payload()
    size = len(payload)
    buffer = payload + b"\xff" * gaps[0] + payload + b"\xff" * gaps[1] + payload
    start = np.array([0, size + gaps[0], 2 * size + sum(gaps)], np.int64)
    block = Block(0, np.arange(3), buffer, start, np.full(3, size, np.int64))
    records = layout_of("cdr", payload).records(block, NUMBERS)
    assert records is not None
    np.testing.assert_array_equal(records["effort"], [[10.0, 20.0]] * 3)


def test_layout_of_a_cdr_message_known_by_hand() -> None:
    # 4 header, 8 stamp, 4+5 "base\0", 3 padding, 4 count, 4+9 "a_joint1\0", 3 padding, 4+9, 3 padding, 4 count: 64.
    layout = layout_of("cdr", joint_state_payload())
    assert layout.numbers["header.stamp.sec"].offset == 4
    assert layout.numbers["position"].offset == 68
    assert layout.numbers["velocity"].offset == 68 + 16 + 8
    assert layout.strings["name"] == ("a_joint1", "a_joint2")


@pytest.mark.parametrize(
    "payload",
    [b"", b"\x00\x01\x00\x00", joint_state_payload()[:-9], joint_state_payload() + bytes(4)],
    ids=["empty", "header only", "cut off", "too long"],
)
def test_payload_that_does_not_fit_has_no_layout(payload: bytes) -> None:
    with pytest.raises(BrokenError):
        layout_of("cdr", payload)
