"""Standard streams that are full, closed or have lost their reader; signals, which leave nothing half-written."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.each_case import thorough

CASES = [
    ("--version", "> /dev/full", 2, "error: .*No space left"),
    ("info {log} -q", "> /dev/full", 2, "error: standard output: .*No space left"),
    ("info {log}", "<&- 2>&-", 0, ""),
    ("--version", ">&-", 0, ""),
    ("info --joints x absent.csv", "2>&-", 2, ""),
]


@pytest.mark.parametrize(("words", "streams", "code", "text"), CASES, ids=[f"{row[0]} {row[1]}" for row in CASES])
def test_table(words: str, streams: str, code: int, text: str, logs: Path) -> None:
    command = f"{sys.executable} -m friction_audit {words.format(log=logs / 'moved1.csv')} {streams}"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == code, done
    assert re.fullmatch(f"{text}.*\n" if text else "", done.stderr)
    assert ("1 joint" in done.stdout) == (words == "info {log}")


@pytest.mark.parametrize("words", ["info {log} -q", "info --help-all"])
def test_a_reader_that_went_away(words: str, logs: Path) -> None:
    command = [sys.executable, "-m", "friction_audit", *words.format(log=logs / "moved1.csv").split()]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stderr is not None
        program.stdout.close()
        assert program.stderr.read() == ""
        assert program.wait() == 141


def test_warnings_of_libraries_are_not_printed(logs: Path) -> None:
    script = """
import sys, warnings
from friction_audit.__main__ import main
from friction_audit.cli import chain
read = chain.read

def warn(*words):
    warnings.warn("Glyph 20851 missing", UserWarning)
    warnings.warn("overflow encountered", RuntimeWarning)
    return read(*words)

chain.read = warn
main()
"""
    command = [sys.executable, "-c", script, "info", str(logs / "moved1.csv"), "-q"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
AS_A_COMMAND = """
import os, runpy, signal, sys
number = signal.Signals(int(sys.argv.pop(1)))
signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # and what nohup starts this one
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


def run(number: signal.Signals, when: str, *words: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-c", AS_A_COMMAND + when + RUN, str(int(number)), *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("number", [signal.SIGTERM, *thorough([signal.SIGINT, signal.SIGHUP])])
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
