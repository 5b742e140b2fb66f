"""How energy cycles are found."""

from dataclasses import dataclass
from math import inf

from friction_audit.errors import UsageError

THRESHOLDS = ("fixed", "auto")
CYCLES_FROM = ("joint", "hand")


@dataclass(frozen=True, kw_only=True, slots=True)
class CycleSettings:
    """Settings of the segmentation; the defaults are the paper's (section V).

    Attributes:
        thresholds: ``"fixed"`` (the two below) or ``"auto"`` (from the log's own noise and speeds).
        initiation_rad_s: Filtered speed above which a cycle begins. [rad/s]
        termination_rad_s: Filtered speed below which it ends. [rad/s]
        cutoff_hz: Corner of the low-pass filter on the velocity, for detection only. [Hz]
        cycles_from: ``"joint"``: each joint has its own cycles; ``"hand"``: the end effector's speed defines them.
        hand_initiation_m_s: Hand speed above which a cycle begins. [m/s]
        hand_termination_m_s: Hand speed below which it ends. [m/s]
        minimum_path_rad: With ``"hand"``, a cycle counts only if every joint selected has moved this far. [rad]
        maximum_gap_s: A cycle with a longer hole in the log (and longer than 3.5 steps) is left out. [s]
        closure_rad: A cycle whose ends are further apart is open in position. [rad]

    Raises:
        UsageError: If a number is out of range or a name unknown.
    """

    thresholds: str = "fixed"
    initiation_rad_s: float = 0.2
    termination_rad_s: float = 0.05
    cutoff_hz: float = 20.0
    cycles_from: str = "joint"
    hand_initiation_m_s: float = 0.1
    hand_termination_m_s: float = 0.025
    minimum_path_rad: float = 0.1
    maximum_gap_s: float = 0.05
    closure_rad: float = 0.05

    def __post_init__(self) -> None:
        """Check names and ranges."""
        if self.thresholds not in THRESHOLDS:
            raise UsageError(f"--thresholds {self.thresholds}: expected one of {', '.join(THRESHOLDS)} or two numbers")
        if self.cycles_from not in CYCLES_FROM:
            raise UsageError(f"--cycles-from {self.cycles_from}: expected one of {', '.join(CYCLES_FROM)}")
        for option, start, stop, unit in (
            ("--thresholds", self.initiation_rad_s, self.termination_rad_s, "rad/s"),
            ("--hand-thresholds", self.hand_initiation_m_s, self.hand_termination_m_s, "m/s"),
        ):
            if not inf > start > stop > 0:
                raise UsageError(
                    f"{option} {start:g},{stop:g}: expected initiation above termination and both above zero, in {unit}"
                )
        if not inf > self.minimum_path_rad >= 0:
            raise UsageError(f"--min-path {self.minimum_path_rad:g}: expected an angle of zero or more, in rad")
