"""Ctrl-C: the program stops at once and leaves nothing half-written."""

import signal
import subprocess
import sys
import time
from pathlib import Path

LOG = Path(__file__).parents[2] / "sample_logs" / "hand_guided.parquet"
LONGEST_S = 120.0
TRIES = 5
STOPPED = 130
"""Exit code of a program that was interrupted, as shells expect it."""


def names_in(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir()] if folder.exists() else []


def stop_while_writing(out: Path) -> tuple[int, str, str]:
    """Send Ctrl-C as soon as a draft is there; exit code and what was printed."""
    command = [sys.executable, "-m", "friction_audit", "report", str(LOG), "--joints", "1", "-o", str(out), "-q"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + LONGEST_S
    while not names_in(out):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)
    process.send_signal(signal.SIGINT)
    said, complained = process.communicate(timeout=LONGEST_S)
    return process.returncode, said, complained


def test_a_report_that_is_stopped_while_it_is_written_is_not_there(tmp_path: Path) -> None:
    """A busy machine may deliver the signal when all is done; then the page is whole, and it is tried again."""
    for number in range(TRIES):
        out = tmp_path / str(number)
        code, said, complained = stop_while_writing(out)
        assert "Traceback" not in complained
        if code == STOPPED:
            assert (names_in(out), said) == ([], "")
            return
        (page,) = out.iterdir()
        assert (code, page.read_text(encoding="utf-8").rstrip()[-7:]) == (0, "</html>")
    raise AssertionError(f"never stopped in {TRIES} tries")
