"""The sensor reads what passes through it: computed once more from the hand's side, or from the link's."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.joint_log import Float
from friction_audit.simulation.bench import BenchSettings, simulate_bench
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import Backlash, JointElasticity
from friction_audit.simulation.effects.velocity import Presliding, Stiction
from friction_audit.simulation.settings import IDEAL_SENSORS, make_streams

SEED = 3
IDEAL = BenchSettings(duration_s=12.0, sensors=(IDEAL_SENSORS,))
GRAVITY_NM, PHASE_RAD = 8.0, 0.4
LOADED = replace(IDEAL, logs_sensor=True, gravity_nm=GRAVITY_NM, gravity_phase_rad=PHASE_RAD)

ELASTIC = Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=1e-3))
HIDDEN = {
    "rigid": Hidden(),
    "elastic": ELASTIC,
    "backlash": Hidden(backlash=Backlash(gap_rad=5e-3)),
    "presliding": Hidden(presliding=Presliding(displacement_rad=0.005)),
    "stiction": Hidden(stiction=Stiction(excess_nm=0.2)),
}


def drive_torque(settings: BenchSettings, q: Float, dq: Float) -> Float:
    """Return the torque of the operator's spring and damper, shape (n + 1,)."""
    hand, ticks = settings.operator, len(q) - 1
    wanted = hand.motion.intend(ticks, 1e-3, make_streams(SEED, 1).person)
    spring, damper = hand.stiffness_nm_per_rad, hand.damping_nms_per_rad
    return np.asarray(spring * (wanted.position - q) + damper * (wanted.velocity - dq))


def impulse(t: Float, torque: Float) -> Float:
    """Return the integral of a torque over time, shape (n + 1,). [N m s]"""
    return np.concatenate([[0.0], np.cumsum(0.5 * (torque[1:] + torque[:-1]) * np.diff(t))])


@pytest.mark.parametrize("name", HIDDEN)
def test_interaction_torque_is_what_the_hand_exerts_less_its_own_inertia(name: str) -> None:
    """In impulses: integral F_m dt = integral of the hand's spring and damper - m_hand dq, at every tick."""
    settings = replace(IDEAL, hidden=(HIDDEN[name],))
    simulation = simulate_bench(settings, SEED)
    log = simulation.log
    assert log.tau_interaction is not None
    q, dq = log.q[:, 0], log.dq[:, 0]
    hand = impulse(log.t, drive_torque(settings, q, dq)) - settings.operator.inertia_kg_m2 * dq
    sensor = impulse(log.t, log.tau_interaction[:, 0])
    assert np.ptp(sensor) > 0.5
    ringing = name in ("elastic", "backlash")
    assert_allclose(sensor, hand, atol=5e-3 if ringing else 5e-4)


@pytest.mark.parametrize("name", HIDDEN)
def test_sensor_under_a_load_reads_gravity_less_the_interaction(name: str) -> None:
    """tau_J = g(q) - F_m, F_m the hand's torque less the hand's inertia; the motor bears g(q)."""
    settings = replace(LOADED, hidden=(HIDDEN[name],))
    simulation = simulate_bench(settings, SEED)
    log, motion = simulation.log, simulation.truth.motion
    assert log.tau_J is not None
    assert log.gravity is not None
    weight = GRAVITY_NM * np.sin(log.q + PHASE_RAD)
    assert_allclose(log.gravity, weight, atol=1e-6)
    assert_allclose(motion.support_nm, weight, atol=2e-3)
    hand = impulse(log.t, drive_torque(settings, log.q[:, 0], log.dq[:, 0])) - 0.3 * log.dq[:, 0]
    ringing = name in ("elastic", "backlash")
    assert_allclose(impulse(log.t, (weight - log.tau_J)[:, 0]), hand, atol=2e-2 if ringing else 1e-3)


@pytest.mark.parametrize("name", ["rigid", "elastic", "presliding"])
def test_sensor_of_a_driven_joint_carries_inertia_gravity_and_friction_of_the_link(name: str) -> None:
    """tau_J = J ddq + g(q) + tau_f."""
    settings = replace(LOADED, driven=True, hidden=(HIDDEN[name],))
    simulation = simulate_bench(settings, SEED)
    log, motion = simulation.log, simulation.truth.motion
    assert log.tau_J is not None
    link = 0.3 * motion.inner_ddq + GRAVITY_NM * np.sin(log.q + PHASE_RAD) + motion.friction_nm
    assert_allclose(log.tau_J, link, atol=2e-3)
    sliding = (motion.inner_dq != 0.0) & (name != "presliding")
    dry = 0.30 * np.sign(motion.inner_dq) + 0.07 * motion.inner_dq
    assert_allclose(motion.friction_nm[sliding], dry[sliding], atol=1e-12)
    assert_allclose(log.q, motion.inner_q)
