"""JointLog and its first steps -> LogSummary: what is in a log, for ``info``."""

from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction, TorqueChoice
from friction_audit.reporting.terminal.plain import Notice, interaction_notices, log_notices

STALE = "stale_samples"
"""Code of the finding that counts repeated rows."""

GAP_PERIODS = 5.0
"""A step of time longer than this many sampling periods is called a gap."""

ROUNDING_S = 1e-9
"""Steps that scatter by less are even: stamps hold no smaller times, and their differences are rounded."""


@dataclass(frozen=True, kw_only=True, slots=True)
class JointMotion:
    """How one joint moved.

    Attributes:
        joint: Number for people.
        name: Name in the log.
        peak_speed_rad_s: Largest speed, as logged. [rad/s]
        range_rad: Largest minus smallest position. [rad]
        moving_s: Time above the threshold at which a cycle begins, or None without cycles. [s]
        cycles: Energy cycles found, or None where none were looked for.
        open_cycles: Those that do not end where they began, or None.
        rejected_cycles: Those that would be left out of an estimate, or None.
    """

    joint: int
    name: str
    peak_speed_rad_s: float
    range_rad: float
    moving_s: float | None = None
    cycles: int | None = None
    open_cycles: int | None = None
    rejected_cycles: int | None = None


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogSummary:
    """What is in a log.

    Attributes:
        log: The log.
        jitter_s: Standard deviation of the time steps that are not gaps. [s]
        gaps: Number of steps longer than GAP_PERIODS sampling periods.
        longest_gap_s: The longest of them, 0 without any. [s]
        stale_samples: Rows that only repeated the one before and were left out when the log was read.
        torque: How the interaction torque would be made, or None if it cannot.
        joints: How the joints moved.
        notices: What the user must know.
    """

    log: JointLog
    jitter_s: float
    gaps: int
    longest_gap_s: float
    stale_samples: int
    torque: TorqueChoice | None
    joints: tuple[JointMotion, ...]
    notices: tuple[Notice, ...]

    @property
    def jitter(self) -> str:
        """The jitter in words."""
        return f"jitter {1e3 * self.jitter_s:.3g} ms" if self.jitter_s >= ROUNDING_S else "no jitter"

    @property
    def clock_check(self) -> str:
        """On how much of the log the clock was held against the motion, in words."""
        windows = self.log.source.clock_windows
        return f"checked on {windows} window{'' if windows == 1 else 's'}" if windows else "not checked"


def summarize_log(
    log: JointLog, interaction: Interaction | None, cycles: EnergyCycles | None, obstacle: str = ""
) -> LogSummary:
    """Return the summary of a log.

    Args:
        log: The log.
        interaction: Its interaction torque, or None if it cannot be made.
        cycles: Its cycles, or None without an interaction torque.
        obstacle: Why there is no interaction torque.
    """
    steps = np.diff(log.t)
    gap = steps > GAP_PERIODS * np.median(steps)
    notices = log_notices(log) + (interaction_notices(interaction) if interaction else ())
    if obstacle:
        notices += (Notice("no_interaction_torque", None, obstacle),)
    return LogSummary(
        log=log,
        jitter_s=float(np.std(steps[~gap])),
        gaps=int(gap.sum()),
        longest_gap_s=float(steps[gap].max(initial=0.0)),
        stale_samples=_stale_samples(log),
        torque=interaction.choice if interaction else None,
        joints=_joints(log, interaction, cycles),
        notices=notices,
    )


def _stale_samples(log: JointLog) -> int:
    return int(sum(found.amount or 0.0 for found in log.source.findings if found.code == STALE))


def _joints(log: JointLog, interaction: Interaction | None, cycles: EnergyCycles | None) -> tuple[JointMotion, ...]:
    if interaction is None or cycles is None:
        return tuple(_motion(log.q[:, c], log.dq[:, c], c + 1, name) for c, name in enumerate(log.joint_names))
    return tuple(_motion_in_cycles(interaction, cycles, column) for column in range(len(interaction.joint_numbers)))


def _motion(q: Float, dq: Float, joint: int, name: str) -> JointMotion:
    return JointMotion(joint=joint, name=name, peak_speed_rad_s=float(np.abs(dq).max()), range_rad=float(np.ptp(q)))


def _motion_in_cycles(interaction: Interaction, cycles: EnergyCycles, column: int) -> JointMotion:
    own = cycles.of_joint(column)
    return JointMotion(
        joint=interaction.joint_numbers[column],
        name=interaction.joint_names[column],
        peak_speed_rad_s=float(np.abs(interaction.dq[:, column]).max()),
        range_rad=float(np.ptp(interaction.q[:, column])),
        moving_s=float(cycles.moving_s[column]),
        cycles=len(own.joint),
        open_cycles=int(own.open.sum()),
        rejected_cycles=int((own.reason != 0).sum()),
    )
