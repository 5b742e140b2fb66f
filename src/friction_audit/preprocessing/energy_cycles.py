"""EnergyCycles: a structure of arrays, one row per energy cycle of a joint.

An energy cycle is the half-open interval [start, stop) of samples from one termination to the next (paper, section
III): the joint rests at both ends, so its kinetic energy cancels and the work left is what friction took. Sums are
trapezoids over [t[start], t[stop]], on the real stamps; neighbours share the border sample and nothing else.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from friction_audit.joint_log import Bool, Float, Int

# Why a cycle is rejected: kept, a gap in the log, no return to its start while gravity is in the torque, not every
# joint has moved enough, the joint never reversed, longer than energies can be compared over.
KEPT, GAP, OPEN, SMALL, ONE_WAY, LONG = range(6)
REASONS = ("", "gap", "open", "small", "one_way", "long")
# What the energy balance of a part of a cycle is about, the energy last; see ``EnergyCycles.products``.
BALANCE = (
    "path_rad", "speed_over_path_rad2_s", "displacement_rad", "half_square_speed_change",
    "gravity_x_rad", "gravity_y_rad", "dissipated_j",
)  # fmt: skip
PAIRS = np.triu_indices(len(BALANCE))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class EnergySums:
    """Energy sums over pieces of motion; every array has the same shape."""

    work_j: Float  # integral of F_m over the position, the net energy input [J]
    compensation_j: Float  # integral of u over the position, the energy that a logged compensator put in [J]
    printed_net_j: Float  # integral of (F_m + u) dq dt, the net energy as (2) and (10) print it [J]
    path_rad: Float  # path, with the sign of the filtered velocity: the noise of the velocity adds none at rest [rad]
    rectified_path_rad: Float  # integral of |dq| dt, as (14) prints it [rad]
    square_speed_rad2_s: Float  # integral of dq^2 dt, as (20) prints it [rad^2/s]
    speed_over_path_rad2_s: Float  # the same by the sum of the work, of dq over the position [rad^2/s]
    displacement_rad: Float  # change of q: the work of one newton metre of torque offset [rad]
    # integral of g_x dq dt: the work per newton metre of gravity error along x of the joint's frame
    gravity_x_rad: Float
    gravity_y_rad: Float  # the same along y
    # change of dq^2 / 2 of the filtered velocity: kinetic energy per inertia [rad^2/s^2]
    half_square_speed_change: Float

    @property
    def dissipated_j(self) -> Float:
        """What friction took: the net energy of (10), in signs where a compensator's work counts positive. [J]"""
        return self.work_j + self.compensation_j


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class EnergyCycles:
    """Energy cycles of one joint in the order of time, m rows, and what the search for them found of the joint."""

    start: Int  # first sample, shape (m,)
    stop: Int  # border sample, the next cycle's start, shape (m,)
    start_s: Float  # t[start] [s]
    stop_s: Float  # t[stop] [s]
    peak_speed_rad_s: Float  # largest filtered speed [rad/s]
    sums: EnergySums  # over the whole cycle, arrays of shape (m,)
    # Of parts of equal path, the products of PAIRS of BALANCE over the part's square speed, summed over each cycle; the
    # parts of a day would take most of the memory. Shape (m, len(PAIRS[0])).
    products: Float
    # path, and first and second moment of the mean speed of the parts over it, of those that move, shape (m, 3)
    speeds: Float
    open: Bool  # True where a joint does not end where it began, shape (m,)
    reason: Int  # index into REASONS; KEPT where the cycle counts, shape (m,)
    initiation: float  # threshold used [speed_unit]
    termination: float  # the other one [speed_unit]
    speed_unit: str  # ``"rad/s"``, or ``"m/s"`` where the hand defines the cycles
    # speed below which a direction means nothing: the joint's own termination threshold in any case [rad/s]
    standstill_rad_s: float
    # Known at the end of the log.
    fastest: float = 0.0  # largest filtered speed in the log of what the thresholds are for [speed_unit]
    moving_s: float = 0.0  # time above the initiation threshold [s]
    peak_power_w: float = 0.0  # largest power of F_m + u in the log [W]

    def rows(self, mask: Bool) -> "EnergyCycles":
        """Return the rows selected by a mask of shape (m,)."""
        per_cycle = "start", "stop", "start_s", "stop_s", "peak_speed_rad_s", "open", "reason"
        kept = {name: getattr(self, name)[mask] for name in (*per_cycle, "products", "speeds")}
        sums = EnergySums(**{f.name: getattr(self.sums, f.name)[mask] for f in fields(self.sums)})
        return replace(self, **kept, sums=sums)
