"""What logs call their arms, in every format that can tell."""

import shutil
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from friction_audit.io.readers import arm_of_log, read_log
from friction_audit.io.readers.channel_names import serial_in
from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import Source
from tests.io.bag_writing import joint_states, ros2_store, samples, write_mcap

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "sample_logs" / "formats"


@pytest.mark.parametrize(
    ("topic", "joints", "name"),
    [
        (None, "joint", ""),
        (None, "panda_joint", ""),
        (None, "fr3v2_joint", ""),
        (None, "left_joint", "left"),
        (None, "panda_2_joint", "panda_2"),
        ("/joint_states", "panda_joint", ""),
        ("/left/joint_states", "panda_joint", "left"),
        ("/cell/left/franka_state_controller/franka_states", "panda_joint", "cell/left"),
        ("/franka_state_controller/franka_states", "panda_joint", ""),
        ("/left/joint_states", "right_joint", "right"),
    ],
)
def test_serial_numbers_before_names_before_namespaces(topic: str | None, joints: str, name: str) -> None:
    source = Source(path="x", sha256="0", format="csv", topic=topic)
    assert arm_of_log(source, [f"{joints}1", f"{joints}2"]) == name
    assert arm_of_log(replace(source, serial="295341-1324"), [f"{joints}1"]) == "295341-1324"


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


def test_parquet_keeps_serial_number_and_start(tmp_path: Path) -> None:
    log = read_log(SAMPLES / "parquet.parquet")
    marked = replace(log, source=replace(log.source, serial="295341", start_s=1.77e9))
    write_log(marked, tmp_path / "a.parquet")
    again = read_log(tmp_path / "a.parquet").source
    assert (again.serial, again.start_s) == ("295341", 1.77e9)
    table = pq.read_table(tmp_path / "a.parquet")
    pq.write_table(table.replace_schema_metadata({"start_s": "soon"}), tmp_path / "b.parquet")
    other = read_log(tmp_path / "b.parquet").source
    assert (other.serial, other.start_s) == ("", None)


def test_mcap_tells_it_in_a_metadata_record(tmp_path: Path) -> None:
    streams = [joint_states(ros2_store(), samples(20))]
    for number, chunked in enumerate((True, False)):
        path = tmp_path / f"{number}.mcap"
        write_mcap(path, ros2_store(), streams, notes={"serial": "295341"}, use_chunking=chunked)
        assert read_log(path).source.serial == "295341"


def test_a_bag_tells_it_in_its_custom_data(tmp_path: Path) -> None:
    bag = shutil.copytree(SAMPLES / "rosbag2-sqlite3", tmp_path / "run")
    assert read_log(bag).source.serial == ""
    with (bag / "metadata.yaml").open("a") as stream:
        stream.write("  custom_data:\n    serial: '295341'\n    operator: Ann\n")
    assert read_log(bag).source.serial == "295341"
