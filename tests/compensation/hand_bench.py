"""A mass with friction, drawn by a spring and a damper along a sinusoid: written for these tests, of no other use."""

from dataclasses import dataclass

import numpy as np

from friction_audit.compensation.compensators import Compensator
from friction_audit.compensation.controller import FIND, step, trace
from friction_audit.compensation.records import TRACE, Record, fresh_memory, pack
from friction_audit.compiled import compiled
from friction_audit.joint_log import Float

TICK_S = 1e-3
SUBSTEPS = 20


@dataclass(frozen=True, kw_only=True)
class Bench:
    """The sensor sits between the link, which the hand holds, and the motor, where friction and compensator act."""

    motor_kg_m2: float = 0.3
    link_kg_m2: float = 0.0
    stiffness_nm_per_rad: float = 60.0
    damping_nms_per_rad: float = 9.0
    coulomb_nm: float = 0.0
    viscous_nms_per_rad: float = 0.0
    later_coulomb_nm: float | None = None
    later_viscous_nms_per_rad: float | None = None
    later_s: float = np.inf
    stroke_s: float = 1.0
    amplitude_rad: float = 0.3
    growth_per_s: float = 0.0
    duration_s: float = 8.0


@compiled()
def aim(body: Float, t: float) -> tuple[float, float]:
    """Return where the hand wants to be, and its velocity."""
    stroke, amplitude, growth = body[8], body[9], body[10]
    omega = np.pi / stroke
    size, turn = amplitude * (1.0 + growth * t), 1.0 - np.cos(omega * t)
    return size * turn, size * omega * np.sin(omega * t) + amplitude * growth * turn


@compiled()
def integrate(settings: Record, memory: Record, body: Float, ticks: int, out: Float, motion: Float) -> None:
    motor, link, stiffness, damping = body[0], body[1], body[2], body[3]
    h = TICK_S / SUBSTEPS
    mass = motor + link
    q, v, force, taken = 0.0, 0.0, 0.0, 0.0
    coulomb, viscous = body[4], body[5]
    for k in range(ticks):
        u = step(settings, memory, v, force, TICK_S, FIND)
        trace(memory, out[k])
        motion[k, 0], motion[k, 1], motion[k, 2] = v, force, taken
        for i in range(SUBSTEPS):
            t = k * TICK_S + (i + 0.5) * h
            later = t >= body[11]
            coulomb, viscous = (body[6], body[7]) if later else (body[4], body[5])
            place, speed = aim(body, t)
            # The mean of a step's two velocities, solved for; Coulomb friction takes at most what would stop the mass.
            rate = stiffness * 0.5 * h + damping
            free = stiffness * (place - q) + damping * speed + u
            divisor = mass + 0.5 * h * (rate + viscous)
            middle = (mass * v + 0.5 * h * free) / divisor
            middle = np.sign(middle) * max(0.0, abs(middle) - 0.5 * h * coulomb / divisor)
            after = 2.0 * middle - v
            if middle == 0.0:
                after = 0.0
            taken += h * (coulomb * abs(middle) + viscous * middle * middle)
            q += h * middle
            v = after
        place, speed = aim(body, (k + 1) * TICK_S)
        hand = stiffness * (place - q) + damping * (speed - v)
        pull = hand + u - viscous * v
        pull -= coulomb * np.sign(v) if v != 0.0 else max(-coulomb, min(coulomb, pull))
        force = hand - link * pull / mass


def drive(bench: Bench, compensator: Compensator | None) -> dict[str, Float]:
    """Return the traces of the compensator, and ``dq``, ``interaction_nm`` and ``friction_j``, at every tick."""
    later_coulomb = bench.coulomb_nm if bench.later_coulomb_nm is None else bench.later_coulomb_nm
    later_viscous = bench.viscous_nms_per_rad
    if bench.later_viscous_nms_per_rad is not None:
        later_viscous = bench.later_viscous_nms_per_rad
    body = np.array(
        [
            bench.motor_kg_m2,
            bench.link_kg_m2,
            bench.stiffness_nm_per_rad,
            bench.damping_nms_per_rad,
            bench.coulomb_nm,
            bench.viscous_nms_per_rad,
            later_coulomb,
            later_viscous,
            bench.stroke_s,
            bench.amplitude_rad,
            bench.growth_per_s,
            bench.later_s,
        ]
    )
    ticks = round(bench.duration_s / TICK_S)
    settings, memory = pack([compensator], 1.0 / TICK_S), fresh_memory(1)
    out, motion = np.empty((ticks, len(TRACE))), np.empty((ticks, 3))
    integrate(settings[0], memory[0], body, ticks, out, motion)
    signals = dict(zip(TRACE, out.T, strict=True))
    return signals | dict(zip(("dq", "interaction_nm", "friction_j"), motion.T, strict=True))
