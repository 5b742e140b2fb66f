"""The friction that a model of the joint predicts, applied as a feed-forward."""

from dataclasses import dataclass, field
from typing import Any

from friction_audit.compensation.compensators.law import (
    Guard,
    numbers_of,
    require_finite,
    require_not_negative,
    soft_sign,
)
from friction_audit.compiled import compiled
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.errors import UsageError


@dataclass(frozen=True, kw_only=True, slots=True)
class JointModelCompensation:
    """A compensator that applies the terms of friction of a joint's model instead of the log's friction.

    It runs in a replay, which gives it at every tick what they take. As with the compensator of the paper, dry friction
    is silent up to ``dead_band_rad_s`` and rises over the next ``ramp_rad_s``; bristles, which have no sign function,
    are applied at any speed.

    Raises:
        UsageError: If there is no term, or a number is out of range.
    """

    terms: tuple[FittedTerm, ...]  # the terms of friction
    dead_band_rad_s: float = 0.01  # speed up to which dry friction is silent [rad/s]
    ramp_rad_s: float = 0.03  # range of speed over which it then rises to all of it [rad/s]
    guard: Guard = field(default_factory=Guard)  # passivity controller and limits

    def __post_init__(self) -> None:
        if not self.terms:
            raise UsageError("compensation by a joint's model: no term of friction; expected one at least")
        require_finite("compensation by a joint's model", self, *(GROUP.names or ()))
        require_not_negative("compensation by a joint's model", self, *(GROUP.names or ()))


GROUP = numbers_of(JointModelCompensation)


@compiled()
def torque_nm(group: Any, memory: Any, dq: float) -> float:  # noqa: ANN401 - records
    """Return the torque that aids the motion. [N m]"""
    return float(soft_sign(dq, group.dead_band_rad_s, group.ramp_rad_s) * memory.modelled_nm + memory.bristle_nm)
