"""Competitors on the simulator's bench, and step by step."""

from typing import Any

import numpy as np

from friction_audit.compensation.compensators import Compensator
from friction_audit.compensation.controller import FIND, step
from friction_audit.compensation.records import fresh_memory, pack
from friction_audit.compiled import Record
from friction_audit.joint_log import Float
from friction_audit.simulation import IDEAL_SENSORS, JointParameters, Operator, Sensors
from friction_audit.simulation.bench import BenchSettings, simulate_bench
from friction_audit.simulation.motion import Sinusoid
from friction_audit.simulation.simulation import TrueMotion

TICK_S = 1e-3
INERTIA, COULOMB, VISCOUS = 0.3, 0.30, 0.07
HAND = 0.3
JOINT = JointParameters(inertia_kg_m2=INERTIA, coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)


def guided(
    compensator: Compensator | None,
    *,
    joint: JointParameters = JOINT,
    hand: float = HAND,
    sensors: Sensors = IDEAL_SENSORS,
    duration_s: float = 14.0,
) -> TrueMotion:
    """Return the truth: the hand draws the joint to and fro for 12 s, then rests."""
    settings = BenchSettings(
        joints=(joint,),
        sensors=(sensors,),
        operator=Operator(inertia_kg_m2=hand, motion=Sinusoid(ease_s=0.5)),
        compensator=compensator,
        duration_s=duration_s,
    )
    return simulate_bench(settings, 0).truth.motion


def work_j(motion: TrueMotion) -> float:
    """Return what the hand puts in; F_m jumps when u does, and the value at a tick is the one before the jump."""
    moved = (motion.dq[1:] + motion.dq[:-1]) / 2 * TICK_S
    return float(np.sum(motion.interaction_nm[1:] * moved))


def runs_away(motion: TrueMotion) -> bool:
    """Return True if the loop of a compensator diverges."""
    return not (np.abs(motion.dq).max() <= 100.0 and np.abs(motion.compensation_nm).max() <= 100.0)


def fresh(compensator: Compensator | None) -> tuple[Record, Record]:
    memory = fresh_memory(1)
    memory["modelled_nm"] = COULOMB  # what a replay would tell a compensator with a joint's model, at every tick
    return pack([compensator], 1.0 / TICK_S)[0], memory[0]


def feed(compensator: Compensator | None, dq: Any, interaction_nm: Any, dt: float = TICK_S) -> tuple[Float, Record]:
    """Return the torques of a compensator that sees these signals, and its memory."""
    settings, memory = fresh(compensator)
    pairs = np.broadcast(np.asarray(dq, float), np.asarray(interaction_nm, float))
    return np.array([step(settings, memory, v, torque, dt, FIND) for v, torque in pairs]), memory
