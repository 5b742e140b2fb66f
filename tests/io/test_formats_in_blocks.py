"""A log of every format whose reader has blocks gives in blocks what it gives in memory, whatever the blocks."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.io.readers import ReadOptions, read_log
from friction_audit.io.readers.reader import InBlocks
from friction_audit.io.writers.write_log import WRITERS, write_log
from friction_audit.joint_log import JointLog, Source
from friction_audit.log_in_blocks import LogInBlocks
from friction_audit.pipeline import AuditSettings
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from tests.io.synthetic_recordings import motion, refused
from tests.io.test_in_blocks import assert_same_log

BAGS = ("mcap", "mcap-json", "mcap-franka-robot-state", "rosbag1-joint-state", "rosbag2-sqlite3")
FORMS = ("csv", "csv-rostopic", "npz", *BAGS)


@pytest.fixture(scope="module")
def log() -> JointLog:
    """Return a log of seven joints with a gap of 0.3 s."""
    arrays = {name: np.delete(array, slice(3000, 3300), axis=0) for name, array in motion(6000, 7).items()}
    arrays["tau_J"] += 0.02 * np.random.default_rng(0).standard_normal(arrays["q"].shape)
    names = tuple(f"panda_joint{j}" for j in range(1, 8))
    source = Source(path="made", sha256="0" * 64, format="made", robot="panda", start_s=1.7e9)
    return JointLog(**arrays, joint_names=names, source=source)


def cut_into(rows: int, patch: pytest.MonkeyPatch) -> None:
    """Read logs of any size in blocks of about so many rows."""
    for module in ("table", "csv", "messages"):
        patch.setattr(f"friction_audit.io.readers.{module}.IN_BLOCKS_BYTES", 0)
    for module in ("npz", "messages"):
        patch.setattr(f"friction_audit.io.readers.{module}._BLOCK_ROWS", rows)
    patch.setattr("friction_audit.io.readers.csv_lines._BLOCK_BYTES", 400 * rows)


def assert_in_blocks(path: Path, blocks: int) -> None:
    settings = AuditSettings(torque=TorqueSettings(gravity="removed"), cycles=CycleSettings(thresholds="auto"))
    # The clock is compared with the motion on means of the samples, which may begin or end a window otherwise.
    assert len(list(assert_same_log(path, {}, settings, clock_windows=0).blocks())) >= blocks


@pytest.mark.parametrize(("dialect", "rows"), [*((dialect, 333) for dialect in FORMS), ("mcap", 3001), ("csv", 3001)])
def test_blocks_are_the_whole(
    log: JointLog, tmp_path: Path, dialect: str, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    cut_into(rows, monkeypatch)
    shorter = log.take_window(2.0, 4.0) if dialect == "mcap-json" else log  # decoded one by one
    path = tmp_path / f"run{next(one.suffix for one in WRITERS if one.name == dialect)}"
    write_log(shorter, path, dialect=dialect)
    assert_in_blocks(path, blocks=2)


@pytest.mark.parametrize("order", ["C", "F"])
def test_an_archive_that_is_not_compressed(
    log: JointLog, tmp_path: Path, order: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    cut_into(1000, monkeypatch)
    arrays = {name: np.asarray(array, order=order) for name, array in log.channels().items()}
    np.savez(tmp_path / "run.npz", time=log.t, joint_names=np.array(log.joint_names), **arrays)  # type: ignore[arg-type]
    assert_in_blocks(tmp_path / "run.npz", blocks=5)
    np.testing.assert_array_equal(read_log(tmp_path / "run.npz").dq, log.dq)


@pytest.mark.parametrize("fault", ["word", "blank line", "cut"])
def test_a_text_table_with_a_fault_is_read_at_once(
    log: JointLog, tmp_path: Path, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    cut_into(1000, monkeypatch)
    path = tmp_path / "run.csv"
    write_log(log, path)
    lines = path.read_text().splitlines()
    line = lines[4000].split(",")
    faults = {"word": [*line[:3], "oops", *line[4:]], "blank line": []}
    lines[4000] = ",".join(faults.get(fault, line))
    lines[-1] = ",".join(lines[-1].split(",")[:5]) if fault == "cut" else lines[-1]
    path.write_text("\n".join(lines) + "\n")
    usual, found = read_log(path), read_log(path, InBlocks())
    assert not isinstance(found, LogInBlocks)
    assert found.source == usual.source
    np.testing.assert_array_equal(found.dq, usual.dq)


@pytest.mark.parametrize("name", ["run.csv", "run.npz"])
def test_a_file_that_changes_between_passes(
    log: JointLog, tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    cut_into(1000, monkeypatch)
    write_log(log, tmp_path / name)
    found = read_log(tmp_path / name, InBlocks())
    assert isinstance(found, LogInBlocks)
    (tmp_path / name).write_bytes((tmp_path / name).read_bytes()[:90_000])
    refused("changed while it was read", list, found.blocks())
    (tmp_path / name).unlink()
    refused("changed while it was read", list, found.blocks())


def test_a_table_of_libfranka_is_read_at_once(log: JointLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut_into(1000, monkeypatch)
    write_log(log, tmp_path / "run.csv", dialect="csv-libfranka")
    assert read_log(tmp_path / "run.csv", InBlocks()).source == read_log(tmp_path / "run.csv").source


def test_the_numbers_of_a_damaged_archive_are_refused(
    log: JointLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cut_into(1000, monkeypatch)
    path = tmp_path / "run.npz"
    np.savez(path, time=log.t, **log.channels())  # type: ignore[arg-type]
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    for options in (ReadOptions(), InBlocks()):
        refused("damaged NumPy archive", read_log, path, options)
