import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.simulation.effects.backlash import Backlash, contact_damping_nms_per_rad, contact_nm, engaged
from friction_audit.simulation.mechanics.records import pack

GAP = pack([Backlash(gap_rad=2e-3)])[0]


@pytest.mark.parametrize(
    ("stretch", "left"), [(0.0, 0.0), (1e-3, 0.0), (-0.9e-3, 0.0), (1.5e-3, 0.5e-3), (-1.5e-3, -0.5e-3)]
)
def test_dead_zone(stretch: float, left: float) -> None:
    assert engaged(GAP, stretch) == pytest.approx(left, abs=1e-18)


def test_contact_is_a_spring_and_a_damper() -> None:
    assert contact_nm(GAP, 0.5e-3) == pytest.approx(5.0)
    assert contact_nm(GAP, -0.5e-3) == pytest.approx(-5.0)
    assert contact_damping_nms_per_rad(GAP, 0.15) == pytest.approx(2 * 0.2 * math.sqrt(1e4 * 0.15))


@given(stretch=st.floats(-1, 1))
def test_without_a_gap_the_stretch_is_left_as_it_is(stretch: float) -> None:
    assert engaged(pack([Backlash()])[0], stretch) == stretch
