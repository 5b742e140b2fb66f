import resource
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from friction_audit.io.readers import read_log
from friction_audit.io.writers.write_log import WRITERS
from tests.in_this_process import Run
from tests.test_whole_file import state

LOG = Path(__file__).parents[2] / "sample_logs" / "formats" / "csv.csv"
"""A log with all that any dialect needs."""


@pytest.mark.parametrize(("out", "lost"), [("out.csv", True), ("out.parquet", False)])
def test_the_name_of_the_arm_is_not_lost_in_silence(run: Run, logs: Path, out: str, *, lost: bool) -> None:
    """Without it the same log has another model of gravity."""
    answer = run("convert", logs / "moved2.csv", out, "--robot", "panda")
    assert ("the name of the arm (read it with --robot panda)" in answer.err) is lost


@pytest.mark.parametrize("dialect", [writer.name for writer in WRITERS])
def test_every_dialect_keeps_the_arm_that_joint_names_say_or_says_so(run: Run, tmp_path: Path, dialect: str) -> None:
    out = "out" + next(writer.suffix for writer in WRITERS if writer.name == dialect)
    answer = run("convert", LOG.with_name("parquet.parquet"), out, "--dialect", dialect)
    is_kept = read_log(tmp_path / out).source.robot == "panda"
    assert (answer.code, "the name of the arm" in answer.err) == (0, not is_kept)


def test_joints_and_time_are_cut(run: Run, logs: Path, tmp_path: Path) -> None:
    asked = ("--joints", "2", "--t-start", "2", "--t-end", "5")
    output = run("convert", logs / "moved2.csv", "part.parquet", *asked, "--json").document()["output"]
    assert output == {"path": "part.parquet", "dialect": "parquet", "joints": 1, "samples": output["samples"]}
    assert run("convert", logs / "moved2.csv", "part.csv", *asked).out == "part.csv\n"
    part = read_log(tmp_path / "part.csv")
    assert part.dq.shape[1] == 1
    assert abs(part.duration_s - 3) < 0.01


def test_a_folder_is_never_lost_to_a_bag_or_a_file(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "mydata"
    folder.mkdir()
    (folder / "chapter1.txt").write_text("precious")
    shutil.copy(LOG, folder / "raw.csv")
    (tmp_path / "out.csv").mkdir()
    assert run("convert", LOG, tmp_path / "bag", "--dialect", "rosbag2-mcap").code == 0
    before = state(tmp_path)
    for words, message in (
        ((LOG, "mydata", "--dialect", "rosbag2-sqlite3"), "only a ROS 2 bag"),
        (("mydata/raw.csv", "mydata", "--dialect", "rosbag2-mcap"), "holds the log"),
        (("mydata/raw.csv", ".", "--dialect", "rosbag2-mcap"), "holds the log"),
        ((LOG, "out.csv"), "is a folder"),
        ((LOG, "mydata/raw.csv", "--dialect", "rosbag2-mcap"), "a bag is a folder"),
        (("bag", "bag", "--dialect", "rosbag2-mcap"), "is the log itself"),
        (("bag", "bag/bag.mcap"), "is a part of the log"),
        (("bag/bag.mcap", "bag", "--dialect", "rosbag2-mcap"), "holds the log"),
    ):
        answer = run("convert", *words, "--overwrite")
        assert answer.code == 2, answer
        assert message in answer.err
    assert state(tmp_path) == before
    assert run("convert", LOG, "bag", "--dialect", "rosbag2-mcap", "--overwrite").code == 0
    assert state(tmp_path).keys() == before.keys()


@pytest.fixture
def small_disk() -> Iterator[None]:
    """Limit the size of files, in the place of a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.usefixtures("small_disk")
@pytest.mark.parametrize("dialect", ["csv", "mcap", "npz", "parquet", "rosbag1-joint-state", "rosbag2-db3"])
def test_a_disk_that_is_full_is_said_and_nothing_is_left(dialect: str, run: Run, tmp_path: Path) -> None:
    out = f"out{next(writer.suffix for writer in WRITERS if writer.name == dialect)}"
    answer = run("convert", LOG, out, "--dialect", dialect, "-q")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"error: {out}: cannot be written: ")
    assert list(tmp_path.iterdir()) == []
