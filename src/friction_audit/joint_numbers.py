"""Numbers of joints as people write them: 1,3-5. Without numpy, for the command line."""

from collections.abc import Iterable

from friction_audit.errors import UsageError, shortened

HIGHEST = 99_999  # no arm has so many joints, and no ledger so many sessions of one


def parse_joint_numbers(text: str, where: str) -> tuple[int, ...]:
    """Return the joints of ``"1,3-5"``, in order and each once; a message begins with ``where``."""
    joints: set[int] = set()
    where = shortened(where, 200)
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not _is_number(first) or (dash and not _is_number(last)):
            raise UsageError(f"{where}: {shortened(part.strip(), 40)!r} is no joint; expected e.g. 1,3-5")
        if dash and int(last) < int(first):
            raise UsageError(f"{where}: {part.strip()!r} runs backwards; expected e.g. 1,3-5")
        joints.update(range(int(first), int(last if dash else first) + 1))
    return tuple(sorted(joints))


def _is_number(text: str) -> bool:
    return text.isdecimal() and len(text) <= len(str(HIGHEST)) and int(text) > 0


def write_joint_numbers(joints: Iterable[int]) -> str:
    """Return joints in order as ``"1,3-5"``, the text that ``parse_joint_numbers`` reads."""
    runs: list[list[int]] = []
    for joint in joints:
        if runs and joint == runs[-1][-1] + 1:
            runs[-1].append(joint)
        else:
            runs.append([joint])
    return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def split_joints(text: str, where: str) -> tuple[str, tuple[int, ...] | None]:
    """Return the text before ``@`` and the joints after it, or None for all where there is no ``@``."""
    head, at, joints = text.partition("@")
    return head, parse_joint_numbers(joints, where) if at else None


def require_joints(joints: Iterable[int], count: int, where: str) -> None:
    """Refuse joints that are not there, those above ``count``."""
    absent = [joint for joint in joints if joint > count]
    if absent:
        there = "there is only joint 1" if count == 1 else f"expected joints from 1 to {count}"
        raise UsageError(f"{where}: no joint {write_joint_numbers(absent)}; {there}")
