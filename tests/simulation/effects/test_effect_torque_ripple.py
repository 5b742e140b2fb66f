import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.effects.torque_ripple import COGGING, READING, TorqueRipple, reading_nm, torque_nm
from friction_audit.simulation.mechanics.records import pack


def test_cogging_by_hand() -> None:
    record = pack([TorqueRipple(torque_nm=0.1, second_share=0.3)])[0]
    assert torque_nm(record, 0.0) == pytest.approx(0.03)
    assert torque_nm(record, math.pi / 400) == pytest.approx(0.1 - 0.03)


def test_reading_by_hand() -> None:
    group = TorqueRipple(torque_nm=0.1, second_share=0.3, form=READING)
    assert_allclose(reading_nm(group, np.array([0.0, math.pi / 800])), [0.1, 0.1 * math.sqrt(0.5) + 0.03])


def test_ripple_is_periodic_and_gives_back_what_it_took() -> None:
    group = TorqueRipple(torque_nm=0.1)
    cycle = np.linspace(0.0, 2 * math.pi / 200, 64, endpoint=False)
    torque = np.array([torque_nm(pack([group])[0], q) for q in cycle])
    again = np.array([torque_nm(pack([group])[0], q + 2 * math.pi / 200) for q in cycle])
    assert_allclose(again, torque, atol=1e-12)
    assert_allclose(torque.mean(), 0.0, atol=1e-15)


@given(q=st.floats(-7, 7))
def test_each_form_leaves_the_other_path_alone(q: float) -> None:
    for group in (TorqueRipple(), TorqueRipple(form=READING), TorqueRipple(torque_nm=0.1, form=READING)):
        assert torque_nm(pack([group])[0], q) == 0.0
    for group in (TorqueRipple(), TorqueRipple(form=READING), TorqueRipple(torque_nm=0.1, form=COGGING)):
        assert_array_equal(reading_nm(group, np.array([q])), [0.0])
