"""Compensators on the simulator's bench and step by step, and the stability limit of the observer."""

import math
from functools import cache
from typing import Any

import numpy as np

from friction_audit.compensation.competitors import Compensator, DisturbanceObserver
from friction_audit.compensation.controller import DETECT, step
from friction_audit.compensation.records import initial_states, settings_records
from friction_audit.compensation.settings import OperatorImpedance, ReplaySettings
from friction_audit.compiled import Record
from friction_audit.joint_log import Float, JointLog
from friction_audit.pipeline import AuditSettings, Estimate, estimate_log, replay_estimate
from friction_audit.simulation import IDEAL_SENSORS, JointParameters, Operator, Sensors
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import TrueMotion

TICK_S = 1e-3
INERTIA, COULOMB, VISCOUS = 0.3, 0.30, 0.07
HAND = 0.3
JOINT = JointParameters(inertia_kg_m2=INERTIA, coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
BY_HAND = Operator(motion=Sinusoid(spread=0.3))
TRUE_HAND = OperatorImpedance(inertia_kg_m2=HAND, damping_nms_per_rad=9.0, stiffness_nm_per_rad=60.0)
BENCH = BenchSettings(joints=(JOINT,), sensors=(IDEAL_SENSORS,), operator=BY_HAND, duration_s=30.0)


@cache
def log_of(settings: BenchSettings, seed: int = 1) -> JointLog:
    return simulate(settings, seed).log


@cache
def estimated(log: JointLog) -> Estimate:
    return estimate_log(log, AuditSettings())


def replay(log: JointLog, settings: ReplaySettings) -> Any:
    return replay_estimate(estimated(log), settings).replay


def guided(
    compensator: Compensator | None,
    *,
    joint: JointParameters = JOINT,
    hand: float = HAND,
    sensors: Sensors = IDEAL_SENSORS,
    duration_s: float = 14.0,
) -> TrueMotion:
    """Return the truth: the hand draws the joint to and fro for 12 s, then rests."""
    operator = Operator(inertia_kg_m2=hand, motion=Sinusoid(ease_s=0.5))
    settings = BenchSettings(
        joints=(joint,), sensors=(sensors,), operator=operator, compensator=compensator, duration_s=duration_s
    )
    return simulate(settings, 0).truth.motion


def work_j(motion: TrueMotion) -> float:
    """Return what the hand puts in; F_m jumps when u does, and the value at a tick is the one before the jump."""
    moved = (motion.dq[1:] + motion.dq[:-1]) / 2 * TICK_S
    return float(np.sum(motion.interaction_nm[1:] * moved))


def runs_away(motion: TrueMotion) -> bool:
    return not (np.abs(motion.dq).max() <= 100.0 and np.abs(motion.compensation_nm).max() <= 100.0)


def fresh(compensator: Compensator | None) -> tuple[Record, Record]:
    state = initial_states(1)
    state["modelled_nm"] = COULOMB  # a replay stores it at every tick, for a compensator with a joint's model
    return settings_records([compensator], 1.0 / TICK_S)[0], state[0]


def feed(compensator: Compensator | None, dq: Any, interaction_nm: Any, dt: float = TICK_S) -> tuple[Float, Record]:
    """Return the torques of a compensator that sees these signals, and its state."""
    settings, state = fresh(compensator)
    pairs = np.broadcast(np.asarray(dq, float), np.asarray(interaction_nm, float))
    return np.array([step(settings, state, v, torque, dt, DETECT) for v, torque in pairs]), state


def observer_limit(settings: DisturbanceObserver, motor: float, outer: float) -> float:
    """Return the largest observer gain L in a rigid joint. [1/s]

    The observed friction follows r[k+1] = (1 - a (1 - g e)) r[k] + ..., with a = 1 - exp(-L dt), compensation gain g
    and e = (B - B_assumed) / (m + B): with an inertia assumed too large it takes a (1 - g e) < 2.
    """
    error = (motor - settings.inertia_kg_m2) / (outer + motor)
    return -math.log1p(-2.0 / (1.0 - settings.compensation_gain * error)) / TICK_S
