"""Friction of a joint of the Panda whose torque holds all of the arm's dynamics, with no model given (by MuJoCo)."""

import numpy as np
import pytest

from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.samples import least_squares
from friction_audit.robot import load_arm
from tests.effects.joint_data_by_hand import joint_of, sines


def test_the_dynamics_of_an_unknown_chain_leave_its_friction() -> None:
    rng, t = np.random.default_rng(0), np.arange(0.0, 90.0, 0.005)
    moved = [
        sines(t, *zip(rng.uniform(0.1, 0.3, 3), rng.uniform(0.5, 3.0, 3), rng.uniform(0.0, 6.0, 3), strict=True))
        for _ in range(7)
    ]
    q, dq, ddq = (np.column_stack(one) for one in zip(*moved, strict=True))
    q -= [0.0, 0.3, 0.0, 1.8, 0.0, -1.8, 0.0]
    arm = load_arm()
    rigid = arm.inverse_dynamics(q, dq, ddq)[:, 1]
    torque = rigid + 3.0 * np.sign(dq[:, 1]) + 2.0 * dq[:, 1] + rng.normal(scale=0.05, size=len(t))
    others = {"others_q": q, "others_dq": dq, "others_ddq": ddq, "others_torque": np.zeros_like(q)}
    data = joint_of(t, q[:, 1], dq[:, 1], ddq[:, 1], torque, joint=1, weighs=True, unknown_gravity=True, **others)
    problem = RegressionProblem.build(data, None)
    assert problem.data.load is not None
    assert np.std(problem.data.load - arm.gravity(q)[:, 1]) < 0.1 * np.std(rigid)
    named = problem.columns(np.column_stack([np.cos(q[:, 1]), np.sin(q[:, 1]), ddq, dq**2]))  # effects of their own
    found = least_squares(np.vstack([problem.X, named]).T, problem.y)
    assert problem.nominal.names[:2] == ("coulomb_nm", "viscous_nms_per_rad")
    assert (found[0], found[1]) == (pytest.approx(3.0, rel=0.03), pytest.approx(2.0, rel=0.1))
