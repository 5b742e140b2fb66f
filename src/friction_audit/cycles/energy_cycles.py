"""EnergyCycles: a structure of arrays, one row per energy cycle of a joint.

An energy cycle is the half-open interval [start, stop) of samples from one termination to the next (paper, section
III): the joint is slow at both ends, so its kinetic energy cancels and the work left is what friction took. Sums are
trapezoid integrals on the real stamps over [t[start], t[stop]]; neighbours share the sample at the border and nothing
else.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float

Int = NDArray[np.int64]

REASONS = ("", "gap", "open", "small", "one_way")
"""Why a cycle is left out of the estimates: kept, a gap in the log, open in position while gravity is in the torque,
not every joint has moved enough, the joint never reversed."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class EnergyCycles:
    """Energy cycles of all joints, ordered by joint and then by time; m rows.

    Attributes:
        joint: Column of the Interaction (0-based), shape (m,).
        start: First sample, shape (m,).
        stop: Border sample (the next cycle's start), shape (m,).
        start_s: t[start]. [s]
        stop_s: t[stop]. [s]
        work_j: Integral of F_m dq dt, the net energy input of the cycle. [J]
        compensation_j: Integral of u dq dt, the energy that a logged compensator put in. [J]
        path_rad: Integral of sgn(dq) dq dt, with the sign of the noise-free velocity. [rad]
        speed_path_rad2_s: Integral of dq^2 dt. [rad^2/s]
        displacement_rad: q[stop] - q[start]. [rad]
        sin_change: sin q[stop] - sin q[start].
        cos_change: cos q[stop] - cos q[start].
        half_square_speed_change: (dq[stop]^2 - dq[start]^2) / 2, from the filtered velocity. [rad^2/s^2]
        peak_speed_rad_s: Largest filtered speed. [rad/s]
        open: True where the joint does not end where it began.
        reason: Index into REASONS; 0 where the cycle counts.
        initiation_rad_s: Threshold used per joint of the Interaction, shape (j,). [rad/s]
        termination_rad_s: Threshold used per joint, shape (j,). [rad/s]
    """

    joint: Int
    start: Int
    stop: Int
    start_s: Float
    stop_s: Float
    work_j: Float
    compensation_j: Float
    path_rad: Float
    speed_path_rad2_s: Float
    displacement_rad: Float
    sin_change: Float
    cos_change: Float
    half_square_speed_change: Float
    peak_speed_rad_s: Float
    open: NDArray[np.bool_]
    reason: Int
    initiation_rad_s: Float
    termination_rad_s: Float

    @property
    def dissipated_j(self) -> Float:
        """What friction took per cycle: E_net = work of the hand + work of the compensator, (10) in SI signs. [J]"""
        return self.work_j + self.compensation_j

    def of_joint(self, column: int) -> "EnergyCycles":
        """Return the rows of one joint."""
        return self.rows(self.joint == column)

    def rows(self, mask: NDArray[np.bool_]) -> "EnergyCycles":
        """Return the rows selected by a mask of shape (m,)."""
        per_joint = ("initiation_rad_s", "termination_rad_s")
        kept = {name: getattr(self, name) for name in self.__slots__}
        kept |= {name: column[mask] for name, column in kept.items() if name not in per_joint}
        return EnergyCycles(**kept)
