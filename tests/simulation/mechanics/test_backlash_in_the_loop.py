"""A gap between the sides of the joint: what it transmits, and what its impacts take."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.joint_log import Float
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import Backlash, JointElasticity
from friction_audit.simulation.settings import JointParameters
from friction_audit.simulation.simulation import TrueMotion
from tests.simulation.mechanics.any_step import bench, release

GAP = 0.02
MOTOR, LINK = 0.3, 0.2
LOOSE = JointParameters(inertia_kg_m2=MOTOR, coulomb_nm=0.0, viscous_nms_per_rad=0.0)


def stretch(motion: TrueMotion) -> Float:
    return (motion.inner_q - motion.q)[:, 0]


def beyond(motion: TrueMotion) -> Float:
    """Return by how much the stretch is beyond the gap, signed."""
    return np.asarray(np.sign(stretch(motion)) * np.maximum(np.abs(stretch(motion)) - GAP / 2, 0.0))


def collide(damping_ratio: float, compliance: float = 0.0) -> TrueMotion:
    """Let the link, at 0.5 rad/s, run to and fro in the gap of a motor at rest."""
    flanks = Backlash(gap_rad=GAP, contact_damping_ratio=damping_ratio)
    elastic = JointElasticity(compliance_rad_per_nm=compliance)
    hidden = Hidden(backlash=flanks, joint_elasticity=elastic)
    return release(bench(LOOSE, hidden, inertia_kg_m2=LINK), 0.6, dq=(0.5, 0.0))


def energy(motion: TrueMotion, compliance: float) -> Float:
    kinetic = 0.5 * MOTOR * motion.inner_dq**2 + 0.5 * LINK * motion.dq**2
    return np.asarray(kinetic[:, 0] + 0.5 * beyond(motion) ** 2 / compliance)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.2, 1.0])
def test_impacts_keep_momentum_and_never_add_energy(damping_ratio: float) -> None:
    motion = collide(damping_ratio)
    assert_allclose(MOTOR * motion.inner_dq + LINK * motion.dq, LINK * 0.5, atol=1e-12)
    held = energy(motion, 1e-4)
    lost = held[0] - held[-1]
    at_stake = held[0] - 0.5 * (LINK * 0.5) ** 2 / (MOTOR + LINK)
    assert np.diff(held).max() < 3e-4 * held[0]
    assert -2e-4 * held[0] < lost < at_stake
    assert lost > 0.9 * at_stake if damping_ratio else abs(lost) < 2e-4 * held[0]


def test_torque_rests_at_nothing_while_the_hand_crosses_the_gap() -> None:
    """Friction stops the motor sooner than the hand turns round; the hand then crosses the gap without a torque."""
    stiff = {"stiffness_nm_per_rad": 2000.0, "damping_nms_per_rad": 60.0}
    settings = bench(JointParameters(), Hidden(backlash=Backlash(gap_rad=GAP)), **stiff)
    tick, reach, pace = 1e-3, 0.1, np.pi / 2.0
    t = np.arange(4001) * tick
    push = 2000.0 * reach * (1.0 - np.cos(pace * t)) + 60.0 * reach * pace * np.sin(pace * t)
    motion = release(settings, 4.0, tick_s=tick, push=push)
    crossing = (motion.t > 1.5) & (motion.t < 3.0) & (beyond(motion) == 0.0)
    assert_allclose(motion.port_nm[crossing], 0.0, atol=1e-12)
    assert_array_equal(motion.inner_dq[crossing], 0.0)
    assert_allclose(np.ptp(motion.q[crossing]), GAP, atol=4e-4)
    assert_allclose(crossing.sum() * tick, np.arccos(1.0 - GAP / reach) / pace, rtol=0.05)
    pulling = (motion.t > 3.2) & (motion.t < 3.6)
    assert_allclose(motion.port_nm[pulling], (0.3 * motion.inner_ddq - 0.30 + 0.07 * motion.inner_dq)[pulling])
