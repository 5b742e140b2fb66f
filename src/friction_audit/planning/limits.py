"""Limits of a joint's motion: of the arm, of a person's hand, and as asked for."""

from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import Any

from friction_audit.errors import UsageError
from friction_audit.planning.task import Joint
from friction_audit.robot.arm import read_urdf
from friction_audit.robot.urdf import limits_in

# Of joints 1 to 7, a quarter of what libfranka allows, in rad/s^2; with it 300 rad/s^3: joint_limits.yaml of
# moveit_resources. Positions and speeds of the built-in URDF are those of libfranka.
PANDA_ACCELERATIONS, PANDA_JERK = (3.75, 1.875, 2.5, 3.125, 3.75, 5.0, 5.0), 300.0
USUAL = (1.5, 2.5, 100.0)  # rad/s, rad/s^2, rad/s^3: below the limits of all common arms
HAND = (1.8, 8.0, 150.0)  # what a person does with ease; slower than this a person is not steady:
HAND_SLOWEST, ROBOT_SLOWEST = 0.05, 0.01  # rad/s
MARGIN_RAD = 0.05  # kept from the ends of the joint's range
LEAST_RANGE_RAD = 0.02  # below it no candidate motion has a certain direction for long


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Limits of one joint.

    Raises:
        UsageError: If no motion keeps them.
    """

    start_rad: float  # where the motion starts and ends
    low_rad: float
    high_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    jerk_rad_s3: float
    slowest_rad_s: float  # slowest steady speed
    source: str  # where they come from

    def __post_init__(self) -> None:
        if not self.low_rad <= self.start_rad <= self.high_rad:
            raise UsageError(
                f"start {self.start_rad:.3g} rad: outside of {self.low_rad:.3g} to {self.high_rad:.3g} rad, where the "
                "joint may move; give another --start, or --range"
            )
        if self.high_rad - self.low_rad < LEAST_RANGE_RAD:
            raise UsageError(
                f"{self.high_rad - self.low_rad:.3g} rad of range: expected at least {LEAST_RANGE_RAD:g}; widen --range"
            )
        rates = (self.speed_rad_s, self.acceleration_rad_s2, self.jerk_rad_s3)
        if not all(0.0 < rate < inf for rate in rates) or self.speed_rad_s < 2.0 * self.slowest_rad_s:
            raise UsageError(
                f"limits of {rates[0]:g} rad/s, {rates[1]:g} rad/s^2 and {rates[2]:g} rad/s^3: expected a speed of at "
                f"least {2.0 * self.slowest_rad_s:g} rad/s, and others above zero; raise --speed, --acceleration or "
                "--jerk"
            )


def limits_of(
    joint: Joint,
    start_rad: float,
    *,
    urdf: Path | None,
    panda: bool,
    range_rad: tuple[float, ...] | None = None,
    **asked: float | None,
) -> Limits:
    """Return the limits of a joint: those of the arm, tightened to those of a hand, replaced by what is asked for.

    Args:
        joint: The joint.
        start_rad: Where the motion starts. [rad]
        urdf: File of the arm, or None.
        panda: Whether the arm is a Panda, where no file is given.
        range_rad: Lowest and highest position as asked for, relative to the start. [rad]
        asked: Speed, acceleration and jerk as asked for, by the names of ``Limits``; None where the arm decides.

    Raises:
        UsageError: If the URDF has no such joint or no motion keeps the limits.
    """
    low, high, speed = -inf, inf, inf
    acceleration, jerk, source = (*USUAL[1:], "usual of arms")
    if urdf is not None:
        low, high, speed = limits_in(read_urdf(urdf), str(urdf), joint.name)
        source = f"{urdf.name}; acceleration and jerk {source}"
    elif panda:
        low, high, speed = limits_in(read_urdf(None), "the built-in Panda", f"panda_joint{joint.number}")
        acceleration, jerk = PANDA_ACCELERATIONS[joint.number - 1], PANDA_JERK
        source = "libfranka, moveit_resources (panda_moveit_config)"
    if joint.hand:
        speed, acceleration, jerk = map(min, (speed, acceleration, jerk), HAND)
        source = f"{source}; at most those of a person"
    below, above = range_rad or joint.reach_rad
    found = Limits(
        start_rad=start_rad,
        low_rad=max(low + MARGIN_RAD, start_rad + below),
        high_rad=min(high - MARGIN_RAD, start_rad + above),
        speed_rad_s=USUAL[0] if speed == inf else speed,
        acceleration_rad_s2=acceleration,
        jerk_rad_s3=jerk,
        slowest_rad_s=HAND_SLOWEST if joint.hand else ROBOT_SLOWEST,
        source=source,
    )
    given: dict[str, Any] = {key: value for key, value in asked.items() if value is not None}
    return replace(found, **given)
