import pytest

from friction_audit.simulation.effects.asymmetric_coulomb import AsymmetricCoulomb, extra_nm
from friction_audit.simulation.mechanics.records import pack


@pytest.mark.parametrize("half_difference", [0.08, -0.08])
def test_what_one_direction_gains_the_other_loses(half_difference: float) -> None:
    group = pack([AsymmetricCoulomb(half_difference_nm=half_difference)])[0]
    assert extra_nm(group, 1.0) == half_difference
    assert extra_nm(group, -1.0) == -half_difference


def test_half_a_difference_may_be_negative() -> None:
    assert AsymmetricCoulomb.make({"half_difference_nm": "-0.1"}) == AsymmetricCoulomb(half_difference_nm=-0.1)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nothing_hidden_is_exactly_zero(sign: float) -> None:
    assert extra_nm(pack([AsymmetricCoulomb()])[0], sign) == 0.0
