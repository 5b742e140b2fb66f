"""A compensator in every joint of an arm: the same in all, or one for each."""

from dataclasses import dataclass

from friction_audit.errors import UsageError
from friction_audit.replay.compensators import Compensator, guards


@dataclass(frozen=True, kw_only=True, slots=True)
class JointByJoint:
    """Compensators that differ from joint to joint.

    Attributes:
        compensators: One per joint.
    """

    compensators: tuple[Compensator, ...]


AnyCompensator = Compensator | JointByJoint
"""What runs in an arm; None where nothing does."""


def of_each_joint(compensator: AnyCompensator | None, joints: int) -> tuple[Compensator | None, ...]:
    """Return what runs in each joint.

    Raises:
        UsageError: If there are not as many as joints.
    """
    if not isinstance(compensator, JointByJoint):
        return (compensator,) * joints
    if len(compensator.compensators) != joints:
        raise UsageError(f"joint by joint: {len(compensator.compensators)} compensators: expected {joints}")
    return compensator.compensators


def any_guards(compensator: AnyCompensator | None) -> bool:
    """Return True if a passivity controller acts in some joint."""
    return any(map(guards, of_each_joint(compensator, _number(compensator))))


def _number(compensator: AnyCompensator | None) -> int:
    return len(compensator.compensators) if isinstance(compensator, JointByJoint) else 1
