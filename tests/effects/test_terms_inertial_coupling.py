"""Inertial coupling by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.inertial_coupling import AFTER, ALL, BEFORE, BOTH, JOINTS, MODEL, TERM, TIP
from tests.effects.arm_motion import N, among_three, rigid_body
from tests.effects.motion_by_hand import motion_of


@pytest.mark.parametrize(("source", "accelerations"), [(BEFORE, {0: 1.0}), (AFTER, {2: 3.0}), (BOTH, {0: 1.0, 2: 3.0})])
def test_accelerations_of_neighbours(source: int, accelerations: dict[int, float]) -> None:
    columns = TERM.regressor(among_three(), (source,))
    expected = np.zeros((N, len(TERM.coefficients)))
    for joint, value in accelerations.items():
        expected[:, joint] = value
    assert columns == pytest.approx(expected)


def test_all_others_with_their_squared_speeds_and_never_itself() -> None:
    columns = TERM.regressor(among_three(), (ALL,))
    assert columns[0, :3] == pytest.approx([1.0, 0.0, 3.0])
    assert columns[0, JOINTS : JOINTS + 3] == pytest.approx([4.0, 0.0, 36.0])


def test_a_share_of_what_the_model_says_and_its_last_link() -> None:
    motion = among_three(rigid=rigid_body())
    names = [parameter.name for parameter in TERM.coefficients]
    share = names.index("inertial_torque_share")
    model, tip = TERM.regressor(motion, (MODEL,)), TERM.regressor(motion, (TIP,))
    assert np.flatnonzero(model.any(axis=0)).tolist() == [share]
    assert model[:, share] == pytest.approx(np.full(N, 30.0))
    assert tip[0, share:] == pytest.approx([30.0, *range(40, 50)])


@pytest.mark.parametrize("source", range(6))
def test_a_single_joint_has_none(source: int) -> None:
    assert not TERM.regressor(motion_of(dq=[1.0, -1.0]), (source,)).any()
