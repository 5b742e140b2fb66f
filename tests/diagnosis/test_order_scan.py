"""A scan of all orders: the gain that least squares gives, and the order of a wave that is there."""

import numpy as np
import pytest

from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.order_scan import scan_orders
from friction_audit.diagnosis.rows import make_rows
from tests.diagnosis.moved_joint import moved_joint

ORDER = 113.7
DATA = moved_joint(duration_s=40.0)
ROWS = make_rows(DATA)
AT = np.flatnonzero(ROWS.used) * ROWS.every


def scanned(residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    spikes = np.zeros(len(DATA.t))
    spikes[AT] = residual
    back = np.convolve(spikes, ROWS.kernel, mode="same")
    return scan_orders(back, DATA.q, np.abs(DATA.dq[AT]), 20.0, 300.0, ROWS.kernel, DATA.step_s)


def test_the_order_of_a_wave_is_found_between_those_of_any_grid() -> None:
    order, gain = scanned(ROWS.of(0.1 * np.cos(ORDER * DATA.q + 0.4)))
    assert order[0] >= 20.0
    assert order[-1] <= 300.0
    assert order[np.argmax(gain)] == pytest.approx(ORDER, abs=2.0 * np.pi / (8.0 * np.ptp(DATA.q)))


def test_the_gain_is_that_of_least_squares() -> None:
    residual = ROWS.of(0.1 * np.sin(ORDER * DATA.q)) + 0.1 * np.random.default_rng(0).standard_normal(len(AT))
    order, gain = scanned(residual)
    best = int(np.argmax(gain))
    columns = ROWS.of(np.column_stack([np.cos(order[best] * DATA.q), np.sin(order[best] * DATA.q)]))
    left = residual - columns @ least_squares(columns, residual)
    assert gain[best] == pytest.approx(float(residual @ residual - left @ left), rel=0.05)


def test_orders_that_the_filter_swallows_gain_nothing() -> None:
    spikes = np.random.default_rng(1).standard_normal(len(DATA.t))
    order, gain = scan_orders(spikes, DATA.q, np.full(1000, 1.0), 100.0, 1000.0, ROWS.kernel, DATA.step_s)
    # At 1 rad/s, 25 Hz are an order of 157.
    assert gain[order < 150.0].min() > 0.0
    assert gain[order > 250.0].max() == 0.0
