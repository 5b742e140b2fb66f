from pathlib import Path

import pytest

from tests.in_this_process import Run
from tests.io.synthetic_recordings import tidy_frame


def test_one_bad_file_does_not_sink_the_others(run: Run, logs: Path) -> None:
    answer = run("info", logs / "moved1.csv", logs / "empty.csv", logs / "moved2.csv", "--json")
    document = answer.document()
    assert answer.code == 6
    assert [Path(log["path"]).name for log in document["logs"]] == ["moved1.csv", "moved2.csv"]
    assert [Path(log["path"]).name for log in document["failed"]] == ["empty.csv"]
    assert answer.err == f"error: {document['failed'][0]['message']}\n"


def test_the_check_of_the_clock_and_the_unit_of_a_current_are_said(run: Run, tmp_path: Path) -> None:
    table = tidy_frame(3000).rename(columns={f"tau_J_{joint}": f"actual_current_{joint}" for joint in (1, 2, 3)})
    table.to_csv(tmp_path / "moved.csv", index=False)
    answer = run("info", "moved.csv")
    windows = run("info", "moved.csv", "--json").document()["logs"][0]["clock_windows"]
    assert windows > 0
    assert f"checked on {windows} windows" in answer.out
    assert "is read in A" in answer.out
    table[[f"{channel}_{joint}" for channel in ("q", "dq") for joint in (1, 2, 3)]] = 0.0
    table.to_csv(tmp_path / "rest.csv", index=False)
    assert run("info", "rest.csv", "--json").document()["logs"][0]["clock_windows"] == 0
    assert "not checked" in run("info", "rest.csv").out


def test_of_a_large_log_the_beginning_is_read(run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run("info", logs / "moved1.csv", "--json").document()["logs"][0]
    monkeypatch.setattr("friction_audit.cli.info.LARGE_BYTES", 0)
    monkeypatch.setattr("friction_audit.cli.info.FIRST_S", 10.0)
    first = run("info", logs / "moved1.csv", "--json").document()["logs"][0]
    assert 9.0 < first["duration_s"] < 10.0 < whole["duration_s"]
    assert first["sha256"] is None
    assert any(warning["code"] == "first_part" for warning in first["warnings"])
    assert first["rate_hz"] == whole["rate_hz"]
    answer = run("info", logs / "moved1.csv")
    assert f"the first 10 s, {first['samples']} samples; the file has {whole['samples']} rows; --full" in answer.out
    assert "first 10 s" not in answer.err
    assert run("info", logs / "moved1.csv", "--json", "--full").document()["logs"][0] == whole
    monkeypatch.setattr("friction_audit.cli.info.FIRST_S", 1000.0)
    assert "--full" not in run("info", logs / "moved1.csv").out


@pytest.mark.parametrize("suffix", ["parquet", "mcap", "bag", "npz"])
def test_the_beginning_of_every_format(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str) -> None:
    tidy_frame(3000).to_csv(tmp_path / "log.csv", index=False)
    assert run("convert", "log.csv", f"log.{suffix}").code == 0
    both = run("info", "log.csv", f"log.{suffix}").err
    assert "warning: log.csv: gravity is in the torque" in both
    assert f"remove it: `friction-audit info log.{suffix} --urdf FILE`" in both
    whole = run("info", f"log.{suffix}", "--json").document()["logs"][0]["duration_s"]
    monkeypatch.setattr("friction_audit.cli.info.LARGE_BYTES", 0)
    monkeypatch.setattr("friction_audit.cli.info.FIRST_S", whole / 2)
    part = run("info", f"log.{suffix}", "--json").document()["logs"][0]["duration_s"]
    assert part == pytest.approx(whole / 2, rel=0.01)
