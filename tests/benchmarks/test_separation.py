"""Whether a log separates the truth from competing effects, where it is known by hand."""

from dataclasses import replace

import pytest

from benchmarks.hidden_effects.draw import draw_case
from benchmarks.hidden_effects.run import scaled
from benchmarks.hidden_effects.separation import Competing, Separation, noncentrality_for, separate
from benchmarks.hidden_effects.strength import scales_for


def test_one_number_needs_the_quantiles_of_price_and_power() -> None:
    # Of a normal score: 2.576 is exceeded by chance in one of a hundred, and a mean 1.282 above it in nine of ten.
    assert noncentrality_for(1, 1) == pytest.approx((2.5758 + 1.2816) ** 2, rel=1e-3)


def test_more_numbers_and_more_competing_effects_need_more() -> None:
    assert noncentrality_for(1, 1) < noncentrality_for(3, 1) < noncentrality_for(3, 4)


def of(*others: tuple[str, float, float], numbers: int = 2) -> Separation:
    named = (Competing(name=name, correlation=alike, noncentrality=size) for name, alike, size in others)
    return Separation(competing=tuple(named), numbers=numbers)


def test_effects_that_run_alike_and_leave_too_little_are_close() -> None:
    found = of(("twin", 0.99, 3.0), ("cousin", 0.8, 90.0), ("stranger", 0.6, 3.0))
    assert found.close == ("twin",)
    assert not found.separates
    assert of(("cousin", 0.8, 90.0), ("stranger", 0.6, 3.0)).separates


def test_a_log_that_cannot_show_the_truth_separates_nothing() -> None:
    assert not of(numbers=0).separates


@pytest.mark.thorough
def test_a_strong_ripple_is_separated_and_noncentrality_grows_with_the_square_of_the_strength() -> None:
    """The same ripple in a log of 20 s, as strong as the noise and half of it."""
    case = replace(draw_case(7, ("torque_ripple",), 1.0, "joint"), duration_s=20.0)
    scales = scales_for(case)
    assert scales is not None
    strong, weak = (separate(scaled(case, (share * scales[0],))) for share in (1.0, 0.5))
    assert strong.separates
    assert "torque_ripple" not in [one.name for one in strong.competing]
    most, half = (max(one.competing, key=lambda other: other.noncentrality).noncentrality for one in (strong, weak))
    # The hand moves a little differently, and the noise's integral time is measured on other rows.
    assert most / half == pytest.approx(4.0, rel=0.1)
