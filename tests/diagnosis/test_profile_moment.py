"""How well the moment of a step of friction is known."""

import pytest

from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.profile_moment import moment_interval
from friction_audit.effects.friction_step import EFFECT as CANDIDATE
from friction_audit.effects.joint_data import JointData
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint

MOMENT_S = 31.4


def interval(step_nm: float, seed: int) -> Coefficient:
    def step(data: JointData) -> Float:
        return step_nm * data.motion().direction * (data.t > MOMENT_S)

    data = moved_joint(step, noise_nm=0.02, seed=seed)
    ground = make_ground(data, None, 0)
    shape = {"step_time_s": MOMENT_S, "step_length_s": 1e-5 * 60.0}
    return moment_interval(CANDIDATE, shape, ground, ground.baseline(), ground.base)


@pytest.mark.parametrize("seed", range(4))
def test_it_holds_the_moment_and_is_the_narrower_the_larger_the_step(seed: int) -> None:
    small, large = interval(0.02, seed), interval(0.2, seed)
    assert small.low <= MOMENT_S <= small.high
    assert large.low <= MOMENT_S <= large.high
    assert large.high - large.low < 0.2 * (small.high - small.low)
    assert small.high - small.low < 15.0
