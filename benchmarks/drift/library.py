"""Sessions of one joint that went through the whole chain: simulated log -> estimate -> summary.

Temperature of the room, speed of the motion and noise of the sensors differ from session to session. Friction depends
on the temperature, and the joint warms up within the session.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from friction_audit.batch.work import session_of
from friction_audit.drift.session import Conditions, JointSummary
from friction_audit.friction.settings import FrictionSettings
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.simulation import PANDA_SENSORS, BenchSettings, Hidden, JointParameters, Operator, simulate
from friction_audit.simulation.effects.slow_and_events import WarmUp
from friction_audit.simulation.strokes import StopAndGo

DURATION_S = 40.0
ROOM_C, ROOM_SPREAD_K = 22.0, 3.0
RISE_K, LOST = 8.0, 0.15
"""A warm joint is so much warmer and has lost so much of its viscous friction, half as much of its Coulomb friction."""


@dataclass(frozen=True, kw_only=True)
class OneJoint:
    """One session of one joint."""

    factor: float  # coulomb friction over that of the other sessions: the drift
    conditions: Conditions  # under what it was read
    summary: JointSummary  # what is kept of it


def record(factor: float, seed: int) -> OneJoint:
    """Simulate one session and read it."""
    rng = np.random.default_rng(seed)
    warmth = ROOM_SPREAD_K * rng.standard_normal() / RISE_K
    speed = rng.uniform(0.5, 1.3)
    settings = BenchSettings(
        joints=(
            JointParameters(
                coulomb_nm=0.30 * factor / (1.0 + warmth * LOST / 2 / (1.0 - LOST / 2)),
                viscous_nms_per_rad=0.07 * (1.0 - LOST) ** warmth,
            ),
        ),
        hidden=(Hidden(warm_up=WarmUp(reduction=LOST, time_s=120.0, cold_c=ROOM_C + RISE_K * warmth, rise_k=RISE_K)),),
        sensors=(replace(PANDA_SENSORS[0], torque_noise_nm=PANDA_SENSORS[0].torque_noise_nm * rng.uniform(0.7, 1.5)),),
        operator=Operator(motion=StopAndGo(speed_rad_s=speed, speed_limits_rad_s=(0.3 * speed, 2.0 * speed))),
        logs_temperature=True,
        duration_s=DURATION_S,
    )
    log = simulate(settings, seed).log
    found = estimate_log(log, AuditSettings(friction=FrictionSettings(compare=False)))
    session = session_of(found)
    return OneJoint(factor=factor, conditions=session.conditions, summary=session.joints[0])


def record_many(factor: float, count: int, first_seed: int, workers: int) -> list[OneJoint]:
    """Simulate so many sessions with one level of friction."""
    with ProcessPoolExecutor(max_workers=workers) as pool:
        return list(pool.map(partial(record, factor), range(first_seed, first_seed + count), chunksize=8))
