import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.effects.time_delay import delayed

DT = 1e-4
SIGNAL = np.random.default_rng(0).normal(size=50)


@pytest.mark.parametrize("steps", [1, 7, 30, 49, 80])
def test_whole_steps_shift_the_samples_themselves(steps: int) -> None:
    late = delayed(SIGNAL, steps * DT, DT)
    assert_array_equal(late[steps:], SIGNAL[: max(0, 50 - steps)])
    assert_array_equal(late[:steps], SIGNAL[0])


def test_fraction_of_a_step_is_read_linearly() -> None:
    ramp = np.arange(50.0)
    assert_allclose(delayed(ramp, 2.25 * DT, DT)[3:], ramp[3:] - 2.25)
    assert_allclose(delayed(ramp, 2.25 * DT, DT)[:3], 0.0)


def test_columns_are_delayed_alike() -> None:
    table = np.column_stack((SIGNAL, 2 * SIGNAL))
    late = delayed(table, 3.5 * DT, DT)
    assert_array_equal(late, np.column_stack((delayed(SIGNAL, 3.5 * DT, DT), 2 * delayed(SIGNAL, 3.5 * DT, DT))))


def test_no_delay_is_the_very_same_array() -> None:
    assert delayed(SIGNAL, 0.0, DT) is SIGNAL


@given(delay=st.floats(1e-6, 6e-3))
def test_delay_line_never_overshoots(delay: float) -> None:
    late = delayed(SIGNAL, delay, DT)
    assert SIGNAL.min() - 1e-12 <= late.min()
    assert late.max() <= SIGNAL.max() + 1e-12
