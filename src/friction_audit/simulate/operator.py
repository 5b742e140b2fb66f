"""Who moves the joint: a person's arm, or the motor and its controller."""

from dataclasses import dataclass, field

from friction_audit.simulate.checks import require_positive
from friction_audit.simulate.motion import MotionSettings, StopAndGo


@dataclass(frozen=True, kw_only=True, slots=True)
class Operator:
    """A mass that holds the outer side of the joint rigidly, drawn by a spring and a damper along an intended motion.

    Where a hand moves the joint, the mass is that of hand and link; where the robot moves by itself, it is the motor's
    and the spring and the damper are its position controller.

    Attributes:
        inertia_kg_m2: Inertia on the outer side of the torque sensor. [kg m^2]
        stiffness_nm_per_rad: Spring between intended and actual motion. [N m/rad]
        damping_nms_per_rad: Damper between intended and actual motion. [N m s/rad]
        motion: The intended motion.
    """

    inertia_kg_m2: float = 0.3
    stiffness_nm_per_rad: float = 60.0
    damping_nms_per_rad: float = 9.0
    motion: MotionSettings = field(default_factory=StopAndGo)

    def __post_init__(self) -> None:
        """Check the signs."""
        names = ("inertia_kg_m2", "stiffness_nm_per_rad", "damping_nms_per_rad")
        require_positive("operator", **{name: getattr(self, name) for name in names})
