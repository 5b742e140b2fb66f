"""Rest is rest: where it begins, what it bears, when it ends."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.joint_log import Float
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.velocity import IMMEDIATE, AsymmetricCoulomb, Stiction
from friction_audit.simulation.settings import JointParameters
from friction_audit.simulation.simulation import TrueMotion
from tests.simulation.mechanics.any_step import bench, release

JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
TICK_S = 1e-3


def pushed(push: Float, hidden: Hidden | None = None, speed: float = 0.0) -> TrueMotion:
    """Push a joint, hand and all 0.6 kg m^2, by a torque and nothing else."""
    duration = (len(push) - 1) * TICK_S
    return release(bench(JOINT, hidden), duration, tick_s=TICK_S, push=push, dq=(speed, speed))


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("hidden", "level"),
    [
        (Hidden(), {1.0: 0.3, -1.0: 0.3}),
        (Hidden(stiction=Stiction(excess_nm=0.2, form=IMMEDIATE)), {1.0: 0.5, -1.0: 0.5}),
        (Hidden(asymmetric_coulomb=AsymmetricCoulomb(half_difference_nm=0.1)), {1.0: 0.4, -1.0: 0.2}),
    ],
)
def test_break_away_at_the_level_and_not_before(hidden: Hidden, level: dict[float, float], way: float) -> None:
    t = np.arange(2001, dtype=np.float64) * TICK_S
    motion = pushed(0.5 * way * t, hidden)
    moving = motion.dq[:, 0] != 0.0
    assert_allclose(motion.t[moving][0], level[way] / 0.5, atol=1.01 * TICK_S)
    assert moving[np.flatnonzero(moving)[0] :].all()
    assert_array_equal(motion.q[~moving], 0.0)
    assert_allclose(motion.friction_nm[~moving, 0], 0.5 * way * motion.t[~moving], atol=1e-15)


def test_coasting_stops_for_good_where_it_must() -> None:
    """M dv = -(Fc + Fv v) dt: at rest after M/Fv ln(1 + Fv v/Fc), exactly, and without having turned."""
    motion = pushed(np.zeros(2001), speed=0.5)
    stop = 0.6 / 0.07 * np.log1p(0.07 * 0.5 / 0.3)
    place = 0.6 / 0.07 * (0.5 - 0.3 / 0.07 * np.log1p(0.07 * 0.5 / 0.3))
    rest = motion.t > stop + TICK_S
    assert_array_equal(motion.dq[rest], 0.0)
    assert_array_equal(np.diff(motion.q[rest], axis=0), 0.0)
    assert (motion.dq >= 0.0).all()
    assert_allclose(motion.q[-1, 0], place, rtol=1e-7)
    assert_allclose(motion.dissipated_j[-1, 0], 0.5 * 0.6 * 0.25, rtol=1e-12)


def test_rest_bears_what_pulls_and_no_more() -> None:
    t = np.arange(4001) * TICK_S
    motion = pushed(0.31 * np.sin(2.0 * np.pi * t))
    rest = motion.dq[:, 0] == 0.0
    assert 0.3 < rest.mean() < 1.0
    assert np.abs(motion.friction_nm[rest]).max() <= 0.3
    assert_allclose(motion.friction_nm[rest, 0], 0.31 * np.sin(2.0 * np.pi * t[rest]), atol=1e-12)
    inertia, viscous = 0.3 * motion.inner_ddq, 0.07 * motion.dq
    assert_allclose(motion.port_nm, inertia + motion.friction_nm, atol=1e-15)
    assert_allclose((motion.friction_nm - viscous)[~rest], 0.3 * np.sign(motion.dq[~rest]), atol=1e-12)
