"""What is counted while a compensator runs: energies of the cycles, and how passive the joint stayed; compiled."""

import numpy as np

from friction_audit.compensation.records import Record
from friction_audit.compiled import compiled
from friction_audit.joint_log import Float

(
    STOP,
    FRICTION,
    NET,
    PATH_LENGTH,
    SQUARED,
    COULOMB_APPLIED,
    VISCOUS_APPLIED,
    COULOMB_ESTIMATED,
    VISCOUS_ESTIMATED,
    ACTED,
    STATUS,
) = range(11)  # columns of a row per cycle; the estimates are those made at the cycle's end
COLUMNS = 11

TALLY = np.dtype(
    [
        ("cycles", "i8"),
        ("friction_j", "f8"),  # what friction took
        ("net_j", "f8"),  # that less what the compensator gave, the rest being the person's
        ("path_rad", "f8"),
        ("square_rad2_s", "f8"),
        ("cycle_friction_j", "f8"),  # the four sums at the start of the cycle
        ("cycle_net_j", "f8"),
        ("cycle_path_rad", "f8"),
        ("cycle_square_rad2_s", "f8"),
        ("tolerance_j", "f8"),  # largest energy exchanged while a deficit is measured and paid
        ("lowest_j", "f8"),  # of the ledger from the start
        ("lowest_active_j", "f8"),  # of the ledger since the compensator became active
        ("violations", "i8"),
        ("active_violations", "i8"),
        ("activation", "i8"),  # sample at which it became active, -1 before
        ("reserve_j", "f8"),  # the ledger then
        ("active_friction_j", "f8"),  # what friction took since
        ("acting_s", "f8"),
        ("largest_nm", "f8"),  # of the torques in force
        ("limited", "i8"),  # samples at a limit of torque or rate
        ("fastest_nm_s", "f8"),
        ("injected_j", "f8"),
        ("hidden", "i8"),  # 1 once the reserve from before hides over-compensation from the ledger
        ("diverged", "i8"),
    ]
)

GIVEN_OUT = 0.05  # share of the dissipation that a joint gives out before it counts as over-compensated
# Samples, besides the time in which a deficit is paid, whose energy the ledger may be below zero: one goes by until the
# deficit is measured, and one until the damping is felt.
SAMPLES = 2.0
BEYOND_NOISE = 0.01  # share of the reserve that it must have given out as well: just after activation all is noise
NEARLY = 1.0 - 1e-9


def fresh_tally() -> np.ndarray[tuple[int], np.dtype[np.void]]:
    """Return the tally of a replay that has not begun, one record of TALLY."""
    tally = np.zeros(1, TALLY)
    tally["activation"] = -1
    return tally


@compiled()
def count_energy(tally: Record, settings: Record, friction_j: float, net_j: float, moved: float, dt: float) -> None:
    """Add an interval between two ticks.

    Args:
        tally: Changed.
        settings: Of the compensator, for the speed of rest: there, noise would add up to a path.
        friction_j: Energy that friction took. [J]
        net_j: That less what the compensator gave. [J]
        moved: Displacement. [rad]
        dt: Duration. [s]
    """
    tally.friction_j += friction_j
    tally.net_j += net_j
    if abs(moved) > settings.rest_rad_s * dt:
        tally.path_rad += abs(moved)
        tally.square_rad2_s += moved * moved / dt
    if tally.activation >= 0:
        tally.active_friction_j += friction_j


@compiled()
def count_tick(tally: Record, settings: Record, memory: Record, u_before: float, i: int) -> None:
    """Look at ledger, controller and limits after the compensator's tick i."""
    ledger = memory.observed_energy_j
    tally.lowest_j = min(tally.lowest_j, ledger)
    if ledger < -tally.tolerance_j:
        tally.violations += 1
    if memory.active == 1:
        if tally.activation < 0:
            tally.activation, tally.reserve_j = i, ledger
        tally.lowest_active_j = min(tally.lowest_active_j, memory.active_energy_j)
        if memory.active_energy_j < -tally.tolerance_j:
            tally.active_violations += 1
        out = max(GIVEN_OUT * tally.active_friction_j, BEYOND_NOISE * tally.reserve_j)
        if ledger >= 0.0 and out > 0.0 and memory.active_energy_j < -out:
            tally.hidden = 1
    if memory.damping_nms_per_rad > 0.0:
        tally.acting_s += settings.period_s
    tally.injected_j = memory.dissipated_j
    tally.largest_nm = max(tally.largest_nm, abs(u_before))
    change = abs(memory.u_nm - u_before)
    tally.fastest_nm_s = max(tally.fastest_nm_s, change / settings.period_s)
    at_rate = change >= settings.max_torque_rate_nm_s * settings.period_s * NEARLY
    if at_rate or abs(memory.u_nm) >= settings.max_torque_nm * NEARLY:
        tally.limited += 1


@compiled()
def close_row(tally: Record, memory: Record, coulomb: float, viscous: float, acted: int, i: int, rows: Float) -> None:
    """Write the row of the cycle that ended at sample i, during which these coefficients were applied."""
    row = rows[tally.cycles]
    row[STOP] = i
    row[FRICTION], row[NET] = tally.friction_j - tally.cycle_friction_j, tally.net_j - tally.cycle_net_j
    row[PATH_LENGTH] = tally.path_rad - tally.cycle_path_rad
    row[SQUARED] = tally.square_rad2_s - tally.cycle_square_rad2_s
    row[COULOMB_APPLIED], row[VISCOUS_APPLIED] = coulomb, viscous
    row[COULOMB_ESTIMATED] = memory.estimated_coulomb_nm
    row[VISCOUS_ESTIMATED] = memory.estimated_viscous_nms_per_rad
    row[ACTED], row[STATUS] = acted, memory.status
    tally.cycle_friction_j, tally.cycle_net_j = tally.friction_j, tally.net_j
    tally.cycle_path_rad, tally.cycle_square_rad2_s = tally.path_rad, tally.square_rad2_s
    tally.cycles += 1
