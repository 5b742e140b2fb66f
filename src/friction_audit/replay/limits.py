"""What the joints of an arm can do."""

from dataclasses import dataclass
from math import inf

from friction_audit.errors import UsageError

PANDA_TORQUE_NM = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
"""Largest torque of each joint of a Panda and of an FR3 (manufacturer's data). [N m]"""

PANDA_TORQUE_RATE_NM_S = 1000.0
"""Fastest change of a commanded torque that their controller accepts. [N m/s]"""

PANDAS = ("panda", "fr3")
"""Robots with these limits, as ``Source.robot`` names them."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Limits of what a compensator may command on one joint.

    Attributes:
        torque_nm: Largest torque; infinite without a limit. [N m]
        rate_nm_s: Fastest change of it. [N m/s]

    Raises:
        UsageError: If a limit is not above zero.
    """

    torque_nm: float = inf
    rate_nm_s: float = inf

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name, value in (("torque", self.torque_nm), ("torque rate", self.rate_nm_s)):
            if not value > 0:
                raise UsageError(f"replay: limit of the {name} {value:g}: expected a number above zero")


def limits_of(robot: str, joint: int) -> Limits:
    """Return the limits of a joint, given by its number for people; none for an unknown arm."""
    if robot not in PANDAS or not 1 <= joint <= len(PANDA_TORQUE_NM):
        return Limits()
    return Limits(torque_nm=PANDA_TORQUE_NM[joint - 1], rate_nm_s=PANDA_TORQUE_RATE_NM_S)
