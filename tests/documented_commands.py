"""Commands in the documentation: found, run in a folder beside the sample logs, their outputs held against the pages.

A block fenced as ``console`` shows commands after ``$`` and what they print; one fenced as ``sh`` shows commands only.
``python -m tests.documented_commands`` writes the real outputs into the pages.
"""

import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from unittest.mock import patch

from tests.in_this_process import Answer, diagnosed_once, in_this_process, run

ROOT = Path(__file__).parents[1]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")))
WIDTH = 100

STAND_INS = {
    ".parquet": "sample_logs/hand_guided.parquet",
    ".csv": "sample_logs/formats/csv-libfranka.csv",
    ".bag": "sample_logs/formats/rosbag1-franka-state.bag",
    ".db3": "sample_logs/formats/rosbag2-db3.db3",
    ".mcap": "sample_logs/formats/mcap-franka-robot-state.mcap",
    ".npz": "sample_logs/formats/npz.npz",
    ".urdf": "src/friction_audit/robot/panda.urdf",
}
"""Ending of a file that a page only imagines (run.bag) -> the file that stands in for it."""

RECORDED = """friction-audit() { printf '%s\\0' "$@" '' >> "$WORDS"; }
"""
"""The program as a shell's function that notes its words: a loop would start it anew every time."""

_BLOCK = re.compile(r"^```(?P<language>console|sh|python|json)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
_DECIMAL = re.compile(r"\d+\.\d+(?:e-?\d+)?")


@dataclass
class Example:
    """A command and what a page says that it prints."""

    command: str
    output: str = ""


@dataclass
class Terminal:
    """A folder with the sample logs in which commands are run one after another."""

    folder: Path
    code: int = 0
    imagined: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        (self.folder / "sample_logs").symlink_to(ROOT / "sample_logs", target_is_directory=True)

    def run(self, command: str) -> str:
        """Run one line and return what a terminal would show."""
        if command == "echo $?":
            return f"{self.code}\n"
        first, _, rest = command.partition(" | ")
        words = shlex.split(first)
        if words[0] != "friction-audit":
            return self._shell(command, "")
        answer = self._call(words[1:], apart=bool(rest))
        self.code = answer.code
        return answer.err + self._shell(rest, answer.out) if rest else answer.out

    def provide_logs(self, command: str) -> bool:
        """Put sample logs where a command expects logs that the page only imagines; True if there are such."""
        words = shlex.split(command, comments=True)
        logs = words[2:3] if words[1:2] != ["info"] else words[2:]
        robots = [value for name, value in pairwise(words) if name in ("--urdf", "--into")]
        for word in [*logs, *robots]:
            path = self.folder / word
            if path.suffix in STAND_INS and not path.exists():
                path.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(ROOT / STAND_INS[path.suffix], path)
                self.imagined.add(word)
            if word in self.imagined and "--map" in words:
                path.write_text(_renamed(words), encoding="utf-8")
        return not self.imagined.isdisjoint(words)

    def _call(self, words: list[str], *, apart: bool) -> Answer:
        """Run the program in the folder."""
        columns = patch.dict(os.environ, COLUMNS=str(WIDTH))
        with contextlib.chdir(self.folder), columns, in_this_process(), diagnosed_once():
            return run(*words, apart=apart)

    def _shell(self, command: str, text: str) -> str:
        """Run anything else in a shell; a loop over commands whose output nobody reads is run by this process."""
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        noted = self.folder / ".words"
        script = command if "|" in command else RECORDED + command
        done = subprocess.run(
            ["bash", "-o", "pipefail", "-c", script],
            cwd=self.folder,
            env={**os.environ, "PATH": path, "LC_ALL": "C.UTF-8", "WORDS": str(noted), "COLUMNS": str(WIDTH)},
            input=text,
            capture_output=True,
            text=True,
            check=False,
        )
        self.code = done.returncode
        for words in noted.read_text().split("\0\0")[:-1] if noted.exists() else ():
            answer = self._call(words.split("\0"), apart=False)
            self.code = answer.code
            assert "/dev/null" in command or not answer.out, answer.out
        noted.unlink(missing_ok=True)
        return done.stdout + done.stderr


def _renamed(words: list[str]) -> str:
    """Return a table whose columns are called as ``--map`` says."""
    header, _, rows = (ROOT / "sample_logs" / "formats" / "csv.csv").read_text(encoding="utf-8").partition("\n")
    names = header.split(",")
    mapping = dict(word.split("=", 1) for option, word in pairwise(words) if option == "--map")
    for place, name in enumerate(names):
        channel, _, joint = name.rpartition("_")
        names[place] = mapping.get(channel, channel + "_{i}").replace("{i}", joint) if channel else name
    return f"{','.join(names)}\n{rows}"


def blocks(text: str, language: str) -> list[str]:
    return [match["body"] for match in _BLOCK.finditer(text) if match["language"] == language]


def examples(body: str) -> list[Example]:
    """Return the commands of a console block with their outputs."""
    found: list[Example] = []
    for line in body.splitlines(keepends=True):
        if line.startswith("$ "):
            found.append(Example(line[2:].rstrip("\n")))
        else:
            found[-1].output += line
    return found


def commands(body: str) -> list[str]:
    """Return the lines of a ``sh`` block that call the program, continued lines joined."""
    lines = body.replace("\\\n", " ").splitlines()
    return [line for line in lines if line.startswith("friction-audit ")]


def same(shown: str, real: str) -> bool:
    """Return True if two outputs agree; decimals may differ by 2 % or 0.01, and columns be as wide as they need."""
    numbers = [[float(number) for number in _DECIMAL.findall(text)] for text in (shown, real)]
    if _without_numbers(shown) != _without_numbers(real) or len(numbers[0]) != len(numbers[1]):
        return False
    return all(abs(a - b) <= max(0.01, 0.02 * abs(b)) for a, b in zip(*numbers, strict=True))


def _without_numbers(text: str) -> str:
    return re.sub(r"[ \t]+", " ", re.sub(r"─+", "─", _DECIMAL.sub("#", text))).strip()


def refresh(page: Path) -> None:
    """Write the real outputs of a page's console blocks into it."""
    with tempfile.TemporaryDirectory() as folder:
        terminal = Terminal(Path(folder))

        def renew(match: re.Match[str]) -> str:
            if match["language"] != "console":
                return match[0]
            shown = (f"$ {e.command}\n{_trimmed(terminal.run(e.command))}" for e in examples(match["body"]))
            return f"```console\n{''.join(shown)}```"

        text = page.read_text(encoding="utf-8")
        renewed = _BLOCK.sub(renew, text)
    if renewed != text:
        page.write_text(renewed, encoding="utf-8")


def _trimmed(output: str) -> str:
    return "".join(f"{line.rstrip()}\n" for line in output.splitlines())


if __name__ == "__main__":
    for each in PAGES:
        refresh(each)
