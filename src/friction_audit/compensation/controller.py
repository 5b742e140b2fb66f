"""One tick of a compensator, compiled; the loops of the simulation and of the replay call ``step``.

The joint on the motor side of its torque sensor obeys B ddq = F_m + u - tau_f. Over a cycle from rest to rest the
kinetic energy cancels: sum F_m dq + sum u dq = sum tau_f dq. The general form of (10), (13), (16) and (25) is therefore
E_net = E_n - E_(n-1) + sum u dq with the whole torque u; the work of its passivity part is negative.
"""

import math

import numpy as np

from friction_audit.compensation import competitors, law, records
from friction_audit.compensation.competitors import Compensator
from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float, Int, read_only

EPSILON = 4.0 * 2.0**-52  # a relative determinant up to this is zero within rounding
DETECT = -1  # value of ``cycle_end``: the joint detects its cycles itself

# Cycles that the hand of an arm ends for all joints at once (paper, section V.B).
HAND_SPEED_M_S, IN_CYCLE, HAND_STATES = range(3)  # its state: filtered speed, 1 while a cycle goes on; their number
HAND_THRESHOLDS_M_S = (0.1, 0.025)  # hand speeds at which a cycle begins and ends
HAND_CORNER_RAD_S = 2.0 * math.pi * 20.0  # of the low-pass on the hand's speed

SPEED_BOUND_RAD_S, TORQUE_BOUND_NM = 100.0, 1e4  # beyond all arms with torque sensors: the loop has diverged
# Consecutive ticks at which a torque at its limit changes direction: only the limits bound such a loop, which counts as
# diverged. Noise reaches three or four ticks, a hand one.
MOST_REVERSALS = 50
# A longer hole in the log adds no energy, and a joint in a closed loop starts again from the recording after it. [s]
HOLE_S = 1.0


@compiled()
def step(settings: Record, state: Record, dq: float, interaction_nm: float, dt: float, cycle_end: int) -> float:
    """Run a compensator for one tick, after the sensors were read; return its torque u for the coming tick. [N m]

    The records are those of SETTINGS and STATE; the state is updated. F_m was measured while the torque of the previous
    call acted, dt seconds ago. ``cycle_end`` is DETECT, or 1 if a cycle ends at this tick and 0 if not.
    """
    # The comparisons are also false for NaN.
    invalid = not abs(dq) <= SPEED_BOUND_RAD_S or not abs(interaction_nm) <= TORQUE_BOUND_NM
    if state.unstable == 1 or invalid:
        return float(switch_off(state))
    if state.ticks > 0:
        integrate_energies(settings, state, dq, interaction_nm, dt)
    update_law(settings, state, dq, interaction_nm, dt)
    state.ticks += 1
    state.dq = dq
    state.interaction_nm = interaction_nm
    detected = detect_cycle_end(settings, state, dq, dt)
    if (detected if cycle_end == DETECT else cycle_end == 1) and state.ticks > 1:
        end_cycle(settings, state)
    select_coefficients(settings, state)
    state.observed_energy_j = settings.initial_energy_j + state.energy_j  # passivity observer (21)
    u = command(settings, state, dq)
    if not abs(u) <= TORQUE_BOUND_NM or state.reversals >= MOST_REVERSALS:
        state.ticks -= 1
        return float(switch_off(state))
    return float(u)


@compiled()
def switch_off(state: Record) -> float:
    """Command no torque from now on: the loop has diverged."""
    state.unstable = 1
    state.ticks += 1
    state.u_nm = state.compensation_nm = state.passivity_nm = state.limited_nm = state.damping_nms_per_rad = 0.0
    return 0.0


@compiled(inline=True)
def update_law(settings: Record, state: Record, dq: float, interaction_nm: float, dt: float) -> None:
    """Integrate the states of the compensation law (bristles, observer, filter) over the interval before this tick."""
    if settings.kind == law.LUGRE and state.ticks > 0:
        competitors.update_bristles(settings.lugre, state, dq, dt)
    elif settings.kind == law.DISTURBANCE_OBSERVER and state.ticks > 0:
        competitors.update_observer(settings.disturbance_observer, state, dq, interaction_nm, dt)
    elif settings.kind == law.TORQUE_REGULATION:
        # The low-pass starts at the first torque.
        gain = 1.0 if state.ticks == 0 else -math.expm1(-2.0 * math.pi * settings.torque_regulation.cutoff_hz * dt)
        state.filtered_interaction_nm += gain * (interaction_nm - state.filtered_interaction_nm)


@compiled(inline=True)
def moving_speed(dq: float, rest_rad_s: float) -> float:
    """Return the speed that counts for the path of a cycle: zero up to the speed of rest. [rad/s]"""
    return abs(dq) if abs(dq) > rest_rad_s else 0.0


@compiled(inline=True)
def integrate_energies(settings: Record, state: Record, dq: float, interaction_nm: float, dt: float) -> None:
    """Add the interval before this tick to the sums of the cycle and the energies (2), (24): trapezoids, u constant."""
    state.longest_gap_s = max(state.longest_gap_s, dt)
    if dt > HOLE_S:
        return
    moved = 0.5 * (state.dq + dq) * dt
    work = 0.5 * (state.interaction_nm + interaction_nm) * moved
    state.net_j += work + state.u_nm * moved
    before, now = moving_speed(state.dq, settings.rest_rad_s), moving_speed(dq, settings.rest_rad_s)
    state.path_rad += 0.5 * (before + now) * dt
    state.square_rad2_s += 0.5 * (state.dq * state.dq + dq * dq) * dt
    state.energy_j += work
    if state.active == 1:
        state.active_energy_j += work
    state.dissipated_j -= state.passivity_nm * moved


@compiled(inline=True)
def detect_cycle_end(settings: Record, state: Record, dq: float, dt: float) -> bool:
    """Return True if an energy cycle ends at this tick; it began when the filtered speed exceeded its threshold.

    It ends when the filtered speed is below the other threshold and the joint rests by its measured velocity.
    """
    gain = 1.0 if state.ticks == 1 else 1.0 - math.exp(-settings.corner_rad_s * dt)
    state.filtered_rad_s += gain * (dq - state.filtered_rad_s)
    direction = state.direction
    ended = (
        direction != 0.0
        and state.filtered_rad_s * direction < settings.termination_rad_s
        and dq * direction <= settings.rest_rad_s
    )
    if ended:
        state.direction = 0.0
    if state.direction == 0.0 and abs(state.filtered_rad_s) > settings.initiation_rad_s:
        state.direction = math.copysign(1.0, state.filtered_rad_s)
    return bool(ended)


@compiled(inline=True)
def end_cycle(settings: Record, state: Record) -> None:
    """End the cycle at this tick, estimate friction, and begin the next cycle."""
    state.cycle += 1
    if state.longest_gap_s > settings.maximum_gap_s:
        state.status = records.GAP
    elif state.path_rad < settings.minimum_path_rad:
        state.status = records.NOT_MOVED
    else:
        sums = state.cycle_sums[state.equations % settings.window]
        sums[records.NET], sums[records.PATH], sums[records.SQUARE] = state.net_j, state.path_rad, state.square_rad2_s
        state.equations += 1
        state.status = estimate_friction(settings, state)
    if state.acted == 1:
        state.passivity_acted = 1
    state.acted = 0
    state.net_j = state.path_rad = state.square_rad2_s = state.longest_gap_s = 0.0


@compiled(inline=True)
def estimate_friction(settings: Record, state: Record) -> int:
    """Estimate from the last k cycles: viscous (8), (11), (25), Coulomb (14), combined (20); return the status.

    (19) prints the right pseudo-inverse of a tall matrix, which does not exist for k > 2; this is the left one.
    """
    if state.equations < settings.window:
        return records.TOO_FEW
    net_path = net_square = path_path = path_square = square_square = 0.0
    for i in range(settings.window):
        sums = state.cycle_sums[i]
        net, path, square = sums[records.NET], sums[records.PATH], sums[records.SQUARE]
        net_path += net * path
        net_square += net * square
        path_path += path * path
        path_square += path * square
        square_square += square * square
    coulomb = viscous = 0.0
    if settings.model == records.VISCOUS:
        viscous = state.estimated_viscous_nms_per_rad = net_square / square_square
    elif settings.model == records.COULOMB:
        coulomb = state.estimated_coulomb_nm = net_path / path_path
    else:
        # Ridge regression towards the coefficients in use: two cycles of one speed determine only the sum of both.
        path_weight, square_weight = settings.ridge * path_path, settings.ridge * square_square
        net_path += path_weight * state.usable_coulomb_nm
        net_square += square_weight * state.usable_viscous_nms_per_rad
        path_path, square_square = path_path + path_weight, square_square + square_weight
        determinant = path_path * square_square - path_square * path_square
        if determinant <= EPSILON * path_path * square_square:  # rank one: solve by the pseudo-inverse
            coulomb = (path_path * net_path + path_square * net_square) / (path_path + square_square) ** 2
            viscous = (path_square * net_path + square_square * net_square) / (path_path + square_square) ** 2
        else:
            coulomb = (square_square * net_path - path_square * net_square) / determinant
            viscous = (path_path * net_square - path_square * net_path) / determinant
        state.estimated_coulomb_nm, state.estimated_viscous_nms_per_rad = coulomb, viscous
        # Non-negative least squares: where one coefficient is negative, fit the other one alone.
        if settings.ridge > 0.0 and coulomb < 0.0:
            coulomb, viscous = 0.0, net_square / square_square
        elif settings.ridge > 0.0 and viscous < 0.0:
            coulomb, viscous = net_path / path_path, 0.0
    # Friction is dissipative: a negative estimate is reported and not applied.
    state.usable_coulomb_nm, state.usable_viscous_nms_per_rad = max(0.0, coulomb), max(0.0, viscous)
    return records.ESTIMATED


@compiled(inline=True)
def select_coefficients(settings: Record, state: Record) -> None:
    """Select the coefficients to apply: fixed, forced or estimated."""
    coulomb = viscous = 0.0
    if settings.kind == law.FIXED:
        coulomb, viscous = settings.fixed.coulomb_nm, settings.fixed.viscous_nms_per_rad
    elif settings.kind == law.ENERGY:
        forced = not math.isnan(settings.forced_coulomb_nm) and state.cycle + 1 >= settings.forced_from_cycle
        if forced and not (settings.forced_until_acted == 1 and state.passivity_acted == 1):
            coulomb, viscous = settings.forced_coulomb_nm, settings.forced_viscous_nms_per_rad
        else:
            coulomb = settings.factor * state.usable_coulomb_nm
            viscous = settings.factor * state.usable_viscous_nms_per_rad
    state.coulomb_nm, state.viscous_nms_per_rad = coulomb, viscous
    if coulomb != 0.0 or viscous != 0.0 or settings.kind > law.ENERGY:
        state.active = 1


@compiled(inline=True)
def law_torque(settings: Record, state: Record, dq: float) -> float:  # noqa: PLR0911 - one per kind
    """Return the torque of the compensation law, before passivity controller and limits. [N m]"""
    if settings.kind == law.FIXED:
        share = 1.0 if abs(dq) > settings.fixed.dead_band_rad_s else 0.0
        return float(share * (state.coulomb_nm * math.copysign(1.0, dq) + state.viscous_nms_per_rad * dq))
    if settings.kind == law.ENERGY:  # (9) with the sign that Figs 6 and 10 need
        sign = law.soft_sign(dq, settings.dead_band_rad_s, settings.ramp_rad_s)
        return float(state.coulomb_nm * sign + state.viscous_nms_per_rad * dq)
    if settings.kind == law.SIGMOID:
        return float(competitors.sigmoid_nm(settings.sigmoid, dq))
    if settings.kind == law.LUGRE:
        return float(competitors.lugre_nm(settings.lugre, state, dq))
    if settings.kind == law.DISTURBANCE_OBSERVER:
        return float(competitors.observer_nm(settings.disturbance_observer, state, dq))
    if settings.kind == law.TORQUE_REGULATION:
        ratio = settings.torque_regulation.inertia_kg_m2 / settings.torque_regulation.desired_inertia_kg_m2
        return float((ratio - 1.0) * state.filtered_interaction_nm)
    if settings.kind == law.JOINT_MODEL:
        sign = law.soft_sign(dq, settings.joint_model.dead_band_rad_s, settings.joint_model.ramp_rad_s)
        return float(sign * state.modelled_nm + state.bristle_nm)
    return 0.0


@compiled(inline=True)
def passivity_damping(settings: Record, state: Record, dq: float) -> float:
    """Return the damping alpha of the passivity controller. [N m s/rad]

    (22) dissipates the energy deficit within a tick; here it is dissipated over a horizon, and alpha has a limit.
    """
    deficit = -state.observed_energy_j
    if settings.passivity == 0 or deficit <= 0.0 or abs(dq) < settings.minimum_speed_rad_s:
        return 0.0
    horizon = max(settings.period_s, settings.payback_s)
    return float(min(deficit / (dq * dq * horizon), settings.max_damping_nms_per_rad))


@compiled(inline=True)
def command(settings: Record, state: Record, dq: float) -> float:
    """Return the torque for the coming tick within the limits, and store its parts in the state. [N m]"""
    compensation, alpha = law_torque(settings, state, dq), passivity_damping(settings, state, dq)
    wanted = compensation - alpha * dq
    # Only the sum is limited: a rate limit on the law alone, around the last sum, would wind up while alpha acts.
    step_nm = settings.max_torque_rate_nm_s * settings.period_s
    low, high = max(-settings.max_torque_nm, state.u_nm - step_nm), min(settings.max_torque_nm, state.u_nm + step_nm)
    u = min(max(wanted, low), high)
    change = u - state.u_nm
    state.reversals = state.reversals + 1 if u != wanted and change * state.last_change_nm < 0.0 else 0
    state.last_change_nm = change
    state.u_nm, state.compensation_nm, state.passivity_nm, state.limited_nm = u, compensation, -alpha * dq, u - wanted
    state.damping_nms_per_rad = alpha
    if alpha > 0.0:
        state.acted = 1
    return float(u)


@compiled()
def _trace(settings: Record, state: Record, words: Record, t: Float, dq: Float, torque: Float, trace: Record) -> None:
    """Run a compensator over n samples, and copy the first words of its state after each."""
    # ``int``: for a constant as such, numba compiles the compensator once more.
    for i in range(len(t)):
        step(settings, state, dq[i], torque[i], t[i] - t[max(i - 1, 0)], int(DETECT))
        for k in range(trace.shape[1]):  # one by one: for a slice, numba compiles a message for seconds
            trace[i, k] = words[k]


def run(
    compensator: Compensator | None, t: Float, dq: Float, interaction_nm: Float
) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    """Run a compensator in open loop on n samples; return a record of TRACE of each, in force from t[i] on."""
    settings = records.settings_records([compensator], float((len(t) - 1) / (t[-1] - t[0])))[0]
    state, trace = records.initial_states(1), np.empty((len(t), records.FIELDS), np.int64)
    t, dq, torque = map(read_only, (t, dq, interaction_nm))
    _trace(settings, state[0], state.view(np.int64), t, dq, torque, trace)
    return trace.view(records.TRACE)[:, 0]


@compiled()
def hand_cycle_ends(hand: Float, speed: float, dt: float, thresholds: tuple[float, float], moved: bool) -> bool:
    """Return True if the hand has come to rest, which ends a cycle in which all joints moved; update its state."""
    hand[HAND_SPEED_M_S] += (1.0 - math.exp(-HAND_CORNER_RAD_S * dt)) * (speed - hand[HAND_SPEED_M_S])
    if hand[HAND_SPEED_M_S] > thresholds[0]:
        hand[IN_CYCLE] = 1.0
    ends = hand[IN_CYCLE] == 1.0 and hand[HAND_SPEED_M_S] <= thresholds[1] and moved
    if ends:
        hand[IN_CYCLE] = 0.0
    return bool(ends)


@compiled()
def detect_hand_cycles(
    t: Float, speed: Float, dq: Float, thresholds: tuple[float, float], rest_rad_s: float, minimum_path_rad: float
) -> Int:
    """Return where a controller would have ended the cycles of all joints: 1 where a cycle ends, else 0, shape (n,).

    Speed of the end effector, shape (n,) [m/s], velocity of every joint, shape (n, j) [rad/s]; the thresholds are the
    hand speeds at which a cycle begins and ends [m/s]. A cycle goes on until every joint has moved the minimum path;
    motion up to the speed of rest does not count.
    """
    cycle_ends, hand = np.zeros(len(t), np.int64), np.zeros(HAND_STATES)
    joints = dq.shape[1]
    path, added = np.zeros(joints), np.zeros(joints)
    for i in range(1, len(t)):
        dt = t[i] - t[i - 1]
        for j in range(joints):
            path[j] += added[j]
            added[j] = 0.5 * (moving_speed(dq[i - 1, j], rest_rad_s) + moving_speed(dq[i, j], rest_rad_s)) * dt
        if hand_cycle_ends(hand, speed[i], dt, thresholds, path.min() >= minimum_path_rad):
            cycle_ends[i] = 1
            path[:] = 0.0
            added[:] = 0.0
    return cycle_ends
