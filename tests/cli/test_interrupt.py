"""Ctrl-C: the program stops at once and leaves nothing half-written."""

import signal
import subprocess
import sys
import time
from pathlib import Path

LOG = Path(__file__).parents[2] / "sample_logs" / "hand_guided.parquet"
LONGEST_S = 120.0
STOPPED = 130
"""Exit code of a program that was interrupted, as shells expect it."""


def names_in(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir()] if folder.exists() else []


def test_a_report_that_is_stopped_while_it_is_written_is_not_there(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-m", "friction_audit", "report", str(LOG), "--joints", "1", "-o", str(out), "-q"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + LONGEST_S
    while not names_in(out):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)
    drafts = names_in(out)
    process.send_signal(signal.SIGINT)
    said, complained = process.communicate(timeout=LONGEST_S)
    assert all(name.startswith(".") for name in drafts)  # it was being written, not done
    assert process.returncode == STOPPED
    assert names_in(out) == []
    assert said == ""
    assert "Traceback" not in complained
