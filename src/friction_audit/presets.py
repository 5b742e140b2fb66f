"""Arms that are known by name: joints, limits, and what their torque signal is; one entry per arm.

Figures are those of the sources only; what has no source is left out. Angles in degrees where the source has degrees.
"""

import re
from collections.abc import Sequence
from math import inf, pi, radians, tau
from typing import NamedTuple

BUILT_IN = "panda"  # the arm whose rigid-body model comes with this package
FRANKA = ("panda", "fr3")  # arms with one ready pose, published static friction, and torque loops in their joints
FINGER = re.compile("finger|gripper", re.IGNORECASE)  # in the name of what is no part of the arm
UR_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
SENSOR, CURRENT, ESTIMATE = "sensor", "current", "estimate"
TORQUES = {
    SENSOR: "joint torque sensors",
    CURRENT: "motor current, or made from it",
    ESTIMATE: "estimated from the motor current",
}


class Preset(NamedTuple):
    """An arm of a make."""

    label: str  # make and model
    pattern: str  # regular expression of what precedes the joints in their names and says this arm
    joints: tuple[str, ...]  # names of the joints, base to tip
    low_rad: tuple[float, ...]  # ends of the range of each joint, infinite where it turns without end [rad]
    high_rad: tuple[float, ...]
    speed_rad_s: tuple[float, ...]  # highest speed of each [rad/s]
    torque_nm: tuple[float, ...]  # highest torque of each [N m]
    torque: str  # what its torque signal is, a key of TORQUES
    source: str  # where the figures were published
    shared: str = ""  # regular expression of joint names that this arm has in common with other models of the make
    # highest acceleration of each; empty where it is not published [rad/s^2]
    acceleration_rad_s2: tuple[float, ...] = ()
    torque_rate_nm_s: float = inf  # fastest change of a commanded torque [N m/s]


def _seven(prefix: str) -> tuple[str, ...]:
    return tuple(f"{prefix}{number}" for number in range(1, 8))


def _universal_robots(name: str, speeds: Sequence[float], torques: Sequence[float]) -> Preset:
    """Return an e-Series or later arm: shoulder, elbow and wrist have figures of their own."""
    return Preset(
        label=f"Universal Robots {name.upper().replace('E', 'e')}", pattern=name, torque=CURRENT,
        joints=tuple(f"{one}_joint" for one in UR_JOINTS), shared=r"(?:shoulder_(?:pan|lift)|elbow|wrist_[123])_joint",
        low_rad=(-tau, -tau, -pi, -tau, -tau, -tau), high_rad=(tau, tau, pi, tau, tau, tau),
        speed_rad_s=tuple(map(radians, speeds)), torque_nm=tuple(torques),
        source="Universal_Robots_ROS2_Description, config/*/joint_limits.yaml; effort: ur_robot_driver",
    )  # fmt: skip


def _iiwa(name: str, model: str, speeds: Sequence[float], torques: Sequence[float]) -> Preset:
    high_rad = tuple(map(radians, (170, 120, 170, 120, 170, 120, 175)))
    return Preset(
        label=f"KUKA LBR iiwa {model}", pattern=name.replace("iiwa", "iiwa_?"), torque=SENSOR,
        joints=_seven("lbr_A"), shared=r"(?:lbr_|iiwa_|lbr_iiwa_)(?:joint_?|a)[1-7]",
        low_rad=tuple(-one for one in high_rad), high_rad=high_rad,
        speed_rad_s=tuple(map(radians, speeds)), torque_nm=tuple(torques),
        source="KUKA brochure Sensitive robotics LBR iiwa; names: lbr_fri_ros2_stack",
    )  # fmt: skip


PRESETS: dict[str, Preset] = {
    "panda": Preset(
        label="Franka Emika Panda (FER)", pattern="panda|fer", joints=_seven("panda_joint"), torque=SENSOR,
        low_rad=(-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
        high_rad=(2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
        speed_rad_s=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        torque_nm=(87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0), torque_rate_nm_s=1000.0,
        acceleration_rad_s2=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        source="Franka Control Interface documentation; libfranka 0.9",
    ),
    "fr3": Preset(
        label="Franka Research 3", pattern=r"fr3(?:v\d)?", joints=_seven("fr3_joint"), torque=SENSOR,
        low_rad=(-2.7437, -1.7837, -2.9007, -3.0421, -2.8065, 0.5445, -3.0159),
        high_rad=(2.7437, 1.7837, 2.9007, -0.1518, 2.8065, 4.5169, 3.0159),
        speed_rad_s=(2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26), acceleration_rad_s2=(10.0,) * 7,
        torque_nm=(87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0), torque_rate_nm_s=1000.0,
        source="franka_description/robots/fr3; libfranka 0.13",
    ),
    "ur3e": _universal_robots("ur3e", (180, 180, 180, 360, 360, 360), (56, 56, 28, 12, 12, 12)),
    "ur5e": _universal_robots("ur5e", (180,) * 6, (150, 150, 150, 28, 28, 28)),
    "ur10e": _universal_robots("ur10e", (120, 120, 180, 180, 180, 180), (330, 330, 150, 56, 56, 56)),
    "ur16e": _universal_robots("ur16e", (120, 120, 180, 180, 180, 180), (330, 330, 150, 54, 54, 54)),
    "ur20": _universal_robots("ur20", (120, 120, 150, 210, 210, 210), (738, 738, 433, 107, 107, 107)),
    "ur30": _universal_robots("ur30", (120, 120, 150, 210, 210, 210), (730, 730, 430, 100, 100, 100)),
    "iiwa7": _iiwa("iiwa7", "7 R800", (98, 98, 100, 130, 140, 180, 180), (176, 176, 110, 110, 110, 40, 40)),
    "iiwa14": _iiwa("iiwa14", "14 R820", (85, 85, 100, 75, 130, 135, 135), (320, 320, 176, 176, 110, 40, 40)),
    "gen3": Preset(
        label="Kinova Gen3, 7 joints", pattern="gen3(?!_lite)", joints=_seven("joint_"), torque=SENSOR,
        low_rad=(-inf, -2.41, -inf, -2.66, -inf, -2.23, -inf), high_rad=(inf, 2.41, inf, 2.66, inf, 2.23, inf),
        speed_rad_s=(1.3963, 1.3963, 1.3963, 1.3963, 1.2218, 1.2218, 1.2218),
        torque_nm=(39.0, 39.0, 39.0, 39.0, 9.0, 9.0, 9.0),
        source="kortex_description/arms/gen3/7dof; torque: Kortex API, ActuatorCyclic",
    ),
    "xarm7": Preset(
        label="UFACTORY xArm 7", pattern="xarm7", joints=_seven("joint"), torque=ESTIMATE,
        low_rad=(-tau, -2.059, -tau, -0.19198, -tau, -1.69297, -tau),
        high_rad=(tau, 2.0944, tau, 3.927, tau, pi, tau),
        speed_rad_s=(3.14,) * 7, torque_nm=(50.0, 50.0, 30.0, 30.0, 30.0, 20.0, 20.0),
        source="xarm_description/urdf/xarm7; no torque sensors: xarm_ros2 issue 98",
    ),
}  # fmt: skip
# panda_joint3, left_fr3_joint1, joint2: the arm before the word, the joint's number after it
ARM_JOINT = re.compile(r"^(?:(?P<arm>.*?)_?)?joint_?(?P<number>\d+)$", re.IGNORECASE)


def candidates(names: Sequence[str]) -> tuple[str, ...]:
    """Return the arms that joints of these names may belong to; none where the names are those of any arm."""
    found = [name for name, preset in PRESETS.items() if _is_named(names, preset)]
    if found:
        return tuple(found)
    alike = (name for name, preset in PRESETS.items() if preset.shared and len(names) == len(preset.joints))
    return tuple(n for n in alike if all(re.search(rf"{PRESETS[n].shared}$", one, re.IGNORECASE) for one in names))


def _is_named(names: Sequence[str], preset: Preset) -> bool:
    """Return True if the prefix of a joint says this arm; of an arm without such names all joints have to be there."""
    prefixes = {(match["arm"] or "") if (match := ARM_JOINT.match(name)) else name for name in names}
    arm = re.compile(rf"(?:^|[\W_])(?:{preset.pattern})(?:[\W_]|\d|$)", re.IGNORECASE)  # of left_ur10e_, say
    whole = preset.label.startswith("Franka") or len(names) == len(preset.joints)
    return whole and any(map(arm.search, prefixes))
