"""What logs call their arms, in every format that can tell."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from mcap.writer import Writer

from friction_audit.io.readers import arm_of_log, read_log
from friction_audit.io.readers.channel_names import serial_in
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import JointLog, Source

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "sample_logs" / "formats"


@pytest.mark.parametrize(
    ("topic", "names", "told"),
    [
        (None, ["joint1", "joint2"], ""),
        (None, ["panda_joint1", "panda_joint2"], ""),
        (None, ["fr3v2_joint1", "fr3v2_joint2"], ""),
        (None, ["left_joint1", "left_joint2"], "left"),
        (None, ["panda_2_joint1", "panda_2_joint2"], "panda_2"),
        ("/joint_states", ["panda_joint1", "panda_joint2"], ""),
        ("/left/joint_states", ["panda_joint1", "panda_joint2"], "left"),
        ("/cell/left/franka_state_controller/franka_states", ["panda_joint1", "panda_joint2"], "cell/left"),
        ("/franka_state_controller/franka_states", ["panda_joint1", "panda_joint2"], ""),
        ("/left/joint_states", ["right_joint1", "right_joint2"], "right"),
    ],
)
def test_names_before_namespaces(topic: str | None, names: Sequence[str], told: str) -> None:
    assert arm_of_log(Source(path="x", sha256="0", format="csv", topic=topic), names) == told


def test_a_serial_number_before_all() -> None:
    source = Source(path="x", sha256="0", format="csv", topic="/left/joint_states", serial="295341-1324")
    assert arm_of_log(source, ["right_joint1"]) == "295341-1324"


@pytest.mark.parametrize(
    ("notes", "serial"),
    [
        ({"Serial-Number": " 295341 "}, "295341"),
        ({"robot serial": "A1", "serial": ""}, "A1"),
        ({"serialised": "x", "port": "serial"}, ""),
    ],
)
def test_serial_numbers_among_notes(notes: dict[str, str], serial: str) -> None:
    assert serial_in(notes) == serial


@pytest.fixture
def log() -> JointLog:
    return read_log(SAMPLES / "parquet.parquet")


def test_parquet_keeps_serial_number_and_start(log: JointLog, tmp_path: Path) -> None:
    marked = replace(log, source=replace(log.source, serial="295341", start_s=1.77e9))
    again = read_log(write_to(marked, tmp_path / "a.parquet")).source
    assert (again.serial, again.start_s) == ("295341", 1.77e9)
    table = pq.read_table(tmp_path / "a.parquet")
    pq.write_table(table.replace_schema_metadata({"start_s": "soon"}), tmp_path / "b.parquet")
    other = read_log(tmp_path / "b.parquet").source
    assert (other.serial, other.start_s) == ("", None)


def write_to(log: JointLog, path: Path) -> Path:
    write_log(log, path)
    return path


def test_mcap_tells_it_in_a_metadata_record(tmp_path: Path) -> None:
    original = SAMPLES / "mcap.mcap"
    assert read_log(original).source.serial == ""
    path = tmp_path / "marked.mcap"
    path.write_bytes(with_metadata(original.read_bytes(), tmp_path / "note.mcap"))
    assert read_log(path).source.serial == "295341"


def with_metadata(content: bytes, scratch: Path) -> bytes:
    """Put a metadata record before the first record behind the header."""
    with scratch.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.add_metadata("robot", {"serial": "295341"})
        writer.finish()  # type: ignore[no-untyped-call]
    header = 8 + 9 + int.from_bytes(content[9:17], "little")
    note = scratch.read_bytes()
    start = 8 + 9 + int.from_bytes(note[9:17], "little")
    length = 9 + int.from_bytes(note[start + 1 : start + 9], "little")
    return content[:header] + note[start : start + length] + content[header:]


def test_a_bag_tells_it_in_its_custom_data(tmp_path: Path) -> None:
    bag = tmp_path / "run"
    bag.mkdir()
    for file in (SAMPLES / "rosbag2-sqlite3").iterdir():
        (bag / file.name).write_bytes(file.read_bytes())
    assert read_log(bag).source.serial == ""
    with (bag / "metadata.yaml").open("a") as stream:
        stream.write("  custom_data:\n    serial: '295341'\n    operator: Ann\n")
    assert read_log(bag).source.serial == "295341"
