"""The published static friction of the Panda, a sigmoid of the velocity.

C. Gaz, M. Cognetti, A. Oliva, P. Robuffo Giordano, A. De Luca: Dynamic identification of the Franka Emika Panda robot
with retrieval of feasible parameters using penalty-based optimization, IEEE Robotics and Automation Letters 4(4), 2019.
The paper calls it LuGre; it has no state and no viscous term of its own: "Gaz sigmoidal (static)".
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from friction_audit.compensation.compensators.law import Guard, numbers_of, require_finite, require_positive
from friction_audit.compiled import compiled
from friction_audit.errors import UsageError


@dataclass(frozen=True, kw_only=True, slots=True)
class SigmoidCompensation:
    """u = phi1 / (1 + exp(-phi2 (dq + phi3))) - phi1 / (1 + exp(-phi2 phi3)).

    It is smooth through standstill, where its slope is at most phi1 phi2 / 4: noise of the velocity comes out times
    that slope, and is not amplified to the whole plateau as by a sign function.

    Raises:
        UsageError: If a number is out of range.
    """

    height_nm: float  # phi1, from plateau to plateau [N m]
    steepness_s_per_rad: float  # phi2 [s/rad]
    shift_rad_s: float = 0.0  # phi3, which makes the plateaus unequal [rad/s]
    guard: Guard = field(default_factory=Guard)  # passivity controller and limits

    def __post_init__(self) -> None:
        require_finite("sigmoid compensation", self, "height_nm", "steepness_s_per_rad", "shift_rad_s")
        require_positive("sigmoid compensation", self, "height_nm", "steepness_s_per_rad")

    @property
    def plateaus_nm(self) -> tuple[float, float]:
        """Friction at high speed in the positive and in the negative direction, both above zero. [N m]"""
        backward = self.height_nm / (1.0 + math.exp(-self.steepness_s_per_rad * self.shift_rad_s))
        return self.height_nm - backward, backward

    def scaled(self, factor: float) -> Self:
        """Return it with every torque times a factor."""
        return replace(self, height_nm=factor * self.height_nm)


GROUP = numbers_of(SigmoidCompensation)

# Of the seven joints, as published.
PUBLISHED = (
    SigmoidCompensation(height_nm=0.54615, steepness_s_per_rad=5.1181, shift_rad_s=0.039533),
    SigmoidCompensation(height_nm=0.87224, steepness_s_per_rad=9.0657, shift_rad_s=0.025882),
    SigmoidCompensation(height_nm=0.64068, steepness_s_per_rad=10.136, shift_rad_s=-0.04607),
    SigmoidCompensation(height_nm=1.2794, steepness_s_per_rad=5.590, shift_rad_s=0.036194),
    SigmoidCompensation(height_nm=0.83904, steepness_s_per_rad=8.3469, shift_rad_s=0.026226),
    SigmoidCompensation(height_nm=0.30301, steepness_s_per_rad=17.133, shift_rad_s=-0.021047),
    SigmoidCompensation(height_nm=0.56489, steepness_s_per_rad=10.336, shift_rad_s=0.0035526),
)

TYPICAL_STEEPNESS_S_PER_RAD = 9.0657  # median of the published ones


def fit_sigmoid(
    coulomb_nm: float,
    viscous_nms_per_rad: float,
    *,
    top_speed_rad_s: float = 1.0,
    offset_nm: float = 0.0,
    steepness_s_per_rad: float = TYPICAL_STEEPNESS_S_PER_RAD,
) -> SigmoidCompensation:
    """Return the sigmoid nearest to Coulomb and viscous friction over speeds up to a highest one, by least squares.

    The steepness is given and not fitted: Coulomb friction is a step, and the nearest sigmoid to a step is as steep as
    it may be, which at standstill turns noise of the velocity into torque.

    Args:
        coulomb_nm: Coulomb friction. [N m]
        viscous_nms_per_rad: Viscous friction. [N m s/rad]
        top_speed_rad_s: Highest speed that counts; all up to it count alike. [rad/s]
        offset_nm: By so much friction is larger in the positive direction than on average. [N m]
        steepness_s_per_rad: phi2. [s/rad]

    Raises:
        UsageError: If there is no friction to fit, or the offset is larger than it.
    """
    speed = np.linspace(0.0, top_speed_rad_s, 401)[1:]
    level = coulomb_nm + viscous_nms_per_rad * speed
    if not (top_speed_rad_s > 0 and coulomb_nm >= 0 and viscous_nms_per_rad >= 0 and level[-1] > 0):
        raise UsageError(
            f"sigmoid compensation: Coulomb {coulomb_nm:g}, viscous {viscous_nms_per_rad:g}, top speed "
            f"{top_speed_rad_s:g}: expected friction above zero and a speed above zero"
        )
    shape = np.tanh(steepness_s_per_rad * speed / 2)
    half = float(shape @ level / (shape @ shape))
    if not abs(offset_nm) < half:
        raise UsageError(f"sigmoid compensation: offset {offset_nm:g} N m: expected less than the friction {half:g}")
    shift = math.log((half - offset_nm) / (half + offset_nm)) / steepness_s_per_rad
    return SigmoidCompensation(height_nm=2 * half, steepness_s_per_rad=steepness_s_per_rad, shift_rad_s=shift)


@compiled()
def torque_nm(group: Any, dq: float) -> float:  # noqa: ANN401 - a record
    """Return the torque that aids the motion. [N m]"""
    at_rest = 1.0 / (1.0 + math.exp(-group.steepness_s_per_rad * group.shift_rad_s))
    moving = 1.0 / (1.0 + math.exp(-group.steepness_s_per_rad * (dq + group.shift_rad_s)))
    return float(group.height_nm * (moving - at_rest))
