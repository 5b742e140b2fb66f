"""Ripples that no order of the grid meets, or that lie beyond its last one."""

import numpy as np
import pytest

from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.library import Library, build_library
from friction_audit.diagnosis.naming import find_names
from friction_audit.diagnosis.ripple_scan import with_scanned_orders
from friction_audit.effects import torque_ripple
from friction_audit.effects.effect import Effect
from friction_audit.effects.torque_ripple import EFFECT as CANDIDATE
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.toy_candidates import SQUARE

ORDER = 171.3


@pytest.fixture(autouse=True)
def _few_orders(monkeypatch: pytest.MonkeyPatch) -> None:
    """A grid that ends at an order of about 60."""
    monkeypatch.setattr(torque_ripple, "MOST_ORDERS", 20)


def ground_with(order: float, size_nm: float) -> Ground:
    return make_ground(moved_joint(lambda data: size_nm * np.cos(order * data.q), noise_nm=0.02), None, 0)


def library_of(ground: Ground, *candidates: Effect) -> Library:
    return build_library(candidates, ground.data, ground.baseline(), ground.rows)


def test_a_ripple_beyond_the_grid_is_named_and_pays_for_all_orders_up_to_it() -> None:
    ground = ground_with(ORDER, 0.03)
    library = library_of(ground, CANDIDATE)
    assert library.entries[0].shapes[-1]["ripple_order"] < 80.0
    scanned = with_scanned_orders(ground, library)
    (found,) = find_names(ground, (CANDIDATE,), scanned, 0.05, np.random.default_rng(0)).found
    assert found.shape["ripple_order"] == pytest.approx(ORDER, abs=0.2)
    tried = scanned.entries[0].group.tried
    assert tried[:20] == (0.0,) * 20
    assert max(tried) == pytest.approx(2.0 * 0.5 * (ORDER - 4.0 * np.pi / np.ptp(ground.data.q)), rel=0.15)


def test_of_noise_no_order_is_taken() -> None:
    ground = ground_with(ORDER, 0.0)
    library = with_scanned_orders(ground, library_of(ground, CANDIDATE))
    assert find_names(ground, (CANDIDATE,), library, 0.05, np.random.default_rng(0)).found == ()


def test_an_order_between_two_of_the_grid_is_met() -> None:
    ground = ground_with(33.3, 0.03)
    scanned = with_scanned_orders(ground, library_of(ground, CANDIDATE))
    orders = np.array([shape["ripple_order"] for shape in scanned.entries[0].shapes[20:]])
    assert np.abs(orders - 33.3).min() < 0.3


def test_a_library_without_ripples_stays_as_it_is() -> None:
    ground = ground_with(ORDER, 0.03)
    library = library_of(ground, SQUARE)
    assert with_scanned_orders(ground, library) is library
