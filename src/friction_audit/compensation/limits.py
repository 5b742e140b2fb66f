"""What may be assumed of the person who would have met another joint than the recorded one."""

from dataclasses import dataclass, replace
from math import inf

from friction_audit.errors import UsageError

FITTED, MODELLED = "the joint fitted to this log", "the joint of the model file"


@dataclass(frozen=True, kw_only=True, slots=True)
class Counterfactual:
    """One assumption.

    Attributes:
        name: As on the command line.
        title: In a few words, for figures and tables.
        assumes: One sentence for every output.
    """

    name: str
    title: str
    assumes: str


SAME_MOTION = Counterfactual(
    name="same-motion",
    title="same motion",
    assumes="assumes that the joint would have moved exactly as recorded and the person had pushed as much less (or "
    "more) as the compensator gives; nothing feeds back on the motion, so it cannot show instability",
)
SAME_TORQUE = Counterfactual(
    name="same-torque",
    title="same torque",
    assumes="assumes that the person would have pushed exactly as recorded, whatever the joint does; "
    f"{FITTED} moves under that torque, cycle by cycle from the recorded start",
)
SAME_OPERATOR = Counterfactual(
    name="same-operator",
    title="same operator",
    assumes="assumes that the person is a linear impedance with the same intention as in the recording; "
    f"{FITTED} and that impedance move together in closed loop",
)
COUNTERFACTUALS = (SAME_MOTION, SAME_TORQUE, SAME_OPERATOR)
"""In the order of the command line; the first is the default."""

ASSUMPTIONS = tuple(one.name for one in COUNTERFACTUALS)


def of_a_model(one: Counterfactual) -> Counterfactual:
    """Return the assumption in which the joint of a model file moves."""
    return replace(one, assumes=one.assumes.replace(FITTED, MODELLED))


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
