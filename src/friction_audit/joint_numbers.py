"""Numbers of joints as people write them: 1,3-5. Without numpy, for the command line."""

import re
from collections.abc import Iterable
from itertools import groupby

from friction_audit.errors import UsageError, shortened

# Five digits: no arm has so many joints, and no ledger so many sessions of one.
_RANGE = re.compile(r"(\d{1,5})(?:-(\d{1,5}))?")


def parse_joint_numbers(text: str, where: str) -> tuple[int, ...]:
    """Return the joints of ``"1,3-5"``, in order and each once; a message begins with ``where``."""
    joints: set[int] = set()
    where = shortened(where, 200)
    for part in text.split(","):
        match = _RANGE.fullmatch(part.strip())
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
        if not (first and last):
            raise UsageError(f"{where}: {shortened(part.strip(), 40)!r} is no joint; expected e.g. 1,3-5")
        if last < first:
            raise UsageError(f"{where}: {part.strip()!r} runs backwards; expected e.g. 1,3-5")
        joints.update(range(first, last + 1))
    return tuple(sorted(joints))


def write_joint_numbers(joints: Iterable[int]) -> str:
    """Return joints in order as ``"1,3-5"``, the text that ``parse_joint_numbers`` reads."""
    rows = groupby(enumerate(joints), key=lambda one: one[1] - one[0])  # of numbers that follow each other
    runs = ([joint for _, joint in row] for _, row in rows)
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def require_joints(joints: Iterable[int], count: int, where: str) -> None:
    """Refuse joints that are not there, those above ``count``."""
    absent = [joint for joint in joints if joint > count]
    if absent:
        there = "there is only joint 1" if count == 1 else f"expected joints from 1 to {count}"
        raise UsageError(f"{where}: no joint {write_joint_numbers(absent)}; {there}")
