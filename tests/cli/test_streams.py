"""Standard streams that are full, closed or have lost their reader."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

CASES = [
    ("--version", "> /dev/full", 2, "error: .*No space left"),
    ("info x --dump-config", "> /dev/full", 2, "error: standard output: .*No space left"),
    ("info {log}", "<&- 2>&-", 0, ""),
    ("--version", ">&-", 0, ""),
    ("info {log}", "2> /dev/full", 0, ""),
    ("info --joints x absent.csv", "2>&-", 2, ""),
    ("info --joints x absent.csv", "2> /dev/full", 2, ""),
]


@pytest.mark.parametrize(("words", "streams", "code", "text"), CASES, ids=[f"{row[0]} {row[1]}" for row in CASES])
def test_table(words: str, streams: str, code: int, text: str, logs: Path) -> None:
    command = f"{sys.executable} -m friction_audit {words.format(log=logs / 'moved1.csv')} {streams}"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == code, done
    assert re.fullmatch(f"{text}.*\n" if text else "", done.stderr)
    assert ("1 joint" in done.stdout) == (words == "info {log}")


@pytest.mark.parametrize("words", ["info {log} -q", "info x --dump-config"])
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
