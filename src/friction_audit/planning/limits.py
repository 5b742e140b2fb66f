"""Limits of a joint's motion: of the arm, of a person's hand, and as asked for."""

from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

from friction_audit.errors import UsageError
from friction_audit.robot.arm import BUILT_IN, read_urdf
from friction_audit.robot.urdf import limits_in

SOURCES = {BUILT_IN: "libfranka, moveit_resources (panda_moveit_config)", "": "usual of arms"}
# Of joints 1 to 7, a quarter of what libfranka allows, in rad/s^2; with it 300 rad/s^3: joint_limits.yaml of
# moveit_resources. Positions and speeds of the built-in URDF are those of libfranka.
PANDA_ACCELERATIONS = (3.75, 1.875, 2.5, 3.125, 3.75, 5.0, 5.0)
PANDA_JERK = 300.0
USUAL = (1.5, 2.5, 100.0)  # rad/s, rad/s^2, rad/s^3: below the limits of all common arms
HAND = (1.8, 8.0, 150.0)  # what a person does with ease; slower than this a person is not steady:
HAND_SLOWEST, ROBOT_SLOWEST = 0.05, 0.01  # rad/s
MARGIN_RAD = 0.05  # kept from the ends of the joint's range
REACH_RAD = 0.8  # to either side of the start: room for gravity, which takes 1.5 rad, within most arms' ranges
LEAST_RANGE_RAD = 0.02  # below it no candidate motion has a certain direction for long


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """Limits of one joint.

    Attributes:
        start_rad: Position at which the motion starts and ends. [rad]
        low_rad: Lowest position. [rad]
        high_rad: Highest position. [rad]
        speed_rad_s: Highest speed. [rad/s]
        acceleration_rad_s2: Highest acceleration. [rad/s^2]
        jerk_rad_s3: Highest jerk. [rad/s^3]
        slowest_rad_s: Slowest steady speed. [rad/s]
        source: Where they come from.
    """

    start_rad: float
    low_rad: float
    high_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    jerk_rad_s3: float
    slowest_rad_s: float
    source: str

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


@dataclass(frozen=True, kw_only=True, slots=True)
class Wanted:
    """Limits as asked for, None where the arm decides.

    Attributes:
        range_rad: Lowest and highest position, relative to the start. [rad]
        speed_rad_s: Highest speed. [rad/s]
        acceleration_rad_s2: Highest acceleration. [rad/s^2]
        jerk_rad_s3: Highest jerk. [rad/s^3]
    """

    range_rad: tuple[float, float] | None = None
    speed_rad_s: float | None = None
    acceleration_rad_s2: float | None = None
    jerk_rad_s3: float | None = None


def limits_of(
    name: str,
    joint: int,
    start_rad: float,
    *,
    urdf: Path | None,
    panda: bool,
    hand: bool,
    reach_rad: tuple[float, float],
    wanted: Wanted,
) -> Limits:
    """Return the limits of a joint: those of the arm, tightened to those of a hand, replaced by what is asked for.

    Args:
        name: Name of the joint in the log.
        joint: Its number, from 1.
        start_rad: Where the motion starts. [rad]
        urdf: File of the arm, or None.
        panda: Whether the arm is a Panda, where no file is given.
        hand: Whether a person moves it.
        reach_rad: Range where none is asked for, relative to the start. [rad]
        wanted: As asked for.

    Raises:
        UsageError: If the URDF has no such joint or no motion keeps the limits.
    """
    low, high, speed = -inf, inf, inf
    acceleration, jerk, source = (*USUAL[1:], SOURCES[""])
    if urdf is not None:
        low, high, speed = limits_in(read_urdf(urdf), str(urdf), name)
        source = f"{urdf.name}; acceleration and jerk {source}"
    elif panda:
        low, high, speed = limits_in(read_urdf(None), "the built-in Panda", f"panda_joint{joint}")
        acceleration, jerk, source = PANDA_ACCELERATIONS[joint - 1], PANDA_JERK, SOURCES[BUILT_IN]
    if hand:
        speed, acceleration, jerk = min(speed, HAND[0]), min(acceleration, HAND[1]), min(jerk, HAND[2])
        source = f"{source}; at most those of a person"
    below, above = wanted.range_rad or reach_rad
    found = Limits(
        start_rad=start_rad,
        low_rad=max(low + MARGIN_RAD, start_rad + below),
        high_rad=min(high - MARGIN_RAD, start_rad + above),
        speed_rad_s=USUAL[0] if speed == inf else speed,
        acceleration_rad_s2=acceleration,
        jerk_rad_s3=jerk,
        slowest_rad_s=HAND_SLOWEST if hand else ROBOT_SLOWEST,
        source=source,
    )
    asked = {key: getattr(wanted, key) for key in ("speed_rad_s", "acceleration_rad_s2", "jerk_rad_s3")}
    return replace(found, **{key: value for key, value in asked.items() if value is not None})
