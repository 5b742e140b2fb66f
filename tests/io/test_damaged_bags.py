"""Whatever is broken in a bag: a log or a message, never a library's traceback."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from friction_audit.errors import FrictionAuditError
from friction_audit.io.readers import mcap, rosbag1, rosbag2
from friction_audit.io.readers.reader import ReadOptions
from tests.io.bag_writing import joint_states, ros1_store, ros2_store, samples, write_mcap, write_rosbag1, write_rosbag2


def _rosbag1(folder: Path) -> Path:
    store = ros1_store()
    return write_rosbag1(folder / "a.bag", store, [joint_states(store, samples(20))])


def _mcap(folder: Path) -> Path:
    store = ros2_store()
    return write_mcap(folder / "a.mcap", store, [joint_states(store, samples(20))], enable_crcs=False, chunk_size=2048)


def _loose_mcap(folder: Path) -> Path:
    store = ros2_store()
    return write_mcap(folder / "b.mcap", store, [joint_states(store, samples(20))], use_chunking=False)


def _sqlite3(folder: Path) -> Path:
    store = ros2_store()
    bag = write_rosbag2(folder / "bag", store, [joint_states(store, samples(20))])
    return next(bag.glob("*.db3"))


@pytest.mark.parametrize(
    ("write", "reader"), [(_rosbag1, rosbag1), (_mcap, mcap), (_loose_mcap, mcap), (_sqlite3, rosbag2)]
)
def test_random_bytes_in_random_places(tmp_path: Path, write: Callable[[Path], Path], reader: ModuleType) -> None:
    path = write(tmp_path)
    whole = path.read_bytes()
    rng = np.random.default_rng(7)
    for _ in range(25):
        content = np.frombuffer(whole, np.uint8).copy()
        content[rng.integers(0, len(content), rng.integers(1, 20))] = rng.integers(0, 256)
        path.write_bytes(content.tobytes())
        with suppress(FrictionAuditError):
            assert len(reader.read(path, ReadOptions()).t) <= 20
        with suppress(FrictionAuditError):
            reader.topics(path)
