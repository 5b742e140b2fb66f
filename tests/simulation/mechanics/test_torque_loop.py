"""Joint torque control with its motor's friction inside: what can be known by hand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from friction_audit.errors import UsageError
from friction_audit.simulation.bench import BenchSettings, Operator, simulate_bench
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import JointElasticity
from friction_audit.simulation.motion import Sinusoid
from friction_audit.simulation.settings import IDEAL_SENSORS, JointParameters, TorqueLoop
from tests.simulation.mechanics.any_step import bench, release

MOTOR, LINK, STIFFNESS, GAIN, DAMPING_S = 0.3, 1.0, 1e4, 4.0, 0.004
GEAR = Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=1.0 / STIFFNESS, damping_ratio=0.0))


def joint(coulomb_nm: float = 0.0, viscous: float = 0.0, **loop: float) -> JointParameters:
    control = TorqueLoop(**{"gain": GAIN, "damping_s": DAMPING_S} | loop)
    return JointParameters(inertia_kg_m2=MOTOR, coulomb_nm=coulomb_nm, viscous_nms_per_rad=viscous, torque_loop=control)


def critical_dead_time_s() -> float:
    """Of s^2 + K (1/B + 1/m) + K/B (k + d s) e^(-s T) = 0 with an imaginary root."""
    rigid = STIFFNESS * (1.0 / MOTOR + 1.0 / LINK)
    w = brentq(lambda w: w * w - rigid - STIFFNESS / MOTOR * np.hypot(GAIN, DAMPING_S * w), 1.0, 1e5)
    return float(np.arctan2(DAMPING_S * w, GAIN) / w)


@pytest.mark.parametrize("gain", [1.0, 4.0, 9.0])
def test_friction_and_inertia_at_the_link_are_those_of_the_motor_over_one_plus_the_gain(gain: float) -> None:
    settings = BenchSettings(
        joints=(joint(0.3, 0.1, gain=gain, dead_time_s=0.0003),),
        hidden=(GEAR,),
        sensors=(IDEAL_SENSORS,),
        operator=Operator(motion=Sinusoid()),
        duration_s=12.0,
    )
    motion = simulate_bench(settings, 1).truth.motion
    dq, ddq, torque = (values[:, 0] for values in (motion.inner_dq, motion.inner_ddq, motion.interaction_nm))
    sliding = np.abs(dq) > 0.1
    columns = np.stack([ddq, np.sign(dq), dq], axis=1)[sliding]
    found = np.linalg.lstsq(columns, torque[sliding], rcond=None)[0]
    assert_allclose(found, np.array([MOTOR, 0.3, 0.1]) / (1.0 + gain), rtol=0.02)
    link = settings.joints[0].at_link
    assert_allclose([link.inertia_kg_m2, link.coulomb_nm, link.viscous_nms_per_rad], found, rtol=0.02)


@pytest.mark.parametrize(("beyond_s", "grows"), [(-1.5e-4, False), (1e-4, True)])
def test_the_loop_rings_from_the_dead_time_of_its_characteristic_equation(beyond_s: float, *, grows: bool) -> None:
    """The torque is held for a step of 0.1 ms, half a step more of dead time."""
    settings = bench(joint(dead_time_s=critical_dead_time_s() + beyond_s), GEAR, inertia_kg_m2=LINK)
    motion = release(settings, 0.5, q=(0.0, 1e-4))
    twist = np.abs(motion.inner_q - motion.q)[:, 0]
    last, first = twist[-500:].max(), twist[250:750].max()
    assert (last > 2.0 * first) == grows
    assert (last < 0.5 * first) != grows


def test_energy_is_what_the_torque_control_put_in_and_friction_took() -> None:
    """Its work by the law, written down again here, with a dead time of ten ticks of 0.02 ms."""
    delay, tick_s = 10, 2e-5
    settings = bench(joint(0.05, 0.1, dead_time_s=delay * tick_s), GEAR, inertia_kg_m2=LINK)
    motion = release(settings, 0.2, step_s=0.5 * tick_s, q=(0.0, 2e-3))
    q, theta, dq, dtheta = (v[:, 0] for v in (motion.q, motion.inner_q, motion.dq, motion.inner_dq))
    law = -STIFFNESS * (GAIN * (theta - q) + DAMPING_S * (dtheta - dq))
    acted = np.concatenate([np.zeros(delay), law[:-delay]])
    work = np.concatenate([[0.0], np.cumsum(0.5 * (acted[1:] + acted[:-1]) * np.diff(theta))])
    stored = 0.5 * (MOTOR * dtheta**2 + LINK * dq**2 + STIFFNESS * (theta - q) ** 2)
    assert_allclose(stored + motion.dissipated_j[:, 0], stored[0] + work, atol=0.01 * stored.max())
    assert work[-1] < -0.5 * stored[0]


@pytest.mark.parametrize("changed", [{"hidden": (Hidden(),)}, {"driven": True, "logs_sensor": True}])
def test_it_takes_an_elastic_joint_that_a_hand_moves(changed: dict[str, object]) -> None:
    settings = BenchSettings(joints=(joint(),), hidden=(GEAR,), duration_s=1.0)
    with pytest.raises(UsageError, match="expected a hand that moves an elastic joint"):
        simulate_bench(replace(settings, **changed), 0)  # type: ignore[arg-type]
