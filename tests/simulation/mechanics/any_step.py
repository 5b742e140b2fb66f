"""The mechanics of one joint, released from anywhere and stepped as finely as wanted: written for these tests."""

from dataclasses import replace

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.bench import BenchSettings, Operator, assemble, moved_by, rotor_mass
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.mechanics.records import Clock
from friction_audit.simulation.mechanics.tick import run
from friction_audit.simulation.settings import IDEAL_SENSORS, JointParameters, TrueMotion, make_streams

NEXT_TO_NOTHING = 1e-300  # stiffness, or damping, of a hand that has none; the operator's must be above zero
FRICTIONLESS = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.0, viscous_nms_per_rad=0.0)
STEP_S = 1e-4  # the step of the simulator


def bench(joint: JointParameters = FRICTIONLESS, hidden: Hidden | None = None, **hand: float) -> BenchSettings:
    """Return a bench with ideal sensors; a hand has no spring and no damper unless told."""
    without = {"stiffness_nm_per_rad": NEXT_TO_NOTHING, "damping_nms_per_rad": NEXT_TO_NOTHING}
    operator = replace(Operator(), **(without | hand))  # type: ignore[arg-type]
    return BenchSettings(joints=(joint,), hidden=(hidden or Hidden(),), sensors=(IDEAL_SENSORS,), operator=operator)


def release(
    settings: BenchSettings,
    duration_s: float,
    *,
    step_s: float = STEP_S,
    tick_s: float | None = None,
    push: Float | None = None,
    q: tuple[float, float] = (0.0, 0.0),
    dq: tuple[float, float] = (0.0, 0.0),
) -> TrueMotion:
    """Let go of a joint whose outer and inner side are at q with dq, under a push of the hand known at every tick."""
    tick_s = 2.0 * step_s if tick_s is None else tick_s
    ticks = round(duration_s / tick_s)
    mechanism = assemble(settings, ticks, np.zeros(1), make_streams(0, 1))
    body, hand, inner = mechanism.body, settings.operator, mechanism.body.inner[0]
    rotor = rotor_mass(settings.joints, settings.hidden)[0, 0]
    body.inner_mass[0, 0] = rotor
    body.mass[0, 0] += hand.inertia_kg_m2
    body.mass[inner, inner] += rotor
    body.stiffness[0, 0], body.drive_damping[0, 0] = hand.stiffness_nm_per_rad, hand.damping_nms_per_rad
    body.y[inner], body.v[inner], body.y[0], body.v[0] = q[1], dq[1], q[0], dq[0]
    if dq[1] != 0.0 and body.mode[inner] == 0.0:
        body.mode[inner] = np.sign(dq[1])
    clock = Clock(dt=tick_s, substeps=round(0.5 * tick_s / step_s), duration=duration_s)
    push = np.zeros(ticks + 1) if push is None else push
    run(mechanism._replace(clock=clock), push, np.zeros(2), np.zeros((6, 1)), np.zeros(0), 0, ticks + 1)
    return replace(moved_by(mechanism, "any step").motion, t=np.arange(ticks + 1, dtype=np.float64) * tick_s)
