"""The friction observer: what it observes, known by hand, and how fast it may be."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from friction_audit.compensation.compensators.feedback import DisturbanceObserver
from friction_audit.compensation.controller import FIND, step
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation import JointParameters
from tests.compensation.competitor_bench import COULOMB, INERTIA, TICK_S, VISCOUS, fresh, guided, runs_away
from tests.compensation.stability import observer_limit

OBSERVER = DisturbanceObserver(inertia_kg_m2=INERTIA, observer_gain_per_s=50.0, dead_band_rad_s=0.0, ramp_rad_s=0.0)
TOO_HEAVY = replace(OBSERVER, inertia_kg_m2=0.5)
LIGHT = JointParameters(inertia_kg_m2=0.1, coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)


def observe(observer: DisturbanceObserver, friction_nm: float, ddq: float, ticks: int = 400) -> Float:
    """Return what is observed of a joint that keeps accelerating, its sensor feeling u: F_m = B ddq + tau_f - u."""
    settings, memory = fresh(observer)
    u, observed = 0.0, []
    for k in range(ticks):
        u = step(settings, memory, 0.1 + ddq * k * TICK_S, INERTIA * ddq + friction_nm - u, TICK_S, FIND)
        observed.append(float(memory["observed_friction_nm"]))
    return np.array(observed)


@given(friction=st.floats(-1.0, 1.0), gain=st.floats(1.0, 2000.0), share=st.floats(0.1, 1.0))
def test_at_steady_speed_it_finds_friction_exponentially(friction: float, gain: float, share: float) -> None:
    observer = replace(OBSERVER, observer_gain_per_s=gain, compensation_gain=share)
    expected = friction * -np.expm1(-gain * np.arange(50) * TICK_S)
    assert_allclose(observe(observer, friction, 0.0, 50), expected, atol=1e-9)


@pytest.mark.parametrize("ddq", [-2.0, 0.5, 3.0])
@pytest.mark.parametrize("assumed", [0.15, INERTIA, 0.45])
def test_a_wrong_inertia_looks_like_friction(assumed: float, ddq: float) -> None:
    observed = observe(replace(OBSERVER, inertia_kg_m2=assumed), 0.3, ddq)
    assert observed[-1] == pytest.approx(0.3 + (INERTIA - assumed) * ddq, abs=1e-7)


def test_the_torque_is_the_gain_times_what_is_observed_outside_the_dead_band() -> None:
    observer = replace(OBSERVER, compensation_gain=0.8, dead_band_rad_s=0.01, ramp_rad_s=0.02)
    settings, memory = fresh(observer)
    for speed, share in ((0.5, 1.0), (0.02, 0.5), (-0.02, 0.5), (0.01, 0.0), (0.0, 0.0), (-0.5, 1.0)):
        u = step(settings, memory, speed, 0.3, TICK_S, FIND)
        assert u == pytest.approx(0.8 * share * memory["observed_friction_nm"])


@pytest.mark.parametrize("hand", [0.05, 0.08])
def test_the_loop_runs_away_just_beyond_the_limit(hand: float) -> None:
    limit = observer_limit(TOO_HEAVY, inertia_kg_m2=0.1, outer_inertia_kg_m2=hand, period_s=TICK_S)
    below, above = (
        guided(replace(TOO_HEAVY, observer_gain_per_s=share * limit), joint=LIGHT, hand=hand, duration_s=6.0)
        for share in (0.95, 1.05)
    )
    assert not runs_away(below)
    assert runs_away(above)


@pytest.mark.parametrize("gain", [0.0, 1.1])
def test_more_than_all_is_not_compensated(gain: float) -> None:
    with pytest.raises(UsageError, match="compensation_gain"):
        replace(OBSERVER, compensation_gain=gain)
