"""Interaction -> Subject: torque and motion of each joint through one low-pass, on one even grid, and their audit.

Velocity and acceleration are derivatives of the position where those err less than the logged velocity: drivers log
differences of the position after a filter, some milliseconds late. Elsewhere they, and the position, come from the mean
of both. Position and torque were sampled together; a velocity that lags them would look like a delay.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis import data_audit
from friction_audit.diagnosis.known_load import know_load, known_inertias
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.dynamics.motion import Others
from friction_audit.effects.breakaway import find_breakaways, signed_rest
from friction_audit.effects.joint_data import FEWEST_SAMPLES, JointData, grid_noise
from friction_audit.effects.joint_model import JointModel
from friction_audit.friction.history import Coefficient, FrictionHistory
from friction_audit.joint_log import DERIVATIVE, Bool, Float, Int, JointLog, median_step
from friction_audit.parallel import per_joint
from friction_audit.preprocessing import velocity
from friction_audit.preprocessing.energy_cycles import KEPT, EnergyCycles
from friction_audit.preprocessing.even_grid import MOVING_RAD_S, LowPass
from friction_audit.preprocessing.interaction import Interaction, Reason
from friction_audit.preprocessing.sign import coarse_log
from friction_audit.preprocessing.torque_source import CHANNELS
from friction_audit.robot.arm import Arm

# Parts of a long recording, the bridge from each to the next, and the time in which springs and bristles forget that.
PART_S, BRIDGE_S, FORGOTTEN_S = 60.0, 2.0, 3.0
SHARED = ("q", "dq", "ddq", "sensed")  # of all joints of a log
DEAD_SIGMAS = 5.0  # standard deviations of the filtered velocity's noise, above which the direction is certain
DEAD_SHARE = 1e-3  # and of the usual speed, which is what the stop band lets through next to a standstill
TINY_SPEED = 1e-6
TURN_S = 0.01  # a reversal that takes no longer may leave the direction certain on both sides of it
# Unless the joint rests in it for longer: the median of a log, and a single one, which noise makes uncertain by 1 ms.
MEDIAN_REST_S, REST_S = 1e-3, 3e-3
NEAR_S, FAR_S = 0.008, 0.03  # from a reversal, for straight lines out of the low-pass's reach
PREPARED = 2.0  # times as long as what is diagnosed is a window in which that is spread
WINDOWS = 10  # that are tried per window's length
SMALL = 1e-6  # of the information in the whole log: of a joint without any in a window


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Subject:
    """A joint to diagnose."""

    data: JointData  # the joint on the fine grid
    number: int  # number for people
    name: str
    findings: tuple[data_audit.DataFinding, ...]  # what the audit of its data found
    from_energy: dict[str, Coefficient]  # what the energy method says of it
    model: JointModel | None = None  # its nominal model, None for the simple one
    known_inertia_kg_m2: float = 0.0  # inertia whose torque a rigid-body model took out of the log
    lacking: Reason = ()  # why the energy method has no estimate; empty where it has one


def prepare(
    interaction: Interaction, cycles: Sequence[EnergyCycles], log: JointLog, arm: Arm | None = None
) -> tuple[JointData, ...]:
    """Bring every joint of an interaction onto an even grid, in the order of its columns.

    The log is that which the interaction was made from, in the same window, with all its joints.
    """
    choice, log = interaction.choice, data_audit.own_velocity(log)
    fresh, t = data_audit.timely_samples(log)
    low_pass = LowPass.for_stamps(t)
    valid = low_pass.away_from_gaps(t)
    # Standard deviation of the slope of a low-passed signal over that of its white noise. [1/s]
    slope_gain = float(np.linalg.norm(low_pass.slope) * np.sqrt(median_step(t) / (low_pass.fine[1] - low_pass.fine[0])))
    (all_q, all_dq, all_ddq, logged_dq), sources = _filtered_motion(log, low_pass, t, fresh, valid, slope_gain)
    weighing = (np.ptp(all_q, axis=0) > velocity.RESTING_RAD) & (choice.gravity == "in-torque")  # joints, shape (j,)
    sensed = choice.sign * low_pass.all_of(t, getattr(log, CHANNELS[choice.source]), fresh)
    logged = None if log.gravity is None else low_pass.all_of(t, log.gravity, fresh)
    load, removed, rigid = know_load(choice, arm, low_pass.t, (all_q, all_dq, all_ddq), logged)

    def one(joint: int) -> JointData:
        column = interaction.joint_numbers[joint] - 1
        derived_from, crossover_hz, rounding, noise_density = sources[column]
        if removed is None:
            torque = low_pass.of(t, interaction.torque[fresh, joint])
        else:
            # The inertial torque in the interaction torque ends at 10 Hz: what a reversal leaves above would look like
            # friction. That of the motion on the grid holds all that the sensor saw.
            torque = sensed[:, column] - removed[:, column]
        if interaction.compensation is not None:
            torque = torque + low_pass.of(t, interaction.compensation[fresh, joint])
        # Copies: columns of a matrix of all joints are read at an eighth of the speed.
        q, own_dq = (np.ascontiguousarray(every[:, column]) for every in (all_q, all_dq))
        logged_q = None if derived_from == "q" else q
        usual = float(np.quantile(np.abs(own_dq[valid]), 0.95)) if valid.any() else 0.0
        noise = max(grid_noise(own_dq[valid]), rounding * (slope_gain if derived_from == "q" else 1.0))
        dead = max(DEAD_SIGMAS * noise, DEAD_SHARE * usual, TINY_SPEED)
        breakaways = find_breakaways(q, own_dq, dead, low_pass.step_s)
        dq, ddq = signed_rest(own_dq, all_ddq[:, column], breakaways, dead)
        if logged_q is not None:
            q = velocity.position_of(q, own_dq, all_ddq[:, column], valid, low_pass.step_s, crossover_hz)
        cycle = np.searchsorted(cycles[joint].start_s, low_pass.t, side="right") - 1  # the latest that has begun
        return JointData(
            joint=joint,
            t=low_pass.t,
            q=q,
            dq=dq,
            ddq=ddq,
            torque=torque,
            temperature=None if log.temperature is None else low_pass.of(t, log.temperature[fresh, column]),
            others=Others(joint=column, q=all_q, dq=all_dq, ddq=all_ddq, sensed=sensed),
            cycle=np.where(low_pass.t < np.append(cycles[joint].stop_s, -np.inf)[cycle], cycle, -1),
            moving=certain_direction(own_dq, dead, low_pass.step_s),
            valid=valid,
            dead_speed_rad_s=dead,
            derived_from=derived_from,
            logged_q=logged_q,
            logged_dq=logged_dq[:, column],
            load=None if load is None else np.ascontiguousarray(load[:, column]),
            weighs=bool(weighing[column]) and removed is None,
            unknown_gravity=bool(weighing.sum() > weighing[column]),
            rigid=None if rigid is None else rigid[column],
            sample_s=median_step(log.t),
            rounding=rounding,
            crossover_hz=crossover_hz,
            noise_density=noise_density,
        )

    return tuple(per_joint(one, len(interaction.joint_numbers)))


def parts_of(whole_s: float, most_s: float) -> int:
    """Return in how many parts a recording is diagnosed: one where it is hardly longer than all of them may be."""
    many = max(round(most_s / PART_S), 2)
    return many if whole_s > most_s + many * BRIDGE_S else 1


def spread_parts(data: JointData, most_s: float, known: dict[str, Any]) -> JointData:
    """Return so much of a longer recording, in parts that are spread over it evenly from its first sample to its last.

    A window would lose slow effects. From one part to the next the joint moves on along a cubic; that, what follows
    right after it and cycles that are not whole do not count. What all joints share is kept in ``known`` for the next.
    """
    if (many := parts_of(float(np.ptp(data.t)), most_s)) == 1:
        return data
    rigid = data.rigid
    # The model of the arm is evaluated at every so many samples, of which each part begins with one.
    every = 1 if rigid is None else round((rigid.t[1] - rigid.t[0]) / data.step_s)
    lengths_s = (most_s / many, BRIDGE_S, FORGOTTEN_S)
    length, gap, forgotten = (every * max(round(one / data.step_s / every), 1) for one in lengths_s)
    starts = every * np.linspace(0, (len(data.t) - length) // every, many).astype(int)

    def joined(values: NDArray[Any], each: int = 1, bridges: Float | None = None) -> NDArray[Any]:
        """Parts of values at every so many samples, shape (n, ...); straight lines between them, or bridges."""
        inside = values[starts[:, None] // each + np.arange(length // each)]
        if bridges is None:
            rise = np.linspace(0.0, 1.0, gap // each + 2)[1:-1].reshape(-1, *[1] * (values.ndim - 1))
            bridges = inside[:-1, -1:] + rise * (inside[1:, :1] - inside[:-1, -1:])
        front = np.concatenate([inside[:-1], bridges], axis=1).reshape(-1, *values.shape[1:])
        return np.concatenate([front, inside[-1]]).astype(values.dtype)

    inside = np.zeros(len(data.t), bool)
    for start in starts.tolist():
        inside[start + (forgotten if start else 0) : start + length] = True
    counts = joined(inside.astype(np.float64)) == 1.0
    whole = np.where(np.isin(data.cycle, data.cycle[~inside]), -1, data.cycle)
    if not known:
        known |= {"t": joined(data.t)} | {name: joined(getattr(data.others, name)) for name in SHARED}
    own = {name: getattr(data, name) for name in ("torque", "load", "temperature", "logged_q")}
    changed: dict[str, Any] = {name: None if one is None else joined(one) for name, one in own.items()}
    if rigid is not None:
        model = {name: getattr(rigid, name) for name in ("t", "weight", "tilt", "inertial", "tip")}
        model = {name: None if own is None else joined(own, every) for name, own in model.items()}
        changed["rigid"] = replace(rigid, **model)
    for name, bridge in zip(("q", "dq", "ddq"), _cubics(data, starts[:-1] + length - 1, starts[1:], gap), strict=True):
        changed[name] = joined(getattr(data, name), 1, bridge)
    return replace(
        data,
        cycle=np.where(counts, joined(whole), -1),
        moving=joined(data.moving.astype(np.float64)) == 1.0,
        valid=counts & (joined(data.valid.astype(np.float64)) == 1.0),
        t=known["t"],
        others=replace(data.others, **{name: known[name] for name in SHARED}),
        **changed,
    )


def _cubics(data: JointData, end: Int, begin: Int, samples: int) -> tuple[Float, Float, Float]:
    """Position, velocity and acceleration at samples between the ends of parts and the next begins, (k, samples)."""
    x, time_s = np.linspace(0.0, 1.0, samples + 2)[1:-1], (samples + 1) * data.step_s
    rise, first, last = data.q[begin] - data.q[end], time_s * data.dq[end], time_s * data.dq[begin]
    three, two, one = (each[:, None] for each in (first + last - 2.0 * rise, 3.0 * rise - 2.0 * first - last, first))
    q = ((three * x + two) * x + one) * x + data.q[end][:, None]
    return q, ((3.0 * three * x + 2.0 * two) * x + one) / time_s, (6.0 * three * x + 2.0 * two) / time_s**2


def _filtered_motion(
    log: JointLog, low_pass: LowPass, t: Float, fresh: Bool | slice, valid: Bool, slope_gain: float
) -> tuple[list[Float], list[tuple[str, float, float, float]]]:
    """Position, velocity, acceleration, logged velocity, (n, j) each; per joint source, crossover, rounding, noise.

    The noise of rounding is step / sqrt(12), and white (W. R. Bennett, Bell Syst. Tech. J. 27 (1948) 446). Most samples
    of a slow joint read the same, and a median shows none of it.
    """
    coarse = coarse_log(log)
    lag = velocity.find_lag(coarse, median_step(log.t))
    acceleration = np.sqrt(np.mean(np.gradient(coarse.dq, coarse.t, axis=0) ** 2, axis=0))

    # One array each, not a list of columns that is stacked: half of the memory.
    many = log.q.shape[1]
    moved = [np.empty((len(low_pass.t), many)) for _ in range(4)]

    def one(column: int) -> tuple[str, float, float, float]:
        q, slope = low_pass.with_slope(t, log.q[fresh, column])
        logged = low_pass.of(t, log.dq[fresh, column])
        derived = log.source.channels.get("dq") == DERIVATIVE
        of_q, of_dq = (data_audit.resolution(read[:, column]) / 12.0**0.5 for read in (log.q, log.dq))
        # The noise of a position by late or uneven stamps grows with the speed: rests, where they prevail, hide it.
        moves = np.abs(logged) > MOVING_RAD_S
        seen = moves if FEWEST_SAMPLES < np.count_nonzero(moves) < 0.5 * len(moves) else slice(None)
        apart = velocity.noise_of_both(slope, logged, valid, low_pass.step_s, lag[column])
        white = apart * (slope_gain / np.sqrt(2.0 * median_step(log.t)), np.sqrt(low_pass.corner_hz))
        of_slope = max(grid_noise(slope[seen]), slope_gain * of_q, white[0])
        of_logged = np.hypot(max(grid_noise(logged[seen]), of_dq, white[1]), lag[column] * acceleration[column])
        source, crossover_hz = "q" if derived or of_slope < of_logged else "dq", 0.0
        if source == "q":
            dq, ddq = slope, np.gradient(slope, low_pass.t)
        else:
            dq, ddq = low_pass.with_slope(t - lag[column], log.dq[fresh, column])
            # With the logged velocity alone the inertial_coupling of a real Panda's joints 5 and 6 is ambiguous.
            if crossover_hz := velocity.crossover_of(slope[seen], dq[seen], low_pass.step_s, apart):
                dq = velocity.complementary_mean(slope, dq, valid, low_pass.step_s, crossover_hz)
                ddq = np.gradient(dq, low_pass.t)
        for every, own in zip(moved, (q, dq, ddq, logged), strict=True):
            every[:, column] = own
        return source, crossover_hz, *((of_q, apart[0]) if source == "q" else (of_dq, apart[1]))

    return moved, per_joint(one, many)


def certain_direction(dq: Float, dead_speed: float, step_s: float) -> Bool:
    """Samples whose direction of motion is certain, those of a quick reversal without a rest among them, shape (n,).

    A joint that its motor turns around rests until the torque has changed by twice the friction: some milliseconds of
    static friction, which a filtered velocity does not show. Straight lines through the velocity before and after the
    reversal do: they reach zero at different times. Without these samples effects_stiction_16001 is adequate.
    """
    sure = np.abs(dq) > dead_speed
    at = np.flatnonzero(sure)
    turns = np.flatnonzero(dq[at[1:]] * dq[at[:-1]] < 0)
    last, first = at[turns], at[turns + 1]
    quick = (first - last - 1) * step_s <= TURN_S
    rest = _rest_in_reversals(dq, last[quick], first[quick], step_s)
    joint_rests = bool(len(rest)) and float(np.median(rest)) > MEDIAN_REST_S
    for begin, end, one in zip(last[quick], first[quick], rest, strict=True):
        sure[begin : end + 1] = not joint_rests and one <= REST_S
    return np.asarray(sure, bool)


def _rest_in_reversals(dq: Float, last: Int, first: Int, step_s: float) -> Float:
    """Time between the zeros of straight lines through the velocity before and after reversals, shape (r,). [s]

    Acceleration that changes steadily moves both zeros alike. Infinite where the joint turns again.
    """
    near = round(NEAR_S / step_s)
    away = np.arange(near, max(round(FAR_S / step_s), near + 2) + 1)
    before, after = last[:, None] - away, first[:, None] + away
    whole = (before[:, -1] >= 0) & (after[:, -1] < len(dq))
    v_before, v_after = dq[np.maximum(before, 0)], dq[np.minimum(after, len(dq) - 1)]
    whole &= np.all(v_before * dq[last][:, None] > 0, axis=1) & np.all(v_after * dq[first][:, None] > 0, axis=1)
    into, out = _time_to_zero(v_before, away), _time_to_zero(v_after, away)
    whole &= np.isfinite(into) & np.isfinite(out)
    return np.where(whole, (first - last - into - out) * step_s, np.inf)


def _time_to_zero(v: Float, away: Int) -> Float:
    """Samples from 0 at which a straight line through velocities v, shape (r, k), reaches zero, shape (r,)."""
    centre = away - away.mean()
    slope = v @ centre / (centre @ centre)
    level = v.mean(axis=1)
    distance = np.full(len(slope), np.inf)
    np.divide(level, slope, out=distance, where=slope * level > 0)
    return np.asarray(distance - float(away.mean()))


def best_window(cycles: Sequence[EnergyCycles], duration_s: float, length_s: float) -> tuple[float, float]:
    """Return the window in which the cycles determine both coefficients of all joints best: D-optimality. [s]"""
    kept = [
        (own.start_s[used], own.stop_s[used], np.column_stack([own.sums.path_rad, own.sums.square_speed_rad2_s])[used])
        for own in cycles
        if (used := own.reason == KEPT).any()
    ]

    def information(start: float) -> float:
        inside = ((rows, rows[(begin >= start) & (end <= start + length_s)]) for begin, end, rows in kept)
        return float(sum(np.linalg.slogdet(part.T @ part + SMALL * (rows.T @ rows))[1] for rows, part in inside))

    starts = np.linspace(0.0, duration_s - length_s, int(WINDOWS * duration_s / length_s))
    start = max(starts.tolist(), key=information)
    return start, start + length_s


def subjects_of(
    log: JointLog,
    interaction: Interaction,
    cycles: Sequence[EnergyCycles],
    friction: FrictionHistory,
    settings: DiagnosisSettings,
    arm: Arm | None = None,
) -> tuple[Subject, ...]:
    """Prepare every joint of a log in the window of its interaction; of its samples nothing is needed afterwards."""
    inertias, subjects = known_inertias(arm, interaction.choice, log.q), []
    clock, prepared = data_audit.audit_clock(log), [*prepare(interaction, cycles, log, arm)]
    joined: dict[str, Any] = {}
    for findings in per_joint(lambda k: data_audit.audit_data(log, interaction, prepared[k], clock), len(prepared)):
        # The audit alone has looked at the logged velocity; of a long log, the rest is freed at once.
        data = spread_parts(replace(prepared.pop(0), logged_dq=None), settings.at_most_s, joined)
        number, found = interaction.joint_numbers[data.joint], friction.joints[data.joint]
        subjects.append(
            Subject(
                data=data,
                number=number,
                name=interaction.joint_names[data.joint],
                findings=findings,
                from_energy={"coulomb_nm": found.coulomb, "viscous_nms_per_rad": found.viscous},
                model=None if settings.model is None else settings.model.joints[number - 1],
                known_inertia_kg_m2=float(inertias[number - 1]),
                lacking=found.reason or found.no_energy,
            )
        )
    return tuple(subjects)
