"""What differs between the directions of motion, a sensor's zero and a wrong inertia, by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms import asymmetric_coulomb, asymmetric_viscous, inertia_error, torque_bias
from tests.effects.arm_motion import DQ, N, among_three


def test_half_the_difference_of_coulomb_friction_acts_in_motion_only() -> None:
    torque = asymmetric_coulomb.TERM.torque((0.2,), among_three())
    assert torque == pytest.approx([0.2, 0.2, 0.0, 0.2, 0.2])


def test_half_the_difference_of_viscous_friction_grows_with_speed() -> None:
    torque = asymmetric_viscous.TERM.torque((0.2,), among_three())
    assert torque == pytest.approx([0.2, 0.1, 0.0, 0.1, 0.2])


def test_a_bias_is_there_at_rest_too() -> None:
    assert torque_bias.TERM.torque((0.2,), among_three()) == pytest.approx(np.full(N, 0.2))


def test_inertia_that_was_not_stated() -> None:
    assert inertia_error.TERM.torque((0.5,), among_three()) == pytest.approx(1.5 * DQ)
