"""Faults of the data on which nothing may be named, and limits of what the data can tell."""

from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.prepare import fresh_samples, holes
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float, JointLog, median_step
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.sign import SIGNIFICANT
from friction_audit.preprocessing.torque_source import CHANNELS

MOST_JITTER = 0.5
MOST_HOLES = 0.1
MOST_STALE = 0.3
MOST_SCALE_ERROR = 0.05
MOST_DELAY_S = 0.02
LEAST_SHARE_EXPLAINED = 0.9
FEWEST_CYCLES = 10
LEAST_SPEED_SPREAD = 0.2
FEWEST_REVERSALS = 10
STANDSTILL_S = 2.0
SIGMA_PER_MEDIAN = 1.4826
RESTING_RAD = 0.05
"""A joint without a cycle whose position stays within this does not move, and velocities are noise."""
WHOLE = 0.01
MOST_CHANGES = 0.9
"""A resolution is seen if so many changes are whole multiples of the smallest, to so much of it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DataFinding:
    """One number about the data, held against what is needed.

    Attributes:
        code: Stable short name.
        value: What was found; NaN where it cannot be told.
        unit: Its unit, empty for a share or a number.
        bound: What it was held against; NaN for a number that is only stated.
        verdict: ``"fine"``, ``"limit"`` (less can be told) or ``"fault"`` (nothing may be named).
        message: One sentence for people; empty where all is fine.
    """

    code: str
    value: float
    unit: str
    bound: float
    verdict: str
    message: str


def audit_data(log: JointLog, interaction: Interaction, data: JointData) -> tuple[DataFinding, ...]:
    """Look for faults of one joint's data.

    Args:
        log: The log, in the window of the interaction.
        interaction: Motion and torque.
        data: The joint on its even grid.
    """
    dead = _dead_channels(log, interaction, data)
    against_q = () if faults(dead[1:]) else _velocity(interaction, data)
    return (
        *_clock(log),
        *dead,
        *against_q,
        _power(interaction, data),
        *_sensors(interaction, data),
        *_excitation(data),
    )


def faults(findings: tuple[DataFinding, ...]) -> tuple[DataFinding, ...]:
    """Return the findings that forbid a name."""
    return tuple(finding for finding in findings if finding.verdict == "fault")


def _judged(
    code: str, value: float, bound: float, message: str, *, unit: str = "", above: bool = True, bad: str = "fault"
) -> DataFinding:
    """Hold a number against a bound that it must not exceed (``above``) or not fall below."""
    broken = value > bound if above else value < bound
    return DataFinding(
        code=code,
        value=value,
        unit=unit,
        bound=bound,
        verdict=bad if broken else "fine",
        message=message.format(value=value, bound=bound) if broken else "",
    )


def _stated(code: str, value: float, unit: str) -> DataFinding:
    return DataFinding(code=code, value=value, unit=unit, bound=float("nan"), verdict="fine", message="")


def _clock(log: JointLog) -> tuple[DataFinding, ...]:
    new = fresh_samples(log)
    t = log.t[new]
    step = np.diff(log.t)
    usual = median_step(log.t)
    jitter = SIGMA_PER_MEDIAN * float(np.median(np.abs(step - usual))) / usual
    lost = float(np.diff(t)[holes(t)].sum()) / log.duration_s
    batched = float(sum(finding.code == "batched_stamps" for finding in log.source.findings))
    return (
        _judged("batched_stamps", batched, 0.0, "samples came in batches: their stamps are guesses, a period wide"),
        _judged("clock_jitter", jitter, MOST_JITTER, "steps of the clock scatter by {value:.0%} of a step"),
        _judged("holes", lost, MOST_HOLES, "{value:.0%} of the time lies in holes", bad="limit"),
        _judged("stale", float(np.mean(~new)), MOST_STALE, "{value:.0%} of the samples repeat the one before"),
    )


def _dead_channels(log: JointLog, interaction: Interaction, data: JointData) -> tuple[DataFinding, DataFinding]:
    """Look for channels that hold one number while the joint moves, as a bus without an answer leaves them."""
    torque: Float = getattr(log, CHANNELS[interaction.choice.source])[:, data.own_column]
    q, dq = log.q[:, data.own_column], log.dq[:, data.own_column]
    no_torque = bool(data.used.any()) and np.ptp(torque) == 0.0
    no_speed = np.ptp(q) > RESTING_RAD and np.ptp(dq) == 0.0
    torque_name, no_answer = CHANNELS[interaction.choice.source], "channel is dead; check the sensor and the bus, or"
    return (
        _judged(
            "torque_constant",
            float(no_torque),
            0.0,
            f"the torque reads {torque[0]:.4g} N m in all samples: the torque {no_answer} "
            f"choose another column with --map {torque_name}=...",
        ),
        _judged(
            "dq_constant",
            float(no_speed),
            0.0,
            f"the velocity reads {dq[0]:.4g} rad/s in all samples while q moves by {np.ptp(q):.3g} rad: the velocity "
            f"{no_answer} choose another column with --map dq=...",
        ),
    )


def _velocity(interaction: Interaction, data: JointData) -> tuple[DataFinding, ...]:
    """Hold the logged dq against the change of q: dq(t) = scale * (dq/dt of q)(t - delay)."""
    good = data.valid
    dq = data.dq if data.logged_dq is None else data.logged_dq
    noise = _stated("dq_noise", data.dead_speed_rad_s, "rad/s")
    if good.any() and not data.used.any() and np.ptp(data.q[good]) < RESTING_RAD:
        return (noise,)
    slope = np.gradient(data.q, data.step_s)
    acceleration = np.gradient(slope, data.step_s)
    if not good.any() or not np.any(slope[good]):
        return (_judged("dq_against_q", 0.0, LEAST_SHARE_EXPLAINED, "the position does not change", above=False),)
    design = np.column_stack([slope, -acceleration])[good]
    scale, shift = np.linalg.lstsq(design, dq[good], rcond=None)[0]
    left = dq[good] - design @ np.array([scale, shift])
    power = float(np.mean(dq[good] ** 2))
    explained = 1.0 - float(np.mean(left**2)) / power if power > 0 else 0.0
    delay = float(shift / scale) if scale else float("nan")
    rate = 1 / median_step(interaction.t)
    differs = "dq and the derivative of q have opposite signs: one column has the wrong sign"
    differs = "dq differs from the derivative of q by {value:.0%}" if scale > 0 else differs
    return (
        _judged(
            "dq_against_q",
            explained,
            LEAST_SHARE_EXPLAINED,
            "only {value:.0%} of dq is the derivative of q: they do not belong together",
            above=False,
        ),
        _judged("dq_scale", abs(float(scale) - 1), MOST_SCALE_ERROR, differs),
        _judged(
            "dq_delay",
            abs(delay),
            max(MOST_DELAY_S, 2 / rate),
            "dq and the derivative of q are {value:.3f} s apart",
            unit="s",
        ),
        noise,
    )


def _power(interaction: Interaction, data: JointData) -> DataFinding:
    """Torque along the motion in standard errors, as the proof of the sign has it: friction only takes energy."""
    number = interaction.joint_numbers[data.joint]
    scores = [one.score for one in interaction.choice.sign_evidence if one.joint == number]
    if not scores or np.isnan(scores[0]):
        return _stated("power", float("nan"), "")
    message = "the motion gains energy ({value:.1f} standard errors): torque or velocity has the wrong sign"
    return _judged("power", scores[0], -SIGNIFICANT, message, above=False)


def _sensors(interaction: Interaction, data: JointData) -> tuple[DataFinding, ...]:
    torque = interaction.torque[:, data.joint]
    still = (np.abs(data.dq) < data.dead_speed_rad_s) & data.valid
    standstill_s = float(still.sum()) * data.step_s
    noise = float("nan")
    if standstill_s > 0:
        bend = np.diff(data.torque)[still[1:] & still[:-1]]
        noise = float(np.std(bend) / np.sqrt(2)) if len(bend) else noise
    return (
        _stated("standstill_noise", noise, "N m"),
        _stated("torque_step", _resolution(torque), "N m"),
        _judged(
            "standstill",
            standstill_s,
            STANDSTILL_S,
            "{value:.1f} s of standstill: an offset of the sensor cannot be separated from uneven friction",
            unit="s",
            above=False,
            bad="limit",
        ),
    )


def _resolution(signal: Float) -> float:
    """Smallest step that most changes are multiples of; 0 where changes are all different."""
    steps = np.abs(np.diff(signal))
    steps = np.sort(steps[steps > 0])
    if len(steps) <= 1:
        return 0.0
    typical = float(np.quantile(steps, 0.05))
    multiples = steps / typical
    return typical if float(np.mean(np.abs(multiples - np.round(multiples)) < WHOLE)) > MOST_CHANGES else 0.0


def _excitation(data: JointData) -> tuple[DataFinding, ...]:
    speed = np.abs(data.dq[data.used])
    numbers = np.unique(data.cycle[data.used])
    spread = float(speed.std() / speed.mean()) if len(speed) else 0.0
    direction = np.sign(data.dq[data.moving & data.valid])
    reversals = float(np.count_nonzero(np.diff(direction)))
    return (
        _judged(
            "cycles",
            float(len(numbers)),
            FEWEST_CYCLES,
            "{value:.0f} cycles; {bound:.0f} are needed",
            above=False,
            bad="limit",
        ),
        _judged(
            "speed_spread",
            spread,
            LEAST_SPEED_SPREAD,
            "speeds spread by {value:.0%}: Coulomb and viscous friction cannot be separated",
            above=False,
            bad="limit",
        ),
        _judged(
            "reversals",
            reversals,
            FEWEST_REVERSALS,
            "{value:.0f} reversals: what follows a reversal cannot be seen",
            above=False,
            bad="limit",
        ),
    )
