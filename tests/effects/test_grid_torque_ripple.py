"""The orders tried leave no gap, and a vibration is no ripple."""

import numpy as np
import pytest

from friction_audit.effects import torque_ripple
from tests.effects.explained import share_explained
from tests.effects.joint_data_by_hand import two_sines

DATA = two_sines()
ORDERS = [shape["ripple_order"] for shape in torque_ripple.EFFECT.grid(DATA)]


def test_orders_begin_at_two_periods_over_the_range() -> None:
    assert ORDERS[0] * np.ptp(DATA.q[DATA.used]) == pytest.approx(4.0 * np.pi)
    assert np.ptp(np.diff(ORDERS)) < 1e-9
    assert (ORDERS[1] - ORDERS[0]) * float(np.std(DATA.q[DATA.used])) <= 1.4 + 1e-9


@pytest.mark.parametrize("between", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("at", [0, 20, 60])
def test_a_ripple_between_two_orders_is_found(at: int, between: float) -> None:
    order = ORDERS[at] + between * (ORDERS[1] - ORDERS[0])
    assert share_explained(torque_ripple.EFFECT, DATA, np.sin(order * DATA.q + 0.4)) > 0.55


def test_a_vibration_of_one_frequency_is_no_ripple() -> None:
    assert share_explained(torque_ripple.EFFECT, DATA, np.sin(2.0 * np.pi * 12.0 * DATA.t)) < 0.05
