"""What slides and what holds, by hand."""

import numpy as np
from numpy.testing import assert_allclose

from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.asymmetric_viscous import AsymmetricViscous
from friction_audit.simulation.settings import JointParameters
from tests.simulation.mechanics.any_step import bench, release

VISCOUS = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.0, viscous_nms_per_rad=0.1)


def test_asymmetric_viscous_friction_needs_no_coulomb_friction() -> None:
    hidden = Hidden(asymmetric_viscous=AsymmetricViscous(half_difference_nms_per_rad=0.04))
    for sign, coefficient in ((1.0, 0.14), (-1.0, 0.06)):
        motion = release(bench(VISCOUS, hidden), 0.5, dq=(sign, sign))
        assert_allclose(motion.dq[:, 0], sign * np.exp(-coefficient / 0.6 * motion.t), rtol=1e-6)
        assert_allclose(motion.friction_nm, coefficient * motion.dq, rtol=1e-9)


def test_asymmetric_viscous_friction_never_drives() -> None:
    hidden = Hidden(asymmetric_viscous=AsymmetricViscous(half_difference_nms_per_rad=0.2))
    motion = release(bench(VISCOUS, hidden), 0.5, dq=(-1.0, -1.0))
    assert_allclose(motion.dq, -1.0, atol=1e-12)
