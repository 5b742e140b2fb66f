"""Ctrl-C: the program stops at once and leaves nothing half-written."""

import subprocess
import sys
from pathlib import Path

STOPPED = 130
"""Exit code of a program that was interrupted, as shells expect it."""
STOPPED_AT_THE_DRAFT = """
import os, signal, sys
from friction_audit import whole_file
from friction_audit.cli import main
from friction_audit.errors import AnalysisError
from friction_audit.report import log_report

def no_answer(*_):
    raise AnalysisError("no candidate")

log_report.diagnose_estimate = no_answer
signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts behind itself ignores it
replace = whole_file._replace

def stopped(draft, path):
    print("draft of", draft.stat().st_size, "bytes", file=sys.stderr)
    os.kill(os.getpid(), signal.SIGINT)
    replace(draft, path)

whole_file._replace = stopped
main(sys.argv[1:])
"""
"""The program, which gets Ctrl-C when a page is written and not yet in its place; a diagnosis would take longest."""


def test_a_report_that_is_stopped_while_it_is_written_is_not_there(logs: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["report", str(logs / "moved1.csv"), "-o", str(out), "--format", "markdown", "-q"]
    done = subprocess.run(
        [sys.executable, "-c", STOPPED_AT_THE_DRAFT, *command], capture_output=True, text=True, check=False
    )
    assert done.stderr.startswith("draft of ")
    assert "Traceback" not in done.stderr
    assert (done.returncode, done.stdout) == (STOPPED, "")
    assert not out.exists() or list(out.iterdir()) == []
