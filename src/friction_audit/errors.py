"""The errors that friction-audit raises on purpose; anything else is a bug.

A message says: where, what was found, what was expected, what to do.
"""

import re
from collections.abc import Collection, Sequence
from difflib import get_close_matches
from traceback import format_exception
from types import NoneType
from typing import Any


class FrictionAuditError(Exception):
    """Base of every deliberate error; ``exit_code`` is what the command line exits with."""

    exit_code = 1


class UsageError(FrictionAuditError):
    """The request contradicts itself or the log; another option is needed."""

    exit_code = 2


class InputError(FrictionAuditError):
    """The input cannot be read as a joint log."""

    exit_code = 3


class AnalysisError(FrictionAuditError):
    """The log is readable, but the question has no answer: no cycle, no excitation.

    Its argument is a message or, of one joint, a ``Reason``.
    """

    exit_code = 4

    def __init__(self, why: object, of_joints: Sequence[tuple[int, Any]] = ()) -> None:
        """Take also the reasons of several joints by their numbers."""
        super().__init__(why)
        self.of_joints = of_joints


def bug(what: str, error: Exception) -> tuple[str, str]:
    """Say that a part of the work ended in an error that was not foreseen; return its traceback too."""
    sentence = f"{what} failed with {type(error).__name__}: {error}; this is a bug, please report it"
    return sentence, "".join(format_exception(error))


CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
"""Control characters but newline and tab, which a terminal obeys, and marks that turn the direction of writing."""


def printable(text: str) -> str:
    """Return text with control characters marked, and bytes of a file's name that are no letters spelt out."""
    return CONTROL.sub("\N{REPLACEMENT CHARACTER}", encodable(text))


def encodable(text: str) -> str:
    """Return text that any file can hold: bytes of a name that are no letters are spelt out."""
    return text.encode("utf-8", "backslashreplace").decode()


def shortened(text: str, most: int) -> str:
    """Return text in one line of at most so many characters."""
    line = " ".join(text[: 4 * most].split())
    return line if len(line) <= most and len(text) <= 4 * most else f"{line[: most - 3]}..."


def near_misses(word: str, names: Collection[str]) -> str:
    """Return ``"; did you mean ...?"`` for a misspelt name, or nothing."""
    near = get_close_matches(word, names, n=2)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def few(items: Sequence[str], most: int = 5, kind: str = "") -> list[str]:
    """Return the first of many items for a message, and how many more there are of their kind."""
    return [*items[:most], *([f"and {len(items) - most} more{kind}"] if len(items) > most else [])]


def kind_name(kind: type) -> str:
    """Return the name of a class as the command line has it, e.g. ``slow_sweep``; of None, ``none``."""
    return "none" if kind is NoneType else re.sub(r"(?<=[a-z])(?=[A-Z])", "_", kind.__name__).lower()
