"""The lowest valley of a play's misfit over its width."""

import numpy as np
import pytest

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.valleys import FARTHEST, around, valleys
from friction_audit.effects.backlash import EFFECT as BACKLASH
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.test_profile_likelihood import GAP_RAD, play


@pytest.fixture(scope="module")
def ground() -> Ground:
    return make_ground(moved_joint(play, noise_nm=0.02, duration_s=60.0), None, 0)


def columns(ground: Ground, width: float) -> Float:
    return ground.rows.of(BACKLASH.regressor(ground.data, ground.baseline(), {"gap_rad": width, "contact_hz": 22.0}))


def test_values_lie_on_both_sides_of_one_and_are_that_one_too() -> None:
    tried = around(2.0)
    assert (min(tried), max(tried)) == pytest.approx((2.0 / FARTHEST, 2.0 * FARTHEST))
    assert 2.0 in np.round(tried, 12)


def test_of_each_width_the_best_flanks_are_kept(ground: Ground) -> None:
    beside = Beside(ground.base, ground.y)
    shape = {"gap_rad": GAP_RAD, "contact_hz": 22.0}
    found = valleys(BACKLASH, shape, [GAP_RAD], ground, ground.baseline(), beside)
    least, best = found[GAP_RAD]
    assert list(found) == [GAP_RAD]
    assert best["contact_hz"] in {22.0, *(one["contact_hz"] for one in BACKLASH.multimodal_with)}
    assert least <= beside.fit(columns(ground, GAP_RAD))[1] * (1.0 + 1e-9)
