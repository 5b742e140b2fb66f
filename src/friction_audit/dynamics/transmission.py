"""Transmissions: a spring, a damper and a gap in a row, between the measured side of a joint and its far side.

A spring is softest without torque: its stiffness grows evenly with the twist, from half to whole. Strain-wave gears are
soft at first (T. D. Tuttle, W. P. Seering, IEEE Trans. Robot. Autom. 12, 1996); makers state three stiffnesses that
grow with the torque. With s = K e of the twist e,

    T = s (1/2 + |s| / (4 b))  up to |s| = b,  beyond  T = s - sgn(s) b / 4

so that the stiffness is K from the torque 3/4 b on, which is the one that the model states.

Here the measured side moves as recorded, and many far sides are followed at once; ``stick_slip`` moves both sides.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, copysign, pi, sqrt

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float, read_only

NOTHING_NM = 1e-12  # a spring that stiffens up to this is straight
PHASE = 0.6  # largest phase of the ringing per step [rad]: its frequency is right to phase^2 / 24
MOST_STEPS = 100
# Faster ringing is followed as if it were this fast, with more inertia after a spring and softer flanks in a gap: no
# diagnosis looks above 40 Hz, where both look the same.
HIGHEST_HZ = 150.0
LANES = 16  # transmissions that are followed side by side: so many fill the registers of a processor
BLOCK = 64  # samples whose torques are written at once: one by one, with all rows by turns, takes half as long again
MANY_SAMPLES = 4096  # so many, spread evenly, determine inertia and friction
Lanes = tuple[float, ...]  # numba compiles a loop for each length of a tuple


@dataclass(frozen=True, kw_only=True, slots=True)
class FarSide:
    """What the transmission drives."""

    inertia_kg_m2: float  # inertia B [kg m^2]
    coulomb_nm: float  # Coulomb friction mu_c [N m]
    viscous_nms_per_rad: float  # viscous friction mu_v [N m s/rad]


@dataclass(frozen=True, kw_only=True, slots=True)
class Transmission:
    """A spring, a damper and a gap in a row."""

    stiffness_nm_per_rad: float  # stiffness K [N m/rad]
    damping_ratio: float  # damping ratio of the far side on the spring
    gap_rad: float = 0.0  # full width of the gap [rad]
    soft_nm: float = 0.0  # torque up to which the spring stiffens [N m]
    # part of the inertia that is on the far side, where all friction is; the rest, as a rotor's, moves with the
    # measured side
    far_share: float = 1.0


def bend_of(soft_nm: float) -> tuple[float, float]:
    """Return b [N m] and 1 / (4 b) [1/(N m)] of a spring that stiffens up to a torque; both zero for a straight one."""
    bend = 4.0 / 3.0 * soft_nm
    return bend, 0.25 / bend if bend > NOTHING_NM else 0.0


@compiled(inline=True)
def pushed(straight: float, bend: float, curve: float) -> float:
    """Return the torque of a spring, from that of one as stiff as it gets. [N m]"""
    bent = min(max(straight, -bend), bend)
    return straight - bent * (0.5 - curve * abs(bent))


@compiled()
def straightened(torque: float, bend: float) -> float:
    """Return the torque of a spring as stiff as it gets at the twist of this one under a torque. [N m]"""
    size = abs(torque)
    if size >= 0.75 * bend:
        return copysign(size + 0.25 * bend, torque) if size > 0.0 else 0.0
    return 4.0 * torque / (1.0 + sqrt(1.0 + 4.0 * size / bend))


def far_side(motion: Motion) -> FarSide:
    """Read inertia and friction off the torque of the simple model, which is linear in them.

    Numbers below zero, which a fit may give, count as zero: friction that pushes would run away.
    """
    every = max(len(motion.t) // MANY_SAMPLES, 1)
    columns = np.stack([motion.ddq[::every], motion.direction[::every], motion.dq[::every]])
    gram = np.linalg.pinv(columns @ columns.T, rcond=1e-12, hermitian=True)
    numbers = np.maximum(gram @ (columns @ simple_torque(motion)[::every]), 0.0).tolist()
    return FarSide(inertia_kg_m2=numbers[0], coulomb_nm=numbers[1], viscous_nms_per_rad=numbers[2])


def simple_torque(motion: Motion) -> Float:
    """Return the torque of inertia, Coulomb and viscous friction, which the motion has to have."""
    if motion.rest is None:
        raise AnalysisError(
            "motion: no torque of inertia and friction (rest); a term that changes how it gets to the sensor needs it"
        )
    return motion.rest


def flank_stiffness(inertia_kg_m2: float, contact_hz: float, gap_rad: float, usual_nm: float) -> float:
    """Return the stiffness of the flanks of a gap, on which an inertia rings at a frequency.

    Flanks that gave way to the usual torque by more than the gap would be a spring, which is another effect.
    """
    return max(inertia_kg_m2 * (2.0 * pi * min(contact_hz, HIGHEST_HZ)) ** 2, usual_nm / gap_rad)


def added_torques(
    motion: Motion, far: Sequence[FarSide], links: Sequence[Transmission]
) -> Iterator[tuple[list[int], Float]]:
    """Yield what transmissions, each with its far side, add to the torque of a rigid joint: places and torques. [N m]

    Places come in any order, k at once. Torques have shape (k, n): means from half a sample before to half a sample
    after, without the load. A far side starts at the velocity of the measured side, twisted by the load alone. It is at
    least as heavy as it must be for its ringing to be followed; one without any inertia adds nothing. The motion is
    evenly sampled.
    """
    step = float(motion.t[1] - motion.t[0])
    load = np.zeros(len(motion.t)) if motion.load is None else motion.load
    q, dq, ddq, sign, load = map(read_only, (motion.q, motion.dq, motion.ddq, motion.direction, load))
    alike: dict[tuple[int, bool], list[int]] = {}  # those that take as many steps and are of one kind
    numbers: dict[int, tuple[float, ...]] = {}  # of each far side, then of each transmission
    for place, (own, link) in enumerate(zip(far, links, strict=True)):
        if own.inertia_kg_m2 == 0.0:
            yield [place], np.zeros((1, len(motion.t)))
            continue
        stiffness = link.stiffness_nm_per_rad
        inertia = max(link.far_share * own.inertia_kg_m2, stiffness / (2.0 * pi * HIGHEST_HZ) ** 2)
        rate = sqrt(stiffness / inertia)
        driven = (inertia, own.coulomb_nm, own.viscous_nms_per_rad)
        damping = 2.0 * link.damping_ratio * inertia * rate
        numbers[place] = (*driven, stiffness, damping, 0.5 * link.gap_rad, *bend_of(link.soft_nm))
        steps = 2 * min(max(ceil(0.5 * step * rate / PHASE), 1), MOST_STEPS)
        alike.setdefault((steps, link.gap_rad > 0.0), []).append(place)
    for (steps, gap), those in alike.items():
        for first in range(0, len(those), LANES):
            places = those[first : first + LANES]
            # One or LANES side by side; the last one stands in for those that are lacking.
            filled = places + places[-1:] * (LANES - len(places) if len(places) > 1 else 0)
            rows = np.ascontiguousarray(np.array([numbers[k] for k in filled]).T)
            lanes, weights = (0.0,) * len(filled), between_samples(step, steps)
            yield places, _follow(q, dq, ddq, sign, load, step, weights, rows[:3], rows[3:], gap, lanes)[: len(places)]


def between_samples(step: float, steps: int) -> Float:
    """Weights of the rise and of both slopes in Hermite's cubic and its slope, amid every step, shape (steps, 6)."""
    x = (np.arange(steps) + 0.5) / steps
    rest = 1.0 - x
    position = (x**2 * (3.0 - 2.0 * x), step * x * rest**2, -step * x**2 * rest)
    speed = (6.0 * x * rest / step, rest * (1.0 - 3.0 * x), x * (3.0 * x - 2.0))
    return np.stack([*position, *speed], axis=1)


@compiled(inline=True)
def amid(w: Float, q: float, rise: float, dq: float, next_dq: float) -> tuple[float, float]:
    """Return position and speed between two samples, on the cubic through both, by the weights of a step."""
    return q + w[0] * rise + w[1] * dq + w[2] * next_dq, w[3] * rise + w[4] * dq + w[5] * next_dq


@compiled(any_order=True)
def _follow(  # noqa: PLR0913
    q: Float,
    dq: Float,
    ddq: Float,
    direction: Float,
    load: Float,
    step: float,
    between: Float,
    far: Float,
    links: Float,
    gap: bool,
    lanes: Lanes,
) -> Float:
    """Integrate far sides (3, m) after transmissions (5, m), as many as lanes; return what they add, shape (m, n).

    They are side by side so that a processor takes several at once. The measured side moves along the cubic through
    its samples and their slopes.
    """
    steps, many = len(between), len(lanes)
    h = step / steps
    # Rows of one array of a known size: the compiler then need not ask at every step whether they overlap.
    table, bent = np.zeros((15, len(lanes))), links[3].any()
    stiffness, damping, half, bend, curve = table[0], table[1], table[2], table[3], table[4]
    keep_apart, gain_apart, held_apart, keep, gain, held = table[5], table[6], table[7], table[8], table[9], table[10]
    middle, omega = table[11], table[12]  # position amid the next step, last velocity
    torque, block = np.empty((many, len(q))), np.empty((BLOCK, len(lanes)))
    # About the last sample and about the next one, from half a sample before to half a sample after.
    last, next_one = 13, 14
    _start(table, far, links, h, q[0], dq[0], load[0], gap, lanes)
    for k in range(len(q) - 1):
        rise, more = q[k + 1] - q[k], load[k + 1] - load[k]
        for i in range(steps):
            position, speed = amid(between[i], q[k], rise, dq[k], dq[k + 1])
            borne = load[k] + (i + 0.5) / steps * more
            felt = last if 2 * i < steps else next_one
            # Damping at the mean of both velocities, then what Coulomb friction takes of the new one.
            if gap:
                for j in range(many):
                    twist = position - middle[j]
                    engaged = twist - min(max(twist, -half[j]), half[j])
                    push = _pushed(stiffness[j] * engaged, bend[j], curve[j], bent) + damping[j] * speed
                    # Neither spring nor damping within the gap and where flanks would pull. As a factor, for what is
                    # read on a condition is read one by one.
                    touches = 1.0 if engaged * (push - damping[j] * omega[j]) > 0.0 else 0.0
                    push, drag, slip = touches * push - borne, touches * damping[j], held_apart[j] + touches * held[j]
                    free = (keep_apart[j] + touches * keep[j]) * omega[j] + (gain_apart[j] + touches * gain[j]) * push
                    after = free - min(max(free, -slip), slip)
                    table[felt, j] += push - 0.5 * drag * (omega[j] + after)
                    middle[j] += h * after
                    omega[j] = after
            else:
                for j in range(many):
                    push = _pushed(stiffness[j] * (position - middle[j]), bend[j], curve[j], bent)
                    push += damping[j] * speed - borne
                    free = keep[j] * omega[j] + gain[j] * push
                    after = free - min(max(free, -held[j]), held[j])
                    table[felt, j] += push - 0.5 * damping[j] * (omega[j] + after)
                    middle[j] += h * after
                    omega[j] = after
        share = 2.0 / steps if k == 0 else 1.0 / steps  # both ends have half a sample each
        for j in range(many):
            rigid = far[0, j] * ddq[k] + (far[1, j] * direction[k] + far[2, j] * dq[k])
            block[k % BLOCK, j] = share * table[last, j] - rigid
            table[last, j], table[next_one, j] = table[next_one, j], 0.0
        _write(torque, block, k, k == len(q) - 2)
    for j in range(many):
        rigid = far[0, j] * ddq[-1] + (far[1, j] * direction[-1] + far[2, j] * dq[-1])
        torque[j, -1] = 2.0 / steps * table[last, j] - rigid
    return torque


@compiled(inline=True)
def _pushed(straight: float, bend: float, curve: float, bent: bool) -> float:
    """Return the torque of a spring where any lane has one that bends. [N m]"""
    return pushed(straight, bend, curve) if bent else straight


@compiled(inline=True)
def _write(torque: Float, block: Float, k: int, last: bool) -> None:
    """Write the torques of a block, shape (BLOCK, lanes), that ends with a sample, or with the last one."""
    if last or k % BLOCK == BLOCK - 1:
        for j in range(len(torque)):
            for i in range(k % BLOCK + 1):
                torque[j, k - k % BLOCK + i] = block[i, j]


@compiled(inline=True)
def _start(  # noqa: PLR0913
    table: Float, far: Float, links: Float, h: float, q: float, dq: float, load: float, gap: bool, lanes: Lanes
) -> None:
    """Numbers of the transmissions, those of a flank that touches less those apart, and the state at the start."""
    for j in range(len(lanes)):
        for i in range(5):
            table[i, j] = links[i, j]
        table[8, j], table[9, j], table[10, j] = _of_step(far[:, j], links[1, j], h)
        if gap:
            table[5, j], table[6, j], table[7, j] = _of_step(far[:, j], 0.0, h)
            for i in range(8, 11):
                table[i, j] -= table[i - 3, j]
        theta = q - twisted(load, links[0, j], links[2, j], links[3, j])
        table[11, j], table[12, j] = theta + 0.5 * h * dq, dq


@compiled(inline=True)
def _of_step(far: Float, drag: float, h: float) -> tuple[float, float, float]:
    """Return for a step what is left of a velocity, what a torque gives to it, and what Coulomb friction takes."""
    loss = 0.5 * h * (drag + far[2])
    gain = h / (far[0] + loss)
    return (far[0] - loss) / (far[0] + loss), gain, gain * far[1]


@compiled(inline=True)
def twisted(load: float, stiffness: float, half: float, bend: float) -> float:
    """Return by how much a transmission is twisted at rest under a load; nothing without one. [rad]"""
    twist: float = straightened(load, bend) / stiffness
    return twist if load == 0.0 else twist + copysign(half, load)
