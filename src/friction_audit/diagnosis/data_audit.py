"""Faults of the data of one joint, with which no effect may be named, and limits of what the data can show."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from friction_audit.effects.joint_data import SIGMA_PER_MEDIAN, JointData
from friction_audit.joint_log import DERIVATIVE, Bool, Float, JointLog, median_step, step_places
from friction_audit.preprocessing.even_grid import belated_samples, fresh_samples, gaps, times_of_samples
from friction_audit.preprocessing.interaction import Caution, Interaction
from friction_audit.preprocessing.sign import SIGNIFICANT
from friction_audit.preprocessing.torque_source import CHANNELS
from friction_audit.preprocessing.velocity import RESTING_RAD

NAN = float("nan")
MOST_DELAY_S, MOST_DELAY_STEPS = 0.02, 2.0  # of dq after q: larger than any filter's, the torque's clock is not known
# A resolution is found if this share of the changes are whole multiples of the smallest, to this share of it.
MOST_CHANGES, WHOLE = 0.9, 0.01
# Share of the changes of a velocity, of one that is differences of positions; samples on either side that smooth one.
MOST_OF_ITS_OWN, NEAR = 0.05, 5


class _Rule(NamedTuple):
    """Bound of a number, and what it means to break it: ``fault`` or ``limit``."""

    bound: float
    broken: str
    unit: str = ""
    at_most: bool = True


RULES = {
    "batched_stamps": _Rule(0.0, "fault"),
    "clock_jitter": _Rule(0.5, "fault"),
    "holes": _Rule(0.1, "limit"),
    "stale": _Rule(0.3, "limit"),
    "torque_constant": _Rule(0.0, "fault"),
    "dq_constant": _Rule(0.0, "fault"),
    "dq_against_q": _Rule(0.9, "fault", at_most=False),
    "dq_scale": _Rule(0.05, "fault"),
    "dq_delay": _Rule(MOST_DELAY_S, "fault", "s"),
    # Torque against the motion, a score judged as in the proof of the sign: friction only takes energy.
    "power": _Rule(-SIGNIFICANT, "fault", at_most=False),
    "part": _Rule(0.0, "limit", "s"),
    "gravity": _Rule(0.0, "limit"),
    "standstill": _Rule(2.0, "limit", "s", at_most=False),
    "cycles": _Rule(10, "limit", at_most=False),
    "speed_spread": _Rule(0.2, "limit", at_most=False),
    "reversals": _Rule(10, "limit", at_most=False),
}
STATED = {"dq_noise": "rad/s", "standstill_noise": "N m", "torque_step": "N m"}  # units of numbers without a bound


@dataclass(frozen=True, kw_only=True, slots=True)
class DataFinding(Caution):
    """One number about the data and the bound it has to keep; a caution unless the verdict is ``"fine"``."""

    value: float  # the number; NaN where it is not known
    unit: str  # its unit, empty for a share or a count
    bound: float  # its bound; NaN for a number that is only stated
    verdict: str  # ``"fine"``, ``"limit"`` (less can be shown) or ``"fault"`` (no effect may be named)


def audit_data(
    log: JointLog, interaction: Interaction, data: JointData, clock: tuple[DataFinding, ...]
) -> tuple[DataFinding, ...]:
    """Look for faults of one joint's data; those of the log's clock are given."""
    constant, number = _constant_channels(log, interaction, data), interaction.joint_numbers[data.joint]
    signs = [one for one in interaction.choice.sign_evidence if one.joint == number and not np.isnan(one.score)]
    unknown = judged("power", NAN, NAN)
    return (
        *clock,
        *constant,
        *(() if any(one.verdict == "fault" for one in constant[1:]) else _velocity(interaction, data)),
        *([judged("power", one.normal_score, score=one.score, strokes=one.strokes) for one in signs] or [unknown]),
        *_sensors_and_motion(interaction, data),
    )


def judged(code: str, value: float, bound: float | None = None, **numbers: object) -> DataFinding:
    """Compare one number with the bound of its rule, or with another; its sentence takes more numbers."""
    rule = RULES.get(code) or _Rule(NAN, "", STATED[code])
    bound = rule.bound if bound is None else bound
    verdict = rule.broken if (value > bound if rule.at_most else value < bound) else "fine"
    numbers |= {"value": value, "bound": bound}
    return DataFinding(code, numbers=numbers, value=value, unit=rule.unit, bound=bound, verdict=verdict)


def audit_clock(log: JointLog) -> tuple[DataFinding, ...]:
    """Look for faults of a log's stamps and for repeated samples."""
    fresh = fresh_samples(log)
    t, steps = log.t[fresh], (np.diff(log.t), np.diff(log.t[fresh]))
    # Of a motion that is held in a faster log, the times at which it changes are the clock.
    jitter = min(float(np.median(np.abs(step / np.median(step) - 1.0))) for step in steps)
    return (
        judged("batched_stamps", float(sum(one.code == "batched_stamps" for one in log.source.findings))),
        judged("clock_jitter", SIGMA_PER_MEDIAN * jitter),
        judged("holes", float(steps[1][gaps(t)].sum()) / log.duration_s),
        judged("stale", float(np.mean(~fresh)), rate=1.0 / median_step(t)),
    )


def timely_samples(log: JointLog) -> tuple[slice | Bool, Float]:
    """Return which samples are neither repeated nor belated, and their stamps."""
    # With repeated samples effects_stiction_16001 and effects_time_delay_16001 are adequate; with stamps as they are,
    # those and stranger_time_delay_1 and stranger_joint_elasticity_1.
    new = fresh_samples(log)
    fresh = slice(None) if new.all() else new  # views, no copies
    t = times_of_samples(log.t[fresh], log.q[fresh], log.dq[fresh])
    if np.any(belated := belated_samples(t, log.q[fresh], log.dq[fresh])):
        new[new] = ~belated
        return new, t[~belated]
    return fresh, t


def own_velocity(log: JointLog) -> JointLog:
    """The log, with velocities from the positions that are new where the logged ones are differences of all positions.

    Then they show nothing of their own, and a position that is repeated is a velocity of zero: no sample repeats the
    one before. The changes of a velocity with noise of its own are not those of differences of the position.
    """
    step = np.diff(log.t)[:, None]
    slope, n = np.diff(log.q, axis=0) / step, len(log.t)
    for dq, slopes in zip(log.dq.T, slope.T, strict=True):
        change = np.diff(dq[1:-1])
        design = np.diff(np.column_stack([slopes[:-1], slopes[1:]]), axis=0)
        left = change - design @ np.linalg.lstsq(design, change, rcond=None)[0]
        if np.sum(left**2) > MOST_OF_ITS_OWN * np.sum(change**2):
            return log
    # Where no position changes, the sample is a repeated one unless all move by less than two of their smallest steps.
    before, after = np.maximum(np.arange(1, n) - NEAR, 0), np.minimum(np.arange(1, n) + NEAR, n - 1)
    displacement = np.abs(log.q[after] - log.q[before]) * step / (log.t[after] - log.t[before])[:, None]
    size = np.min(np.abs(slope * step), axis=0, where=slope != 0, initial=np.inf)
    new = np.append(True, np.any(slope != 0, axis=1) | np.all(displacement < 2.0 * size, axis=1))
    dq = np.gradient(log.q[new], log.t[new], axis=0)[np.cumsum(new) - 1]
    return replace(log, dq=dq, source=replace(log.source, channels={**log.source.channels, "dq": DERIVATIVE}))


def _constant_channels(log: JointLog, interaction: Interaction, data: JointData) -> tuple[DataFinding, DataFinding]:
    """Channels that hold one number while the joint moves, as after a bus without an answer."""
    channel = CHANNELS[interaction.choice.source]
    torque: Float = getattr(log, channel)[:, data.others.joint]
    q, dq = log.q[:, data.others.joint], log.dq[:, data.others.joint]
    constant, dead = np.ptp(torque) == 0.0, data.others.joint + 1 in log.source.dead_torque  # a few counts of noise
    reads, no_speed = (torque.min(), torque.max()), np.ptp(q) > RESTING_RAD and np.ptp(dq) == 0.0
    return (
        judged("torque_constant", float(data.used.any() and (constant or dead)), reads=reads, channel=channel),
        judged("dq_constant", float(no_speed), reads=dq[0], moved=np.ptp(q)),
    )


def _velocity(interaction: Interaction, data: JointData) -> tuple[DataFinding, ...]:
    """Compare the logged dq with the change of q: dq(t) = scale * (dq/dt of q)(t - delay)."""
    good = data.valid
    q, dq = data.q if data.logged_q is None else data.logged_q, data.dq if data.logged_dq is None else data.logged_dq
    noise = judged("dq_noise", data.dead_speed_rad_s)
    if good.any() and not data.used.any() and np.ptp(data.q[good]) < RESTING_RAD:
        return (noise,)
    slope = np.gradient(q, data.step_s)
    if not good.any() or not np.any(slope[good]):
        return (judged("dq_against_q", 0.0, case="stands"),)
    design = np.column_stack([slope, -np.gradient(slope, data.step_s)])[good]
    fitted = np.linalg.lstsq(design, dq[good], rcond=None)[0]
    left = dq[good] - design @ fitted
    explained = 1.0 - float(left @ left) / power if (power := float(dq[good] @ dq[good])) > 0 else 0.0
    scale, shift = fitted if explained > 0.5 else (NAN, NAN)  # noqa: PLR2004 - columns of two joints
    most_delay = max(MOST_DELAY_S, MOST_DELAY_STEPS * median_step(interaction.t))
    delay = abs(float(shift / scale)) if scale else NAN
    for one in interaction.warnings:  # a delay of another clock is too long for the first term of its series
        if one.code == "dq_other_clock":
            lags = dict(zip(one.numbers["joints"], one.numbers["lags_s"], strict=True))
            delay = lags.get(interaction.joint_numbers[data.joint], delay)
    return (
        judged("dq_against_q", explained, case="moves"),
        judged("dq_scale", abs(float(scale) - 1), case="scaled" if scale > 0 else "turned"),
        judged("dq_delay", delay, most_delay),
        noise,
    )


def resolution(signal: Float) -> float:
    """Return the smallest step that most changes are multiples of; 0 where changes are all different."""
    first = step_places(len(signal))
    steps = np.abs(signal[first + 1] - signal[first])
    steps = steps[steps > 0]
    if len(steps) <= 1:
        return 0.0
    typical = float(np.quantile(steps, 0.05))
    multiples = steps / typical
    return typical if float(np.mean(np.abs(multiples - np.round(multiples)) < WHOLE)) > MOST_CHANGES else 0.0


def _sensors_and_motion(interaction: Interaction, data: JointData) -> tuple[DataFinding, ...]:
    still = (np.abs(data.dq) < data.dead_speed_rad_s) & data.valid
    direction = np.sign(data.dq[data.moving & data.valid])
    steps, speed = np.diff(data.torque)[still[1:] & still[:-1]], np.abs(data.dq[data.used])
    posture = np.zeros((1, 1)) if interaction.posture is None else interaction.posture
    return (
        judged("standstill_noise", float(np.std(steps) / np.sqrt(2)) if len(steps) else NAN),
        judged("torque_step", resolution(interaction.torque[:, data.joint])),
        judged("standstill", float(still.sum()) * data.step_s),
        judged("cycles", float(len(np.unique(data.cycle[data.used])))),
        judged("speed_spread", float(speed.std() / speed.mean()) if len(speed) else 0.0),
        judged("reversals", float(np.count_nonzero(np.diff(direction)))),
        judged("gravity", max(np.count_nonzero(np.ptp(posture, axis=0) > RESTING_RAD) - 1.0, 0.0)),
    )
