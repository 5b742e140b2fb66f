"""The block decoder must give what the library's decoder gives, bit for bit, or refuse."""

from typing import Any

import numpy as np
from hypothesis import given, settings, strategies as st

from friction_audit.io.readers.message_decoder import Layout, find_layout
from friction_audit.io.readers.message_stream import Block, one_block
from tests.io.bag_writing import JOINT_STATE, header, ros1_store, ros2_store

STORES = {"ros1": ros1_store(), "cdr": ros2_store()}
NUMBERS = ("header.stamp.sec", "header.stamp.nanosec", "position", "velocity", "effort")
any_name = st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=12)


@st.composite
def same_layout(draw: st.DrawFn) -> tuple[str, list[Any]]:
    """Messages with the same names and array lengths, other values."""
    encoding = draw(st.sampled_from(sorted(STORES)))
    names, frame = draw(st.lists(any_name, max_size=5)), draw(any_name)
    lengths = [draw(st.integers(0, 5)) for _ in range(3)]
    numbers = [st.lists(st.floats(width=64, allow_nan=True), min_size=k, max_size=k) for k in lengths]
    kind: Any = STORES[encoding].types[JOINT_STATE]
    return encoding, [
        kind(header(STORES[encoding], index, frame), names, *(np.array(draw(one), np.float64) for one in numbers))
        for index in range(draw(st.integers(1, 6)))
    ]


def serialise(encoding: str, message: Any) -> bytes:
    store = STORES[encoding]
    return bytes((store.serialize_cdr if encoding == "cdr" else store.serialize_ros1)(message, JOINT_STATE))


def layout_of(encoding: str, payload: bytes) -> Layout:
    return find_layout(payload, JOINT_STATE, STORES[encoding].fielddefs, encoding=encoding)


@settings(max_examples=50)
@given(same_layout(), st.data())
def test_equals_the_librarys_decoder_bit_for_bit(case: tuple[str, list[Any]], data: st.DataObject) -> None:
    encoding, messages = case
    payloads = [serialise(encoding, message) for message in messages]
    layout = layout_of(encoding, payloads[0])
    gaps = data.draw(st.sampled_from([(0,), (5,), (3, 11, 0)]))  # between the payloads: none, even, uneven
    buffer, start = b"", []
    for number, payload in enumerate(payloads):
        start.append(len(buffer))
        buffer += payload + b"\xff" * gaps[number % len(gaps)]
    size = np.full(len(payloads), len(payloads[0]), np.int64)
    records = layout.records(Block(0, np.arange(len(payloads)), buffer, np.array(start, np.int64), size), NUMBERS)
    assert records is not None
    for record, payload in zip(records, payloads, strict=True):
        store = STORES[encoding]
        reference: Any = (store.deserialize_cdr if encoding == "cdr" else store.deserialize_ros1)(payload, JOINT_STATE)
        assert list(layout.strings["name"]) == reference.name
        assert layout.strings["header.frame_id"] == (reference.header.frame_id,)
        assert record["header.stamp.nanosec"][0] == reference.header.stamp.nanosec
        for field in ("position", "velocity", "effort"):
            assert record[field].tobytes() == getattr(reference, field).tobytes()
    changed = list(map(bytearray, payloads))  # any other string or length is refused
    place = data.draw(st.sampled_from(layout.fixed.tolist()))
    data.draw(st.sampled_from(changed))[place] ^= data.draw(st.integers(1, 255))
    assert layout.records(one_block(0, range(len(changed)), list(map(bytes, changed))), NUMBERS) is None
