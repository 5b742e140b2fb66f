"""Session: what one recording says of the friction of one arm, small enough to keep for ever."""

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from friction_audit.friction.history import Coefficient

Numbers = Sequence[float]


@dataclass(frozen=True, kw_only=True, slots=True)
class SpeedCurve:
    """Torque against speed, the mean in bins of speed; kept as arrays, for a batch holds thousands of curves.

    Attributes:
        speed_rad_s: Mean speed in each bin, rising, both directions. [rad/s]
        torque_nm: Mean interaction torque in it. [N m]
        spread_nm: Standard deviation of the torque in it. [N m]
    """

    speed_rad_s: Numbers = ()
    torque_nm: Numbers = ()
    spread_nm: Numbers = ()

    def __post_init__(self) -> None:
        """Keep eight bytes a number."""
        for name in ("speed_rad_s", "torque_nm", "spread_nm"):
            object.__setattr__(self, name, array("d", getattr(self, name)))


@dataclass(frozen=True, kw_only=True, slots=True)
class JointSummary:
    """One joint in one session.

    Attributes:
        joint: Number for people, 1..n.
        name: Name in the log.
        coefficients: Estimate with 95 % interval by ``"coulomb_nm"`` and ``"viscous_nms_per_rad"``; NaN where the log
            cannot give one.
        cycles: Energy cycles that count.
        moving_s: Time in motion. [s]
        speed_rad_s: Lower quartile, median and upper quartile of the speed in motion. [rad/s]
        temperature_c: Mean of the logged temperature, or None. [degC]
        within: Relative change of each coefficient from the first to the last third of the session, with interval:
            warm-up, kept apart from drift between sessions. NaN where the session is too short.
        curve: Torque against speed.
        reason: Why there is no estimate; empty if there is one.
        verdict: What ``diagnose`` says, or None if it was not asked.
        effects: Names of the effects that it found.
    """

    joint: int
    name: str
    coefficients: Mapping[str, Coefficient]
    cycles: int
    moving_s: float
    speed_rad_s: tuple[float, float, float]
    temperature_c: float | None = None
    within: Mapping[str, Coefficient] = field(default_factory=dict)
    curve: SpeedCurve = field(default_factory=SpeedCurve)
    reason: str = ""
    verdict: str | None = None
    effects: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class Conditions:
    """Under what a session was recorded and read; sessions that differ here are not compared silently.

    Attributes:
        drive: ``"hand"`` or ``"robot"``.
        torque: Channel that the interaction torque came from.
        gravity: Where gravity came from.
        inertia: Where the inertial torque came from.
        payload: What the manifest says of the payload; empty if nothing.
        rate_hz: Rate of the samples. [Hz]
    """

    drive: str
    torque: str
    gravity: str
    inertia: str
    payload: str = ""
    rate_hz: float = 1000.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Session:
    """One recording of one arm.

    Attributes:
        path: As found.
        sha256: Content hash.
        robot: Which arm, as told apart by serial, namespace, manifest or folder.
        start_s: Unix time of the start, or None where nothing tells. [s]
        start_from: ``"manifest"``, ``"log"``, ``"name"`` or ``"nothing"``.
        duration_s: Length. [s]
        conditions: Under what it was recorded.
        temperature_c: From the manifest, or None. [degC]
        note: From the manifest.
        joints: One summary per joint.
        warnings: What was noticed, one sentence each.
        damaged: Whether part of the file was left out.
    """

    path: str
    sha256: str
    robot: str
    start_s: float | None
    start_from: str
    duration_s: float
    conditions: Conditions
    joints: tuple[JointSummary, ...]
    temperature_c: float | None = None
    note: str = ""
    warnings: tuple[str, ...] = ()
    damaged: bool = False
