import pytest

from friction_audit.simulation.effects.asymmetric_viscous import AsymmetricViscous, extra_nm
from friction_audit.simulation.mechanics.records import pack


@pytest.mark.parametrize("half_difference", [0.03, -0.03])
def test_what_one_direction_gains_the_other_loses(half_difference: float) -> None:
    group = pack([AsymmetricViscous(half_difference_nms_per_rad=half_difference)])[0]
    assert extra_nm(group, 1.0, 2.0) == 2.0 * half_difference
    assert extra_nm(group, -1.0, 2.0) == -2.0 * half_difference
    assert extra_nm(group, 1.0, 0.0) == 0.0


def test_half_a_difference_may_be_negative() -> None:
    group = AsymmetricViscous.make({"half_difference_nms_per_rad": "-0.1"})
    assert group == AsymmetricViscous(half_difference_nms_per_rad=-0.1)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nothing_hidden_is_exactly_zero(sign: float) -> None:
    assert extra_nm(pack([AsymmetricViscous()])[0], sign, 2.0) == 0.0
