"""Why joints have no result, in as few sentences as there are reasons."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from friction_audit.drift.session import JointSummary
    from friction_audit.friction.history import JointFriction
    from friction_audit.replay.result import JointReplay


def reason_lines(joints: "Iterable[JointFriction | JointReplay | JointSummary]") -> list[str]:
    """Return one line per reason, led by the joints that it holds for; none for joints with a result."""
    reasons: dict[str, list[int]] = {}
    for joint in joints:
        if joint.reason:
            reasons.setdefault(joint.reason, []).append(joint.joint)
    return [f"{_name_joints(numbers)}: {reason}" for reason, numbers in reasons.items()]


def _name_joints(numbers: list[int]) -> str:
    return f"joint{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"
