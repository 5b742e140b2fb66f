"""The hand at the flange of an arm."""

from dataclasses import dataclass, field
from math import inf

from friction_audit.simulation.motion import HandPath, MotionSettings, StopAndGo
from friction_audit.simulation.settings import require_positive, require_within


@dataclass(frozen=True, kw_only=True, slots=True)
class Hand:
    """A mass that holds the flange, drawn by springs and dampers along an intended path; the person bears its weight.

    The defaults are those of a person who guides with braced arms: stiff, and damped well enough that the hand comes to
    rest in its pauses instead of swinging back (a Panda in its ready pose weighs 4 to 8 kg at its flange).

    Attributes:
        mass_kg: Mass of the hand. [kg]
        stiffness_n_per_m: Spring between intended and actual place. [N/m]
        damping_ns_per_m: Damper between them. [N s/m]
        turning_stiffness_nm_per_rad: Spring between intended and actual orientation. [N m/rad]
        turning_damping_nms_per_rad: Damper between them. [N m s/rad]
        path: The intended path.
    """

    mass_kg: float = 1.0
    stiffness_n_per_m: float = 1500.0
    damping_ns_per_m: float = 250.0
    turning_stiffness_nm_per_rad: float = 25.0
    turning_damping_nms_per_rad: float = 5.0
    path: HandPath = field(default_factory=HandPath)

    def __post_init__(self) -> None:
        """Check the signs; without springs and dampers the arm swings freely."""
        springs = ("stiffness_n_per_m", "turning_stiffness_nm_per_rad")
        dampers = ("damping_ns_per_m", "turning_damping_nms_per_rad")
        require_within("hand", 0, inf, **{name: getattr(self, name) for name in ("mass_kg", *springs, *dampers)})


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
