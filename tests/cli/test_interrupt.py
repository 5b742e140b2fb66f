"""Ctrl-C, SIGTERM and SIGHUP: the program stops at once, in words, and leaves nothing half-written."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
AS_A_COMMAND = """
import os, runpy, signal, sys
number = signal.Signals(int(sys.argv.pop(1)))
signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it
"""
AT_THE_DRAFT = """
from friction_audit.io import files
replace = files._replace

def stopped(draft, *places):
    print("draft of", draft.stat().st_size, "bytes", file=sys.stderr)
    os.kill(os.getpid(), number)
    replace(draft, *places)

files._replace = stopped
"""
"""The program gets a signal when a file is written and not yet in its place."""
WHILE_IMPORTING = """
class Stopping:
    def find_spec(self, name, *_):
        if name == "typer":
            os.kill(os.getpid(), number)

sys.meta_path.insert(0, Stopping())
"""
RUN = "runpy.run_module('friction_audit', run_name='__main__')"


def run(number: signal.Signals, moment: str, *words: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-c", AS_A_COMMAND + moment + RUN, str(int(number)), *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_file_stopped_before_it_is_in_place_is_not_there(number: signal.Signals, logs: Path, tmp_path: Path) -> None:
    done = run(number, AT_THE_DRAFT, "convert", str(logs / "moved1.csv"), str(tmp_path / "out.csv"), "-q")
    assert done.stderr.startswith("draft of ")
    assert "Traceback" not in done.stderr
    assert (done.returncode, done.stdout) == (128 + number, "")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_while_the_program_is_loaded_is_one_line(number: signal.Signals) -> None:
    done = run(number, WHILE_IMPORTING, "--version")
    assert (done.returncode, done.stdout) == (128 + number, "")
    assert done.stderr.startswith("stopped")
    assert done.stderr.count("\n") == 1
