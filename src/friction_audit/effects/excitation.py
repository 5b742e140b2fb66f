"""What a log must hold for an effect to be identifiable: None, or one sentence that names the motion it lacks."""

import numpy as np

from friction_audit.effects.joint_data import JointData, Nominal, strokes

FEWEST_SAMPLES = 100
FEWEST_REVERSALS = 8
# A neighbour's torque must change by so much of this joint's Coulomb friction before a few percent of it are seen.
CHANGE_PER_COULOMB = 0.5


def moves(data: JointData, _nominal: Nominal) -> str | None:
    """Some motion at all."""
    if int(data.used.sum()) < FEWEST_SAMPLES:
        return "hardly any motion: move back and forth for several cycles"
    return None


def both_directions(data: JointData, nominal: Nominal) -> str | None:
    """At least a tenth of the moving time in either direction."""
    share = float(np.mean(data.dq[data.used] > 0)) if data.used.any() else 0.0
    if not 0.1 <= share <= 0.9:  # noqa: PLR2004 - a tenth either way
        return moves(data, nominal) or "motion in one direction only: move over the same range both ways"
    return moves(data, nominal)


def speed_range(data: JointData, nominal: Nominal, ratio: float) -> str | None:
    """95th over 5th percentile of speed at least the ratio."""
    lacking = moves(data, nominal)
    if lacking:
        return lacking
    slow, fast = np.percentile(np.abs(data.dq[data.used]), [5, 95])
    if fast < ratio * slow:
        return f"the speed varies by a factor of {fast / slow:.1f}: vary it by at least {ratio:g}, slow to fast"
    return None


def several_speeds(data: JointData, nominal: Nominal) -> str | None:
    """Peak speeds of the cycles that differ by a tenth: one sinusoid cannot separate delay and inertia from others."""
    lacking = moves(data, nominal)
    if lacking:
        return lacking
    cycle, speed = data.cycle[data.used], np.abs(data.dq[data.used])
    peak = np.zeros(int(cycle.max()) + 1)
    np.maximum.at(peak, cycle, speed)
    peak = peak[np.unique(cycle)]
    if peak.std() < 0.1 * peak.mean():
        return "all motions are equally fast: repeat them at two or more clearly different speeds"
    return None


def span(data: JointData, nominal: Nominal, least_rad: float) -> str | None:
    """Range of positions of the moving joint at least so many radians."""
    lacking = moves(data, nominal)
    if lacking:
        return lacking
    reach = float(np.ptp(data.q[data.used]))
    if reach < least_rad:
        return f"the joint spans {reach:.2f} rad: move it over at least {least_rad:g} rad"
    return None


def reversals(data: JointData, nominal: Nominal) -> str | None:
    """Reversals among the working cycles and among the locked ones."""
    found = len(strokes(data).reversals)
    if found < FEWEST_REVERSALS:
        turn = f"turn the direction of motion at least {FEWEST_REVERSALS} times"
        return moves(data, nominal) or f"{found} reversals: {turn}"
    return moves(data, nominal)


def neighbours_move(data: JointData, _nominal: Nominal) -> str | None:
    """Another joint that moves."""
    other = np.delete(data.others_dq[data.valid], data.own_column, axis=1)
    if other.size == 0 or np.sqrt(np.mean(other**2, axis=0)).max() < data.dead_speed_rad_s:
        return "no other joint moves: move the neighbours, also while this joint rests"
    return None


def neighbours_loaded(data: JointData, nominal: Nominal) -> str | None:
    """A neighbour whose sensor reads something that changes."""
    joint, joints = data.own_column, data.others_torque.shape[1]
    neighbours = [k for k in (joint - 1, joint + 1) if 0 <= k < joints]
    if not neighbours:
        return "the log has one joint: record its neighbours too"
    lacking = moves(data, nominal)
    if lacking:
        return lacking
    change = data.others_torque[data.used][:, neighbours].std(axis=0).max()
    if change < CHANGE_PER_COULOMB * abs(nominal.coulomb_nm):
        return "the torque of the neighbours hardly changes: load them, also while this joint rests"
    return None
