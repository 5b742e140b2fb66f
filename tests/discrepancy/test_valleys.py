"""The lowest valley of a play's misfit over its width."""

import numpy as np
import pytest

from friction_audit.discrepancy.beside import Beside
from friction_audit.discrepancy.candidates.backlash import CANDIDATE as BACKLASH
from friction_audit.discrepancy.ground import Ground, make_ground
from friction_audit.discrepancy.valleys import FARTHEST, around, lowest_valley, valleys
from friction_audit.joint_log import Float
from tests.discrepancy.moved_joint import moved_joint
from tests.discrepancy.test_profile_likelihood import GAP_RAD, play


@pytest.fixture(scope="module")
def ground() -> Ground:
    return make_ground(moved_joint(play, noise_nm=0.02, duration_s=60.0), None, 0)


def columns(ground: Ground, width: float) -> Float:
    return ground.rows.of(BACKLASH.columns(ground.data, ground.baseline(), {"gap_rad": width, "contact_hz": 22.0}))


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
    assert best["contact_hz"] in {22.0, *(one["contact_hz"] for one in BACKLASH.beside_rugged)}
    assert least <= beside.fit(columns(ground, GAP_RAD))[1]


@pytest.mark.parametrize("begin", [0.65, 1.5])
def test_the_width_is_found_though_the_declared_model_is_a_little_wrong(ground: Ground, begin: float) -> None:
    shape = {"gap_rad": begin * GAP_RAD, "contact_hz": 22.0}
    own, nothing = columns(ground, begin * GAP_RAD), np.zeros((len(ground.y), 0))
    found, better = lowest_valley(BACKLASH, shape, own, ground, nothing)
    assert found["gap_rad"] == pytest.approx(GAP_RAD, rel=0.1)
    working = Beside(ground.base[ground.working], ground.y[ground.working])
    assert working.fit(better[ground.working])[1] < 0.7 * working.fit(own[ground.working])[1]


def test_where_no_width_leaves_less_the_shape_stays(ground: Ground) -> None:
    shape = {"gap_rad": 40.0 * GAP_RAD, "contact_hz": 22.0}
    perfect = ground.residual()[:, None]
    found, same = lowest_valley(BACKLASH, shape, perfect, ground, np.zeros((len(ground.y), 0)))
    assert found == shape
    assert same is perfect
