"""A factor whose shape the log leaves open reaches over all shapes that it does not rule out, and no further."""

import numpy as np
import pytest

from friction_audit.diagnosis.alternatives import Naming
from friction_audit.diagnosis.declared import coefficients
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.kept_shapes import over_kept_shapes
from friction_audit.diagnosis.naming import Found
from friction_audit.effects.joint_data import JointData
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.toy_candidates import BUMP, altered

FAR = altered(BUMP, grid=tuple({"place_rad": 3.0, "width_rad": width} for width in (1.0, 1.3, 1.6, 2.0)))
"""Its top lies where the joint never comes: the log sees a flank, and the wider the bump the smaller it is."""
HEIGHT, WIDTH = 1.0, 1.3


def flank(data: JointData) -> Float:
    return HEIGHT * np.exp(-(((data.q - 3.0) / WIDTH) ** 2))


def reach(ground: Ground, width: float) -> tuple[Coefficient, Coefficient]:
    """The factor with the shape as it is, and over all shapes."""
    shape = {"place_rad": 3.0, "width_rad": width}
    own = Found(
        candidate=FAR,
        shape=shape,
        columns=ground.rows.of(FAR.regressor(ground.data, ground.baseline(), shape)),
        naming=Naming(name=FAR.name, rivals=(), alternatives=()),
        p_value=0.01,
    )
    linear = coefficients(np.hstack([ground.base, own.columns]), ground.y, ground.rows.cycle)
    return linear[-1], over_kept_shapes(ground, [own], 0, ground.baseline(), linear)[-1]


def test_it_reaches_the_truth_from_another_shape_that_fits() -> None:
    alone, reached = reach(make_ground(moved_joint(flank, noise_nm=0.05, duration_s=20.0), None, 0), 1.6)
    assert alone.high < HEIGHT
    assert reached.value == pytest.approx(alone.value)
    assert reached.low <= alone.low + 1e-9
    assert reached.high >= HEIGHT


def test_a_log_without_noise_rules_the_others_out() -> None:
    alone, reached = reach(make_ground(moved_joint(flank, duration_s=20.0), None, 0), WIDTH)
    assert (reached.low, reached.high) == pytest.approx((alone.low, alone.high), rel=1e-9)
