from pathlib import Path

import numpy as np

from friction_audit.ingest import read_log
from tests.cli.conftest import Run


def test_a_log_comes_back_to_the_bit(run: Run, logs: Path, tmp_path: Path) -> None:
    answer = run("convert", logs / "moved2.csv", "out.parquet", "--json")
    document = answer.document()
    before, after = read_log(logs / "moved2.csv"), read_log(tmp_path / "out.parquet")
    assert document["output"] == {"path": "out.parquet", "dialect": "parquet", "joints": 2, "samples": len(before.t)}
    assert np.array_equal(before.dq, after.dq)
    assert np.array_equal(before.t, after.t)


def test_joints_and_time_are_cut(run: Run, logs: Path, tmp_path: Path) -> None:
    answer = run("convert", logs / "moved2.csv", "part.csv", "--joints", "2", "--t-start", "2", "--t-end", "5")
    assert answer.out == "part.csv\n"
    part = read_log(tmp_path / "part.csv")
    assert part.dq.shape[1] == 1
    assert abs(part.duration_s - 3) < 0.01


def test_an_older_file_stays(run: Run, logs: Path, tmp_path: Path) -> None:
    (tmp_path / "out.csv").write_text("old")
    assert run("convert", logs / "moved1.csv", "out.csv").code == 2
    assert (tmp_path / "out.csv").read_text() == "old"
    assert run("convert", logs / "moved1.csv", "out.csv", "--overwrite").code == 0
