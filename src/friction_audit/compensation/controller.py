"""The compensator at one tick of the controller, compiled; other compiled loops call ``step``.

The joint on the motor side of its torque sensor obeys B ddq = F_m + u - tau_f. Integrated over a cycle from rest to
rest, sum F_m dq + sum u dq = sum tau_f dq: what human and compensator put in, friction took. The general form of (10),
(13), (16) and (25) is therefore E_net = E_n - E_(n-1) + sum u dq with all of u, the damping of the passivity controller
included, whose work is negative.
"""

import math

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation import competitors, law, records
from friction_audit.compensation.competitors import Compensator
from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float, read_only

EPSILON = 4.0 * 2.0**-52  # of a determinant that is zero but for rounding
FIND = -1  # value of ``cut``: the joint finds its cycles itself

# Cycles that the hand of an arm ends for all joints at once (paper, section V.B).
FILTERED_M_S, UNDER_WAY = range(2)  # state of the hand: its filtered speed, and whether a cycle is under way
CYCLE_STATE = 2
THRESHOLDS_M_S = (0.1, 0.025)  # hand speeds at which a cycle begins and ends
CORNER_RAD_S = 2.0 * math.pi * 20.0  # of the low-pass on the hand's speed

SPEED_BOUND_RAD_S, TORQUE_BOUND_NM = 100.0, 1e4  # beyond all arms with torque sensors: the loop has diverged
# So many ticks in a row a torque at its limit has turned back: the limits hold a loop that would grow without them.
# Noise does that for three or four ticks, a hand for one.
REVERSALS = 50
# A longer hole in the log adds no energy, and a joint in a closed loop starts again from the recording after it. [s]
HOLE_S = 1.0
EVEN = 1e-8  # time constants of a filter between a step of the clock and its period


@compiled()
def step(settings: Record, memory: Record, dq: float, interaction_nm: float, dt: float, cut: int) -> float:
    """Run a compensator for one tick, after the sensors were read; return its torque u for the coming tick. [N m]

    The records are those of SETTINGS and MEMORY; the latter changes. F_m was measured while the torque of the previous
    call acted, dt seconds ago. ``cut`` is FIND, or 1 if a cycle ends at this tick and 0 if not.
    """
    # Not finite, or larger than its bound.
    lost = not abs(dq) <= SPEED_BOUND_RAD_S or not abs(interaction_nm) <= TORQUE_BOUND_NM
    if memory.unstable == 1 or lost:
        return float(give_up(memory))
    if memory.ticks > 0:
        add_up(settings, memory, dq, interaction_nm, dt)
    advance(settings, memory, dq, interaction_nm, dt)
    memory.ticks += 1
    memory.dq = dq
    memory.interaction_nm = interaction_nm
    found = find_end(settings, memory, dq, dt)
    if (found if cut == FIND else cut == 1) and memory.ticks > 1:
        close_cycle(settings, memory)
    choose(settings, memory)
    memory.observed_energy_j = settings.initial_energy_j + memory.energy_j  # (21)
    u = command(settings, memory, dq)
    if not abs(u) <= TORQUE_BOUND_NM or memory.reversals >= REVERSALS:
        memory.ticks -= 1
        return float(give_up(memory))
    return float(u)


@compiled()
def give_up(memory: Record) -> float:
    """Give no torque from now on: the loop has diverged."""
    memory.unstable = 1
    memory.ticks += 1
    memory.u_nm = memory.compensation_nm = memory.passivity_nm = memory.limited_nm = memory.damping_nms_per_rad = 0.0
    return 0.0


@compiled(inline=True)
def advance(settings: Record, memory: Record, dq: float, interaction_nm: float, dt: float) -> None:
    """Advance what the law remembers over the interval since the previous tick."""
    if settings.kind == law.LUGRE and memory.ticks > 0:
        competitors.lugre_advance(settings.lugre, memory, dq, dt)
    elif settings.kind == law.DISTURBANCE_OBSERVER and memory.ticks > 0:
        competitors.observe(settings.disturbance_observer, memory, dq, interaction_nm, dt)
    elif settings.kind == law.TORQUE_REGULATION:
        # A low-pass, but the first torque is taken as it is.
        share = 1.0 if memory.ticks == 0 else -math.expm1(-2.0 * math.pi * settings.torque_regulation.cutoff_hz * dt)
        memory.filtered_interaction_nm += share * (interaction_nm - memory.filtered_interaction_nm)


@compiled(inline=True)
def add_up(settings: Record, memory: Record, dq: float, interaction_nm: float, dt: float) -> None:
    """Add the interval since the previous tick by trapezoids, u held, to the cycle and the ledgers (2), (24)."""
    memory.longest_gap_s = max(memory.longest_gap_s, dt)
    if dt > HOLE_S:
        return
    moved = 0.5 * (memory.dq + dq) * dt
    work = 0.5 * (memory.interaction_nm + interaction_nm) * moved
    memory.net_j += work + memory.u_nm * moved
    before = abs(memory.dq) if abs(memory.dq) > settings.rest_rad_s else 0.0
    memory.path_rad += 0.5 * (before + (abs(dq) if abs(dq) > settings.rest_rad_s else 0.0)) * dt
    memory.square_rad2_s += 0.5 * (memory.dq * memory.dq + dq * dq) * dt
    memory.energy_j += work
    if memory.active == 1:
        memory.active_energy_j += work
    memory.dissipated_j -= memory.passivity_nm * moved


@compiled(inline=True)
def find_end(settings: Record, memory: Record, dq: float, dt: float) -> bool:
    """Return True if an energy cycle ends at this tick, which began where the filtered speed exceeded its threshold.

    It ends when the filtered speed has fallen below another one and the joint, by its velocity as measured, rests.
    """
    late = settings.corner_rad_s * (dt - settings.period_s)
    if memory.ticks == 1:
        gain = 1.0
    elif abs(late) < EVEN:  # the first two terms of the exponential are all of it
        gain = settings.gain + (1.0 - settings.gain) * late
    else:
        gain = 1.0 - math.exp(-settings.corner_rad_s * dt)
    memory.filtered_rad_s += gain * (dq - memory.filtered_rad_s)
    direction = memory.direction
    ended = (
        direction != 0.0
        and memory.filtered_rad_s * direction < settings.termination_rad_s
        and dq * direction <= settings.rest_rad_s
    )
    if ended:
        memory.direction = 0.0
    if memory.direction == 0.0 and abs(memory.filtered_rad_s) > settings.initiation_rad_s:
        memory.direction = math.copysign(1.0, memory.filtered_rad_s)
    return bool(ended)


@compiled(inline=True)
def close_cycle(settings: Record, memory: Record) -> None:
    """End the cycle at this tick, estimate, and begin the next one here."""
    memory.cycle += 1
    if memory.longest_gap_s > settings.maximum_gap_s:
        memory.status = records.GAP
    elif memory.path_rad < settings.minimum_path_rad:
        memory.status = records.NOT_MOVED
    else:
        row = memory.rows[memory.count % settings.window]
        row[records.NET], row[records.PATH], row[records.SQUARE] = memory.net_j, memory.path_rad, memory.square_rad2_s
        memory.count += 1
        memory.status = estimate(settings, memory)
    if memory.acted == 1:
        memory.released = 1
    memory.acted = 0
    memory.net_j = memory.path_rad = memory.square_rad2_s = memory.longest_gap_s = 0.0


@compiled(inline=True)
def estimate(settings: Record, memory: Record) -> int:
    """Estimate from the last k cycles: viscous (8), (11), (25), Coulomb (14), combined (20); return the status.

    (19) prints the right pseudo-inverse of a tall matrix, which does not exist for k > 2; this is the left one.
    """
    if memory.count < settings.window:
        return records.TOO_FEW
    net_path = net_square = path_path = path_square = square_square = 0.0
    for i in range(settings.window):
        row = memory.rows[i]
        net, path, square = row[records.NET], row[records.PATH], row[records.SQUARE]
        net_path += net * path
        net_square += net * square
        path_path += path * path
        path_square += path * square
        square_square += square * square
    coulomb = viscous = 0.0
    if settings.model == records.VISCOUS:
        viscous = memory.estimated_viscous_nms_per_rad = net_square / square_square
    elif settings.model == records.COULOMB:
        coulomb = memory.estimated_coulomb_nm = net_path / path_path
    else:
        # Ridge towards the coefficients in use: two cycles of one speed determine the sum of both, and no more.
        path_weight, square_weight = settings.ridge * path_path, settings.ridge * square_square
        net_path += path_weight * memory.usable_coulomb_nm
        net_square += square_weight * memory.usable_viscous_nms_per_rad
        path_path, square_square = path_path + path_weight, square_square + square_weight
        determinant = path_path * square_square - path_square * path_square
        if determinant <= EPSILON * path_path * square_square:  # of rank one: by its pseudo-inverse
            coulomb = (path_path * net_path + path_square * net_square) / (path_path + square_square) ** 2
            viscous = (path_square * net_path + square_square * net_square) / (path_path + square_square) ** 2
        else:
            coulomb = (square_square * net_path - path_square * net_square) / determinant
            viscous = (path_path * net_square - path_square * net_path) / determinant
        memory.estimated_coulomb_nm, memory.estimated_viscous_nms_per_rad = coulomb, viscous
        # Non-negative least squares: of a pair with a negative coefficient the other alone fits, and less of it.
        if settings.ridge > 0.0 and coulomb < 0.0:
            coulomb, viscous = 0.0, net_square / square_square
        elif settings.ridge > 0.0 and viscous < 0.0:
            coulomb, viscous = net_path / path_path, 0.0
    # Friction brakes: a negative estimate is kept and not applied.
    memory.usable_coulomb_nm, memory.usable_viscous_nms_per_rad = max(0.0, coulomb), max(0.0, viscous)
    return records.ESTIMATED


@compiled(inline=True)
def choose(settings: Record, memory: Record) -> None:
    """Choose the coefficients to apply: given, forced or estimated."""
    coulomb = viscous = 0.0
    if settings.kind == law.FIXED:
        coulomb, viscous = settings.fixed.coulomb_nm, settings.fixed.viscous_nms_per_rad
    elif settings.kind == law.ENERGY:
        forced = not math.isnan(settings.forced_coulomb_nm) and memory.cycle + 1 >= settings.forced_from_cycle
        if forced and not (settings.forced_until_acted == 1 and memory.released == 1):
            coulomb, viscous = settings.forced_coulomb_nm, settings.forced_viscous_nms_per_rad
        else:
            coulomb = settings.factor * memory.usable_coulomb_nm
            viscous = settings.factor * memory.usable_viscous_nms_per_rad
    memory.coulomb_nm, memory.viscous_nms_per_rad = coulomb, viscous
    if coulomb != 0.0 or viscous != 0.0 or settings.kind > law.ENERGY:
        memory.active = 1


@compiled(inline=True)
def compensation(settings: Record, memory: Record, dq: float) -> float:  # noqa: PLR0911 - one per kind
    """Return the torque that the law of the compensator asks for. [N m]"""
    if settings.kind == law.FIXED:
        share = 1.0 if abs(dq) > settings.fixed.dead_band_rad_s else 0.0
        return float(share * (memory.coulomb_nm * math.copysign(1.0, dq) + memory.viscous_nms_per_rad * dq))
    if settings.kind == law.ENERGY:  # (9) with the sign that Figs 6 and 10 need
        sign = law.soft_sign(dq, settings.dead_band_rad_s, settings.ramp_rad_s)
        return float(memory.coulomb_nm * sign + memory.viscous_nms_per_rad * dq)
    if settings.kind == law.SIGMOID:
        return float(competitors.sigmoid_nm(settings.sigmoid, dq))
    if settings.kind == law.LUGRE:
        return float(competitors.lugre_nm(settings.lugre, memory, dq))
    if settings.kind == law.DISTURBANCE_OBSERVER:
        return float(competitors.observed_nm(settings.disturbance_observer, memory, dq))
    if settings.kind == law.TORQUE_REGULATION:
        ratio = settings.torque_regulation.inertia_kg_m2 / settings.torque_regulation.desired_inertia_kg_m2
        return float((ratio - 1.0) * memory.filtered_interaction_nm)
    if settings.kind == law.JOINT_MODEL:
        sign = law.soft_sign(dq, settings.joint_model.dead_band_rad_s, settings.joint_model.ramp_rad_s)
        return float(sign * memory.modelled_nm + memory.bristle_nm)
    return 0.0


@compiled(inline=True)
def command(settings: Record, memory: Record, dq: float) -> float:
    """Return the torque for the coming tick within the limits, and keep its parts. [N m]"""
    # The damping alpha of (22), which there pays the deficit within a tick and here over a horizon; capped.
    asked, alpha, deficit = compensation(settings, memory, dq), 0.0, -memory.observed_energy_j
    if settings.passivity != 0 and deficit > 0.0 and abs(dq) >= settings.minimum_speed_rad_s:
        horizon = max(settings.period_s, settings.payback_s)
        alpha = min(deficit / (dq * dq * horizon), settings.max_damping_nms_per_rad)
    wanted = asked - alpha * dq
    # Limits of the total only: a law limited around the last total would be dragged along with the braking (wind-up).
    step_nm = settings.max_torque_rate_nm_s * settings.period_s
    low, high = max(-settings.max_torque_nm, memory.u_nm - step_nm), min(settings.max_torque_nm, memory.u_nm + step_nm)
    u = min(max(wanted, low), high)
    # Ticks in a row at which the torque, at a limit, has turned back.
    change = u - memory.u_nm
    memory.reversals = memory.reversals + 1 if u != wanted and change * memory.last_change_nm < 0.0 else 0
    memory.last_change_nm = change
    memory.u_nm, memory.compensation_nm, memory.passivity_nm, memory.limited_nm = u, asked, -alpha * dq, u - wanted
    memory.damping_nms_per_rad = alpha
    if alpha > 0.0:
        memory.acted = 1
    return float(u)


@compiled()
def _trace(settings: Record, memory: Record, words: Record, t: Float, dq: Float, torque: Float, seen: Record) -> None:
    """Run a compensator over n samples, and keep the first words of its memory after each."""
    # ``int``: for a constant as such, numba compiles the compensator once more.
    for i in range(len(t)):
        step(settings, memory, dq[i], torque[i], t[i] - t[max(i - 1, 0)], int(FIND))
        for k in range(seen.shape[1]):  # one by one: for a slice, numba compiles a message for seconds
            seen[i, k] = words[k]


def run(
    compensator: Compensator | None, t: Float, dq: Float, interaction_nm: Float
) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    """Run a compensator in open loop on n samples; return a record of TRACE of each, in force from t[i] on."""
    settings = records.pack([compensator], float((len(t) - 1) / (t[-1] - t[0])))[0]
    memory, seen = records.fresh_memory(1), np.empty((len(t), records.FIELDS), np.int64)
    t, dq, torque = map(read_only, (t, dq, interaction_nm))
    _trace(settings, memory[0], memory.view(np.int64), t, dq, torque, seen)
    return seen.view(records.TRACE)[:, 0]


@compiled()
def hand_ends(cycle: Float, speed: float, dt: float, thresholds: tuple[float, float], moved: bool) -> bool:
    """Return True if the hand has come to rest again, which ends a cycle in which all joints have moved enough."""
    cycle[FILTERED_M_S] += (1.0 - math.exp(-CORNER_RAD_S * dt)) * (speed - cycle[FILTERED_M_S])
    if cycle[FILTERED_M_S] > thresholds[0]:
        cycle[UNDER_WAY] = 1.0
    ends = cycle[UNDER_WAY] == 1.0 and cycle[FILTERED_M_S] <= thresholds[1] and moved
    if ends:
        cycle[UNDER_WAY] = 0.0
    return bool(ends)


@compiled()
def hand_cuts(
    t: Float, speed: Float, dq: Float, thresholds: tuple[float, float], rest_rad_s: float, minimum_path_rad: float
) -> NDArray[np.int64]:
    """Find where a controller would have ended the cycles of all joints: 1 where a cycle ends, else 0, shape (n,).

    Speed of the end effector, shape (n,) [m/s], velocity of every joint, shape (n, j) [rad/s]; the thresholds are the
    hand speeds at which a cycle begins and ends [m/s]. It goes on until every joint has moved the least path, in which
    motion up to the speed of rest does not count.
    """
    cuts = np.zeros(len(t), np.int64)
    cycle = np.zeros(CYCLE_STATE)
    joints = dq.shape[1]
    path, added = np.zeros(joints), np.zeros(joints)
    for i in range(1, len(t)):
        dt = t[i] - t[i - 1]
        for j in range(joints):
            path[j] += added[j]
            a, b = abs(dq[i - 1, j]), abs(dq[i, j])
            added[j] = 0.5 * ((a if a > rest_rad_s else 0.0) + (b if b > rest_rad_s else 0.0)) * dt
        if hand_ends(cycle, speed[i], dt, thresholds, path.min() >= minimum_path_rad):
            cuts[i] = 1
            path[:] = 0.0
            added[:] = 0.0
    return cuts
