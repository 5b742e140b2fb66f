"""ROS 2 bags: sqlite3 and MCAP storage, with and without metadata and definitions."""

import os
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard

from friction_audit.errors import InputError
from friction_audit.io.readers import list_topics, read_log
from friction_audit.io.readers.message_decoder import _ERRORS, _FRANKA_GENERATIONS, franka_types
from friction_audit.io.readers.reader import ReadOptions
from tests.io import bag_writing as bags
from tests.io.synthetic_recordings import refused

STORE = bags.ros2_store()
STATE = "franka_msgs/msg/FrankaState"
LongBag = tuple[Path, bags.Samples]


def storage_file(bag: Path) -> Path:
    return next(entry for entry in bag.iterdir() if entry.name != "metadata.yaml")


def execute(database: Path, *commands: tuple[Any, ...]) -> Path:
    """Change what is in a database."""
    with closing(sqlite3.connect(database)) as connection, connection:
        for command in commands:
            connection.execute(*command)
    return database


def edited(folder: Path, count: int, *commands: tuple[Any, ...]) -> LongBag:
    """Write a bag and change what is in its database."""
    values = bags.samples(count)
    path = bags.write(folder / "bag", values)
    execute(storage_file(path), *commands)
    return path, values


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
@pytest.mark.parametrize("alone", [True, False])
def test_without_metadata(tmp_path: Path, storage: str, alone: bool) -> None:
    values = bags.samples(20)
    path = bags.write(tmp_path / "bag", values, storage=storage)
    (path / "metadata.yaml").unlink()
    given = storage_file(path) if alone else path
    bags.assert_read(bags.read(given), values)
    assert list_topics(given)[1][0].messages == 20


def test_several_storage_files_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    values = bags.samples(33)
    folder = tmp_path / "bag"
    folder.mkdir()
    for number in range(11):
        part = {name: array[3 * number : 3 * number + 3] for name, array in values.items()}
        topic, kind, messages = bags.joint_states(STORE, part)
        shifted = [(time + 3 * number * bags.STEP_NS, message) for time, message in messages]
        bag = bags.write(tmp_path / f"part{number}", [(topic, kind, shifted)])
        storage_file(bag).rename(folder / f"bag_{number}.db3")
    bags.assert_read(bags.read(folder), values)
    assert list_topics(folder)[1][0].messages == 33


def test_storage_file_that_metadata_lists_is_gone(tmp_path: Path) -> None:
    path = bags.write(tmp_path / "bag", bags.samples(5))
    file = storage_file(path)
    file.rename(path / "other.db3")
    refused(rf"metadata.yaml lists {file.name}, not to be found.*other.db3", bags.read, path)


def test_messages_that_lack_joints(tmp_path: Path) -> None:
    values = bags.samples(10)
    sent = [(bags.stamp_ns(i), bags.joint_state(STORE, i, values, names=bags.JOINTS[: 7 - i % 2])) for i in range(10)]
    recording = bags.read(bags.write(tmp_path / "bag", [("/j", bags.JOINT_STATE, sent)]))
    assert np.isnan(recording.channels["q"][1::2, 6]).all()
    np.testing.assert_array_equal(recording.channels["q"][:, :6], values["q"][:, :6])
    assert [finding.code for finding in recording.findings] == ["incomplete_messages"]


NO_DEFINITIONS = ("DROP TABLE message_definitions",)  # as recorded before Iron
GENERATIONS = [("FrankaRobotState", _FRANKA_GENERATIONS[1], _ERRORS[0])]
GENERATIONS += [(name.partition("_")[0], name, errors) for name in _FRANKA_GENERATIONS for errors in _ERRORS]


@pytest.mark.parametrize(("name", "generation", "errors"), GENERATIONS)
def test_franka_generations(tmp_path: Path, name: str, generation: str, errors: str) -> None:
    typename, store, values = f"franka_msgs/msg/{name}", bags.ros2_store(), bags.samples(30)
    store.register(franka_types((errors, "CollisionIndicators", "Elbow", generation), typename))
    stream = bags.franka_messages(store, typename, values, bags.JOINTS[::-1])
    bag, tau = bags.write(tmp_path / "bag", [stream], store), values["tau_J"]
    for commands in ((), (NO_DEFINITIONS,)):
        execute(storage_file(bag), *commands)
        recording = bags.read(bag)
        bags.assert_read(recording, {**values, "tau_J_d": -tau, "tau_ext_hat_filtered": 2 * tau})
        assert (recording.clock, recording.topic) == ("robot_time", stream[0])


def test_franka_state_of_no_known_generation(tmp_path: Path) -> None:
    store = bags.ros2_store((STATE, "std_msgs/Header header\nfloat64[7] q\nfloat64[7] dq\nfloat64[7] tau_j\n"))
    values = bags.samples(5)
    rows = [{name.lower() if name == "tau_J" else name: array[i] for name, array in values.items()} for i in range(5)]
    messages = [(bags.stamp_ns(i), bags.fill(store, STATE, **row)) for i, row in enumerate(rows)]
    bag = bags.write(tmp_path / "bag", [("/state", STATE, messages)], store)
    bags.assert_read(bags.read(bag), values)
    execute(storage_file(bag), NO_DEFINITIONS)
    refused(r"no topic with measured joint states.*/state", bags.read, bag)


def test_big_endian_messages_are_decoded_one_by_one(tmp_path: Path) -> None:
    values = bags.samples(10)
    messages = (bags.joint_state(STORE, i, values) for i in range(10))
    payloads = (bytes(STORE.serialize_cdr(one, bags.JOINT_STATE, little_endian=False)) for one in messages)
    commands = [("UPDATE messages SET data = ? WHERE id = ?", (one, i)) for i, one in enumerate(payloads, start=1)]
    bags.assert_read(bags.read(edited(tmp_path, 10, *commands)[0]), values)


OTHER_TABLE = """PRAGMA page_size = 512; VACUUM; ALTER TABLE messages RENAME TO old;
    CREATE TABLE messages AS SELECT data, timestamp, id, topic_id FROM old"""
AS_TEXT = "UPDATE messages SET data = printf('%.*c', LENGTH(data), 'x') WHERE id = 40"


@pytest.mark.parametrize(
    ("command", "lost", "codes"),
    [
        ("UPDATE messages SET data = x'00010000ff' WHERE id = 4", [3], {"undecodable_messages"}),
        (AS_TEXT, [39], {"truncated", "missing_messages"}),
        ("UPDATE messages SET timestamp = 'noon' WHERE id = 40", [39], {"truncated", "missing_messages"}),
        ("DELETE FROM messages WHERE id BETWEEN 4 AND 6", [3, 4, 5], {"missing_messages"}),
        (OTHER_TABLE, [], set()),
    ],
    ids=["does not fit", "a text as long", "no time", "counted by metadata.yaml alone", "none"],
)
def test_what_is_no_message_is_left_out(tmp_path: Path, command: str, lost: list[int], codes: set[str]) -> None:
    path, values = edited(tmp_path, 50, *((one,) for one in command.split(";")))
    recording = bags.read(path)
    bags.assert_read(recording, {name: np.delete(array, lost, axis=0) for name, array in values.items()})
    assert {finding.code for finding in bags.damage(recording)} == codes
    assert sum(finding.amount or 0 for finding in recording.findings[-1:]) == len(lost)


def test_messages_that_are_still_in_the_write_ahead_journal(tmp_path: Path) -> None:
    values = bags.samples(12)
    file = storage_file(bags.write(tmp_path / "bag", values))
    with closing(sqlite3.connect(file)) as connection:
        connection.executescript("PRAGMA journal_mode=WAL; DELETE FROM messages WHERE id > 10")
        alone = shutil.copytree(file.parent, tmp_path / "alone", ignore=shutil.ignore_patterns("*-shm"))
    bags.assert_read(bags.read(alone), {name: array[:10] for name, array in values.items()})
    assert not list(alone.glob("*-shm"))


def test_no_message_that_fits(tmp_path: Path) -> None:
    path, _ = edited(tmp_path, 3, ("UPDATE messages SET data = x'00010000ff'",))
    refused(r"/joint_states of type sensor_msgs/msg/JointState do not fit", bags.read, path)


ROWS = 9500
"""A thousand pages: the table has two levels of interior pages, the first of which lies in the middle of the file."""


@pytest.fixture(scope="module")
def long_bag(tmp_path_factory: pytest.TempPathFactory) -> LongBag:
    values = bags.samples(ROWS)
    values["q"] = np.cumsum(values["dq"], axis=0) * 1e-9 * bags.STEP_NS  # the checks compare them
    return bags.write(tmp_path_factory.mktemp("long") / "bag", values), values


def cut(bag: Path, copy: Path, share: float) -> Path:
    """Cut the storage file of a copy of a bag off, and return it."""
    file = storage_file(shutil.copytree(bag, copy))
    os.truncate(file, int(share * file.stat().st_size))
    return file


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7, 0.9, 0.99])
def test_database_that_is_cut_off_is_salvaged(tmp_path: Path, long_bag: LongBag, share: float) -> None:
    bag, values = long_bag
    file = cut(bag, tmp_path / "bag", share)
    for path, codes in ((file, ["truncated"]), (file.parent, ["truncated", "missing_messages"])):
        recording = bags.read(path)
        saved = len(recording.t)
        assert 0.98 * share < saved / ROWS <= share
        bags.assert_read(recording, {name: array[:saved] for name, array in values.items()})
        assert [finding.code for finding in bags.damage(recording)] == codes


def test_packed_file_that_is_cut_off_is_salvaged(tmp_path: Path, long_bag: LongBag) -> None:
    packed = zstandard.ZstdCompressor().compress(storage_file(long_bag[0]).read_bytes())
    (tmp_path / "a.db3.zstd").write_bytes(packed[: len(packed) // 2])
    recording = bags.read(tmp_path / "a.db3.zstd")
    saved = len(recording.t)
    assert 0.4 < saved / ROWS < 0.6
    bags.assert_read(recording, {name: array[:saved] for name, array in long_bag[1].items()})
    assert "truncated" in [finding.code for finding in bags.damage(recording)]
    (tmp_path / "b.db3.zstd").write_bytes(zstandard.ZstdCompressor().compress(b""))
    with pytest.raises(InputError, match=f"^{tmp_path}/b.db3: is empty"):  # not the place of what was unpacked
        bags.read(tmp_path / "b.db3.zstd")


def test_part_of_a_cut_file(tmp_path: Path, long_bag: LongBag, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.reader.WHOLE_BYTES", 0)
    file = cut(long_bag[0], tmp_path / "bag", 0.5)
    part = read_log(file, ReadOptions(t_start_s=1.0, t_end_s=2.0))
    np.testing.assert_array_equal(part.t, read_log(file).take_window(1.0, 2.0).t)
    assert any(found.damaged for found in part.source.findings)


def test_pages_that_are_broken_in_a_cut_file_lose_their_own_messages_alone(tmp_path: Path, long_bag: LongBag) -> None:
    bag, values = long_bag
    file = cut(bag, tmp_path / "bag", 0.5)
    whole = len(bags.read(file).t)
    content = bytearray(file.read_bytes())
    for page, places in ((100, range(4096)), (200, range(8)), (300, range(8, 20)), (400, range(3000, 4096))):
        for place in places:
            content[4096 * page + place] ^= 0xFF
    first = 4096 * 250 + int.from_bytes(content[4096 * 250 + 8 :][:2], "big")
    content[first + 2 : first + 4] = b"\xff\x7f"  # an id far from its neighbours
    file.write_bytes(content)
    recording = bags.read(file)
    kept = np.isin(values["q"][:, 0], recording.channels["q"][:, 0])
    assert 5 * 8 <= whole - kept.sum() <= 5 * 11
    bags.assert_read(recording, {name: array[kept] for name, array in values.items()})


def test_deleted_messages_do_not_come_back_from_a_cut_file(tmp_path: Path, long_bag: LongBag) -> None:
    bag = shutil.copytree(long_bag[0], tmp_path / "whole")
    commands = ("PRAGMA secure_delete = OFF", "DELETE FROM messages WHERE id BETWEEN 1001 AND 3000")
    execute(storage_file(bag), *((one,) for one in commands))
    recording = bags.read(cut(bag, tmp_path / "bag", 0.5))
    kept = np.isin(long_bag[1]["q"][:, 0], recording.channels["q"][:, 0])
    assert not kept[1000:3000].any()
    assert 0.98 * ROWS / 2 < len(recording.t) + 2000 <= ROWS / 2
    assert kept.sum() == len(recording.t)


def test_cut_messages_that_go_over_several_pages_are_not_filled_up(tmp_path: Path) -> None:
    values = bags.samples(200)
    names = [f"panda_joint{joint}" for joint in range(1, 8)] + [f"{'finger' * 20}{joint}" for joint in range(60)]
    file = storage_file(bags.write(tmp_path / "bag", [bags.joint_states(STORE, values, names=names)]))
    content = file.read_bytes()
    for share in (0.3, 0.62, 0.9, 1.0):
        file.write_bytes(content[: int(share * len(content))])
        recording = bags.read(file)
        kept = np.isin(values["q"][:, 0], recording.channels["q"][:, 0])
        assert 200 * share - 20 < kept.sum() == len(recording.t) <= 200 * share
        np.testing.assert_array_equal(recording.channels["tau_J"][:, :7], values["tau_J"][kept])


def test_page_that_is_lost_leaves_out_its_messages_alone(tmp_path: Path) -> None:
    path, _ = edited(tmp_path, 2000)
    content = bytearray(storage_file(path).read_bytes())
    for page in (100, 150):
        content[4096 * page : 4096 * (page + 1)] = bytes(4096)
    storage_file(path).write_bytes(content)
    recording = bags.read(storage_file(path))
    assert 1900 < len(recording.t) < 2000
    assert "truncated" in [finding.code for finding in bags.damage(recording)]


def test_other_database(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no table messages and no table topics.*tables are logs"):
        bags.read(execute(tmp_path / "other.db3", ("CREATE TABLE logs (id INTEGER)",)))


def test_a_topic_without_messages(tmp_path: Path) -> None:
    path = bags.write(tmp_path / "silent", [("/joint_states", bags.JOINT_STATE, [])])
    refused(r"/joint_states .*0 messages", bags.read, path)
    refused("topic /joint_states has no messages", bags.read, path, topic="joint_states")
