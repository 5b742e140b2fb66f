"""Compensators on the simulator's bench and step by step, and the stability limits of those that feed back."""

import math
from functools import cache
from typing import Any

import numpy as np
from scipy.linalg import expm

from friction_audit.compensation.competitors import Compensator, DisturbanceObserver, TorqueRegulation
from friction_audit.compensation.controller import FIND, step
from friction_audit.compensation.records import fresh_memory, pack
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
    memory = fresh_memory(1)
    memory["modelled_nm"] = COULOMB  # what a replay would tell a compensator with a joint's model, at every tick
    return pack([compensator], 1.0 / TICK_S)[0], memory[0]


def feed(compensator: Compensator | None, dq: Any, interaction_nm: Any, dt: float = TICK_S) -> tuple[Float, Record]:
    """Return the torques of a compensator that sees these signals, and its memory."""
    settings, memory = fresh(compensator)
    pairs = np.broadcast(np.asarray(dq, float), np.asarray(interaction_nm, float))
    return np.array([step(settings, memory, v, torque, dt, FIND) for v, torque in pairs]), memory


# Stability limits of the feed-back compensators from the theory of sampled loops.
# Motor B and outer inertia m, the link and the hand; u is held over a tick and acts one after the sensors were read.

GAINS = np.geomspace(1e-3, 1e4, 8001)  # the largest before the first that is unstable is the limit, to 0.2 %
ROUNDING = 1e-9  # a joint without damping rings for ever, at an eigenvalue of 1 but for rounding


def largest_torque_gain(motor: float, outer: float, stiffness: float, damping: float, share: float) -> float:
    """Return the largest stable G of u = G y, y the spring's torque after a low-pass that goes a share in a tick."""
    inverse = 1.0 / motor + 1.0 / outer
    rates = np.array([[0.0, 1.0, 0.0], [-stiffness * inverse, -damping * inverse, 1.0 / motor], [0.0, 0.0, 0.0]])
    plant: Float = expm(rates * TICK_S)[:2]  # of twist and its rate over a tick
    filtered = np.array([-share * stiffness, -share * damping, 1.0 - share])
    loops = np.array([np.vstack([plant @ np.vstack([np.eye(2, 3), gain * filtered]), filtered]) for gain in GAINS])
    unstable = np.abs(np.linalg.eigvals(loops)).max(axis=1) > 1.0 + ROUNDING
    return float(GAINS[np.argmax(unstable) - 1]) if unstable.any() else math.inf


def regulation_limit(settings: TorqueRegulation, motor: float, outer: float, stiffness: float, damping: float) -> float:
    """Return the smallest stable desired inertia B_theta. [kg m^2]"""
    share = -math.expm1(-2.0 * math.pi * settings.cutoff_hz * TICK_S)
    return settings.inertia_kg_m2 / (1.0 + largest_torque_gain(motor, outer, stiffness, damping, share))


def observer_limit(settings: DisturbanceObserver, motor: float, outer: float) -> float:
    """Return the largest observer gain L in a rigid joint. [1/s]

    The observed friction follows r[k+1] = (1 - a (1 - g e)) r[k] + ..., with a = 1 - exp(-L dt), compensation gain g
    and e = (B - B_assumed) / (m + B): with an inertia assumed too large it takes a (1 - g e) < 2.
    """
    error = (motor - settings.inertia_kg_m2) / (outer + motor)
    return -math.log1p(-2.0 / (1.0 - settings.compensation_gain * error)) / TICK_S
