"""Transmissions: spring, damper and backlash in series, between the measured side and the friction side of a joint.

The spring is a hardening spring: its stiffness grows linearly with the twist from K/2 to K. Strain-wave gears behave
so (T. D. Tuttle, W. P. Seering, IEEE Trans. Robot. Autom. 12, 1996); their data sheets give three stiffnesses that grow
with the torque. With the torque s = K e of a linear spring at the twist e,

    T = s (1/2 + |s| / (4 b))  up to |s| = b,  beyond  T = s - sgn(s) b / 4

The stiffness is K from the torque 3/4 b on; the model file states that torque (``soft_nm``).

Here the measured side moves as recorded and many friction sides are integrated. ``stick_slip`` moves both sides.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, copysign, pi, sqrt

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float, read_only

NOTHING_NM = 1e-12  # a spring that hardens up to this torque is linear
PHASE = 0.6  # largest phase of the resonance per step [rad]: its frequency is right to phase^2 / 24
MOST_STEPS = 100
# A faster resonance is integrated at this one, with more inertia on a spring and a softer contact: both look the same
# below 40 Hz, the highest frequency of a diagnosis.
HIGHEST_HZ = 150.0
BATCH = 16  # transmissions that are integrated together: they fill the vector registers of a processor
BLOCK = 64  # samples whose torques are written at once: writing them one by one takes half as long again
MANY_SAMPLES = 4096  # evenly spaced samples, enough to determine inertia and friction
Batch = tuple[float, ...]  # one entry per transmission: numba compiles a loop for each length of a tuple


@dataclass(frozen=True, kw_only=True, slots=True)
class FrictionSide:
    """Inertia and friction that the transmission drives."""

    inertia_kg_m2: float  # inertia B [kg m^2]
    coulomb_nm: float  # Coulomb friction mu_c [N m]
    viscous_nms_per_rad: float  # viscous friction mu_v [N m s/rad]


@dataclass(frozen=True, kw_only=True, slots=True)
class Transmission:
    """A spring, a damper and backlash in series."""

    stiffness_nm_per_rad: float  # stiffness K [N m/rad]
    damping_ratio: float  # damping ratio of the friction side on the spring
    gap_rad: float = 0.0  # full width of the backlash [rad]
    soft_nm: float = 0.0  # torque up to which the spring hardens [N m]
    far_share: float = 1.0  # share of the inertia on the friction side; the rest moves with the measured side


def hardening(soft_nm: float) -> tuple[float, float]:
    """Return b [N m] and 1 / (4 b) [1/(N m)] of a spring that hardens up to a torque; both zero for a linear one."""
    knee = 4.0 / 3.0 * soft_nm
    return knee, 0.25 / knee if knee > NOTHING_NM else 0.0


@compiled(inline=True)
def spring_torque(linear: float, knee: float, curvature: float) -> float:
    """Return the torque of a hardening spring from that of a linear spring of stiffness K at the same twist. [N m]"""
    soft = min(max(linear, -knee), knee)
    return linear - soft * (0.5 - curvature * abs(soft))


@compiled()
def linear_torque(torque: float, knee: float) -> float:
    """Return the torque of a linear spring of stiffness K at the twist of a hardening spring: the inverse. [N m]"""
    size = abs(torque)
    if size >= 0.75 * knee:
        return copysign(size + 0.25 * knee, torque) if size > 0.0 else 0.0
    return 4.0 * torque / (1.0 + sqrt(1.0 + 4.0 * size / knee))


def fit_friction_side(motion: Motion) -> FrictionSide:
    """Fit inertia and friction to the torque of the simple model, which is linear in them.

    Negative values count as zero: with negative friction the integration would diverge.
    """
    every = max(len(motion.t) // MANY_SAMPLES, 1)
    columns = np.stack([motion.ddq[::every], motion.direction[::every], motion.dq[::every]])
    gram = np.linalg.pinv(columns @ columns.T, rcond=1e-12, hermitian=True)
    numbers = np.maximum(gram @ (columns @ simple_torque(motion)[::every]), 0.0).tolist()
    return FrictionSide(inertia_kg_m2=numbers[0], coulomb_nm=numbers[1], viscous_nms_per_rad=numbers[2])


def simple_torque(motion: Motion) -> Float:
    """Return the torque of inertia, Coulomb and viscous friction; AnalysisError if the motion has none."""
    if motion.rest is None:
        raise AnalysisError(
            "motion: no torque of inertia and friction (rest); a term that changes how it gets to the sensor needs it"
        )
    return motion.rest


def contact_stiffness(inertia_kg_m2: float, contact_hz: float, gap_rad: float, rms_nm: float) -> float:
    """Return the stiffness of the contact of a backlash, on which the inertia resonates at a frequency. [N m/rad]

    The RMS torque deflects the contact by the gap at most; a softer contact would be a spring, another effect.
    """
    return max(inertia_kg_m2 * (2.0 * pi * min(contact_hz, HIGHEST_HZ)) ** 2, rms_nm / gap_rad)


def added_torques(
    motion: Motion, sides: Sequence[FrictionSide], transmissions: Sequence[Transmission]
) -> Iterator[tuple[list[int], Float]]:
    """Yield the torques that transmissions, each with its friction side, add to that of a rigid joint. [N m]

    Yields indices of k transmissions, in any order, and their torques without the load, shape (k, n): means from half a
    sample before to half a sample after. A friction side starts at the velocity of the measured side, twisted by the
    load only. Its inertia is at least that of a resonance at HIGHEST_HZ; without inertia it adds nothing. The motion is
    evenly sampled.
    """
    step = float(motion.t[1] - motion.t[0])
    load = np.zeros(len(motion.t)) if motion.load is None else motion.load
    q, dq, ddq, sign, load = map(read_only, (motion.q, motion.dq, motion.ddq, motion.direction, load))
    groups: dict[tuple[int, bool], list[int]] = {}  # indices by the number of steps and the kind
    numbers: dict[int, tuple[float, ...]] = {}  # of each friction side, then of its transmission
    for k, (side, link) in enumerate(zip(sides, transmissions, strict=True)):
        if side.inertia_kg_m2 == 0.0:
            yield [k], np.zeros((1, len(motion.t)))
            continue
        stiffness = link.stiffness_nm_per_rad
        inertia = max(link.far_share * side.inertia_kg_m2, stiffness / (2.0 * pi * HIGHEST_HZ) ** 2)
        frequency = sqrt(stiffness / inertia)
        damping = 2.0 * link.damping_ratio * inertia * frequency
        friction = side.coulomb_nm, side.viscous_nms_per_rad
        numbers[k] = (inertia, *friction, stiffness, damping, 0.5 * link.gap_rad, *hardening(link.soft_nm))
        steps = 2 * min(max(ceil(0.5 * step * frequency / PHASE), 1), MOST_STEPS)
        groups.setdefault((steps, link.gap_rad > 0.0), []).append(k)
    for (steps, gap), group in groups.items():
        for first in range(0, len(group), BATCH):
            indices = group[first : first + BATCH]
            # One transmission or BATCH of them; the last one fills an incomplete batch.
            filled = indices + indices[-1:] * (BATCH - len(indices) if len(indices) > 1 else 0)
            rows = np.ascontiguousarray(np.array([numbers[k] for k in filled]).T)
            batch, weights = (0.0,) * len(filled), hermite_weights(step, steps)
            added = _integrate(q, dq, ddq, sign, load, step, weights, rows[:3], rows[3:], gap, batch)
            yield indices, added[: len(indices)]


def hermite_weights(step: float, steps: int) -> Float:
    """Return the weights of a cubic Hermite spline and of its derivative in the middle of every step, shape (steps, 6).

    They multiply the difference of two samples and the velocities at both.
    """
    x = (np.arange(steps) + 0.5) / steps
    rest = 1.0 - x
    position = (x**2 * (3.0 - 2.0 * x), step * x * rest**2, -step * x**2 * rest)
    speed = (6.0 * x * rest / step, rest * (1.0 - 3.0 * x), x * (3.0 * x - 2.0))
    return np.stack([*position, *speed], axis=1)


@compiled(inline=True)
def hermite(w: Float, q: float, rise: float, dq: float, next_dq: float) -> tuple[float, float]:
    """Return position and velocity between two samples on a cubic Hermite spline, by the weights of a step."""
    return q + w[0] * rise + w[1] * dq + w[2] * next_dq, w[3] * rise + w[4] * dq + w[5] * next_dq


@compiled(any_order=True)
def _integrate(  # noqa: PLR0913
    q: Float,
    dq: Float,
    ddq: Float,
    direction: Float,
    load: Float,
    step: float,
    weights: Float,
    sides: Float,
    links: Float,
    gap: bool,
    batch: Batch,
) -> Float:
    """Integrate m friction sides, shape (3, m), after transmissions (5, m); return the added torques, shape (m, n).

    The innermost loops are over the m, for vector instructions. The measured side moves along a cubic Hermite spline.
    """
    steps, many = len(weights), len(batch)
    h = step / steps
    # Rows of one array of a known size: the compiler then knows that they do not overlap.
    table, hardens = np.zeros((15, len(batch))), links[3].any()
    stiffness, damping, half, knee, curvature = table[0], table[1], table[2], table[3], table[4]
    keep_apart, gain_apart, held_apart, keep, gain, held = table[5], table[6], table[7], table[8], table[9], table[10]
    middle, omega = table[11], table[12]  # position in the middle of the next step, last velocity
    torque, block = np.empty((many, len(q))), np.empty((BLOCK, len(batch)))
    # Rows of the sums of the torque from half a sample before to half a sample after the last and the next sample.
    last, next_one = 13, 14
    _start(table, sides, links, h, q[0], dq[0], load[0], gap, batch)
    for k in range(len(q) - 1):
        rise, more = q[k + 1] - q[k], load[k + 1] - load[k]
        for i in range(steps):
            position, speed = hermite(weights[i], q[k], rise, dq[k], dq[k + 1])
            borne = load[k] + (i + 0.5) / steps * more
            row = last if 2 * i < steps else next_one
            # Damping at the mean of both velocities; then Coulomb friction brakes the new velocity, to 0 at most.
            if gap:
                for j in range(many):
                    twist = position - middle[j]
                    engaged = twist - min(max(twist, -half[j]), half[j])
                    push = _spring_torque(stiffness[j] * engaged, knee[j], curvature[j], hardens) + damping[j] * speed
                    # Neither spring nor damper acts within the gap or where the contact would pull. As a factor: a
                    # branch would prevent vector instructions.
                    touches = 1.0 if engaged * (push - damping[j] * omega[j]) > 0.0 else 0.0
                    push, drag, slip = touches * push - borne, touches * damping[j], held_apart[j] + touches * held[j]
                    free = (keep_apart[j] + touches * keep[j]) * omega[j] + (gain_apart[j] + touches * gain[j]) * push
                    after = free - min(max(free, -slip), slip)
                    table[row, j] += push - 0.5 * drag * (omega[j] + after)
                    middle[j] += h * after
                    omega[j] = after
            else:
                for j in range(many):
                    push = _spring_torque(stiffness[j] * (position - middle[j]), knee[j], curvature[j], hardens)
                    push += damping[j] * speed - borne
                    free = keep[j] * omega[j] + gain[j] * push
                    after = free - min(max(free, -held[j]), held[j])
                    table[row, j] += push - 0.5 * damping[j] * (omega[j] + after)
                    middle[j] += h * after
                    omega[j] = after
        share = 2.0 / steps if k == 0 else 1.0 / steps  # the first and the last sample have half an interval
        for j in range(many):
            rigid = sides[0, j] * ddq[k] + (sides[1, j] * direction[k] + sides[2, j] * dq[k])
            block[k % BLOCK, j] = share * table[last, j] - rigid
            table[last, j], table[next_one, j] = table[next_one, j], 0.0
        _write(torque, block, k, k == len(q) - 2)
    for j in range(many):
        rigid = sides[0, j] * ddq[-1] + (sides[1, j] * direction[-1] + sides[2, j] * dq[-1])
        torque[j, -1] = 2.0 / steps * table[last, j] - rigid
    return torque


@compiled(inline=True)
def _spring_torque(linear: float, knee: float, curvature: float, hardens: bool) -> float:
    """Return the torque of a spring; ``hardens`` if any spring of the batch does. [N m]"""
    return spring_torque(linear, knee, curvature) if hardens else linear


@compiled(inline=True)
def _write(torque: Float, block: Float, k: int, last: bool) -> None:
    """Write the torques of a block, shape (BLOCK, m), once sample k completes it or is the last one."""
    if last or k % BLOCK == BLOCK - 1:
        for j in range(len(torque)):
            for i in range(k % BLOCK + 1):
                torque[j, k - k % BLOCK + i] = block[i, j]


@compiled(inline=True)
def _start(  # noqa: PLR0913
    table: Float, sides: Float, links: Float, h: float, q: float, dq: float, load: float, gap: bool, batch: Batch
) -> None:
    """Fill the table: numbers of the transmissions, coefficients of a step without and with contact, initial state."""
    for j in range(len(batch)):
        for i in range(5):
            table[i, j] = links[i, j]
        table[8, j], table[9, j], table[10, j] = _step_coefficients(sides[:, j], links[1, j], h)
        if gap:
            table[5, j], table[6, j], table[7, j] = _step_coefficients(sides[:, j], 0.0, h)
            for i in range(8, 11):
                table[i, j] -= table[i - 3, j]
        theta = q - static_twist(load, links[0, j], links[2, j], links[3, j])
        table[11, j], table[12, j] = theta + 0.5 * h * dq, dq


@compiled(inline=True)
def _step_coefficients(side: Float, damping: float, h: float) -> tuple[float, float, float]:
    """Return the velocity that is left per velocity, that gained per torque, and that lost to Coulomb friction."""
    loss = 0.5 * h * (damping + side[2])
    gain = h / (side[0] + loss)
    return (side[0] - loss) / (side[0] + loss), gain, gain * side[1]


@compiled(inline=True)
def static_twist(load: float, stiffness: float, half: float, knee: float) -> float:
    """Return the twist of a transmission at rest under a load, the half gap included; 0 without a load. [rad]"""
    twist: float = linear_torque(load, knee) / stiffness
    return twist if load == 0.0 else twist + copysign(half, load)
