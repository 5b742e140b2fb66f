"""The compensators other than the paper's: each by hand, in the hand of the same person, and where they run away."""

from dataclasses import replace
from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose

from friction_audit.compensation.comparison.result import vibration_nm
from friction_audit.compensation.competitors import (
    PANDA_SIGMOIDS,
    DisturbanceObserver,
    FixedCompensation,
    LugreCompensation,
    TorqueRegulation,
    fit_sigmoid,
)
from friction_audit.compensation.controller import DETECT, step
from friction_audit.compensation.law import Coefficients, CompensatorSettings, EnergyCompensator, payback_s
from friction_audit.joint_log import Float
from friction_audit.simulation import IDEAL_SENSORS, PANDA_SENSORS, JointParameters, Operator
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import JointElasticity
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.scenarios import simulate
from tests.compensation.bench import (
    COULOMB,
    HAND,
    INERTIA,
    TICK_S,
    VISCOUS,
    feed,
    fresh,
    guided,
    observer_limit,
    runs_away,
    work_j,
)

# The competitors in the hand of the same person, on the same joint.

ORACLE = FixedCompensation(coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
LUGRE = LugreCompensation(coulomb_nm=COULOMB, breakaway_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
OBSERVER = DisturbanceObserver(inertia_kg_m2=INERTIA, observer_gain_per_s=50.0)
REGULATION = TorqueRegulation(inertia_kg_m2=INERTIA, desired_inertia_kg_m2=0.15)


@pytest.fixture(scope="module")
def uncompensated_j() -> float:
    return work_j(guided(None))


def test_an_oracle_leaves_no_friction_and_no_method_beats_it(uncompensated_j: float) -> None:
    best = abs(work_j(guided(ORACLE)))
    assert best < 5e-3 * uncompensated_j
    for competitor in (LUGRE, OBSERVER, REGULATION, fit_sigmoid(COULOMB, VISCOUS), PANDA_SIGMOIDS[0]):
        assert best < abs(work_j(guided(competitor))) < uncompensated_j


@pytest.mark.parametrize("right", [ORACLE, LUGRE, replace(fit_sigmoid(COULOMB, VISCOUS), steepness_s_per_rad=40.0)])
def test_twenty_percent_too_little_leaves_twenty_percent(right: Any, uncompensated_j: float) -> None:
    left = work_j(guided(right.scaled(0.8))) / uncompensated_j
    assert left == pytest.approx(0.2 + work_j(guided(right)) / uncompensated_j, abs=0.03)


@pytest.mark.parametrize("right", [LUGRE, fit_sigmoid(COULOMB, VISCOUS)])
def test_a_guard_takes_back_what_over_compensation_put_in(right: Any) -> None:
    over = right.scaled(1.6)
    wild, guarded = (guided(replace(over, passivity=passivity), duration_s=12.0) for passivity in (False, True))
    assert work_j(wild) < -0.1
    # What is compensated too much, over the time in which it is paid back.
    fastest = float(np.abs(guarded.dq).max())
    assert work_j(guarded) > -0.6 * (COULOMB + VISCOUS * fastest) * fastest * CompensatorSettings.payback_s


# LuGre as a compensator, against its solution by hand.

DAMPED_LUGRE = LugreCompensation(
    coulomb_nm=0.3, breakaway_nm=0.5, viscous_nms_per_rad=0.07, damping_nms_per_rad=0.2
)  # the bristles of 300 N m/rad and the Stribeck velocity of 0.05 rad/s are usual


def level(dq: float) -> float:
    return 0.3 + 0.2 * float(np.exp(-((dq / 0.05) ** 2)))


@pytest.mark.parametrize("speed", [-1.0, -0.05, 0.02, 0.4])
@pytest.mark.parametrize("dt", [1e-3, 2e-2])
def test_bristles_bend_exponentially_at_any_tick(speed: float, dt: float) -> None:
    ticks = 40
    torque, state = feed(DAMPED_LUGRE, np.full(ticks, speed), 0.0, dt)
    bend = np.sign(speed) * level(speed) / 300 * (1 - np.exp(-300 * abs(speed) * np.arange(ticks) * dt / level(speed)))
    rate = speed - 300 * abs(speed) * bend / level(speed)
    assert state["deflection_rad"] == pytest.approx(bend[-1], rel=1e-9)
    assert_allclose(torque, 300 * bend + 0.2 * rate + 0.07 * speed, rtol=1e-9)


# The published static friction of the Panda.

FORWARD = (0.25, 0.39, 0.39, 0.58, 0.37, 0.18, 0.28)
BACKWARD = (0.30, 0.49, 0.25, 0.70, 0.47, 0.12, 0.29)


@pytest.mark.parametrize("joint", range(7))
def test_the_torque_is_the_formula_and_its_plateaus_are_the_published_ones(joint: int) -> None:
    one = PANDA_SIGMOIDS[joint]
    assert one.plateaus_nm == pytest.approx((FORWARD[joint], BACKWARD[joint]), abs=6e-3)
    dq = np.array([-10.0, -0.3, -0.05, 0.0, 0.05, 0.3, 10.0])
    phi1, phi2, phi3 = one.height_nm, one.steepness_s_per_rad, one.shift_rad_s
    expected = phi1 / (1 + np.exp(-phi2 * (dq + phi3))) - phi1 / (1 + np.exp(-phi2 * phi3))
    torque, _ = feed(one, dq, 0.0)
    assert_allclose(torque, expected, atol=1e-12)
    assert torque[3] == 0.0
    assert_allclose(torque[[-1, 0]], [one.plateaus_nm[0], -one.plateaus_nm[1]], rtol=1e-9)


# Torque feedback: what it makes of friction and inertia, and where it runs away.

HALVED = TorqueRegulation(inertia_kg_m2=INERTIA, desired_inertia_kg_m2=INERTIA / 2)


@pytest.mark.parametrize(("desired", "gain"), [(0.15, 1.0), (0.1, 2.0), (0.6, -0.5)])
def test_the_torque_is_in_proportion_to_what_is_measured_and_low_passed(desired: float, gain: float) -> None:
    torque, shaped = np.array([0.0, 1.0, -0.4, 3.0]), replace(HALVED, desired_inertia_kg_m2=desired)
    assert_allclose(feed(shaped, 0.3, torque)[0], gain * torque)
    filtered, _ = feed(replace(shaped, cutoff_hz=20.0), 0.0, np.concatenate([[0.0], np.ones(50)]))
    assert_allclose(filtered, gain * -np.expm1(-2 * np.pi * 20.0 * np.arange(51) * TICK_S), atol=1e-12)


@pytest.mark.parametrize("desired", [0.24, 0.12, 0.6])
def test_friction_shrinks_like_the_inertia(desired: float) -> None:
    shaped = guided(replace(HALVED, desired_inertia_kg_m2=desired))
    assert work_j(shaped) / work_j(guided(None)) == pytest.approx(desired / INERTIA, rel=0.02)


# The friction observer: what it observes, known by hand, and how fast it may be.

PUBLISHED_OBSERVER = replace(OBSERVER, dead_band_rad_s=0.0, ramp_rad_s=0.0)
TOO_HEAVY = replace(PUBLISHED_OBSERVER, inertia_kg_m2=0.5)
LIGHT = JointParameters(inertia_kg_m2=0.1, coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)


def observe(observer: DisturbanceObserver, friction_nm: float, ddq: float, ticks: int = 400) -> Float:
    """Return what is observed of a joint that keeps accelerating, its sensor feeling u: F_m = B ddq + tau_f - u."""
    settings, state = fresh(observer)
    u, observed = 0.0, []
    for k in range(ticks):
        u = step(settings, state, 0.1 + ddq * k * TICK_S, INERTIA * ddq + friction_nm - u, TICK_S, DETECT)
        observed.append(float(state["observed_friction_nm"]))
    return np.array(observed)


@given(friction=st.floats(-1.0, 1.0), gain=st.floats(1.0, 2000.0), share=st.floats(0.1, 1.0))
def test_at_steady_speed_it_finds_friction_exponentially(friction: float, gain: float, share: float) -> None:
    observer = replace(PUBLISHED_OBSERVER, observer_gain_per_s=gain, compensation_gain=share)
    expected = friction * -np.expm1(-gain * np.arange(50) * TICK_S)
    assert_allclose(observe(observer, friction, 0.0, 50), expected, atol=1e-9)


@pytest.mark.parametrize("ddq", [-2.0, 0.5, 3.0])
@pytest.mark.parametrize("assumed", [0.15, INERTIA, 0.45])
def test_a_wrong_inertia_looks_like_friction(assumed: float, ddq: float) -> None:
    observed = observe(replace(PUBLISHED_OBSERVER, inertia_kg_m2=assumed), 0.3, ddq)
    assert observed[-1] == pytest.approx(0.3 + (INERTIA - assumed) * ddq, abs=1e-7)


def test_the_torque_is_the_gain_times_what_is_observed_outside_the_dead_band() -> None:
    observer = replace(PUBLISHED_OBSERVER, compensation_gain=0.8, dead_band_rad_s=0.01, ramp_rad_s=0.02)
    settings, state = fresh(observer)
    for speed, share in ((0.5, 1.0), (0.02, 0.5), (-0.02, 0.5), (0.01, 0.0), (0.0, 0.0), (-0.5, 1.0)):
        u = step(settings, state, speed, 0.3, TICK_S, DETECT)
        assert u == pytest.approx(0.8 * share * state["observed_friction_nm"])


@pytest.mark.parametrize("hand", [0.05, 0.08])
def test_the_loop_runs_away_just_beyond_the_limit(hand: float) -> None:
    limit = observer_limit(TOO_HEAVY, 0.1, hand)
    below, above = (
        guided(replace(TOO_HEAVY, observer_gain_per_s=share * limit), joint=LIGHT, hand=hand, duration_s=6.0)
        for share in (0.95, 1.05)
    )
    assert not runs_away(below)
    assert runs_away(above)


# Torque feedback in a joint whose gear twists: the limits of docs/compensators.md, eigenvalues of the sampled loop.


def elastic(compliance: float, damping_ratio: float) -> tuple[Hidden]:
    return (Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=compliance, damping_ratio=damping_ratio)),)


@pytest.mark.parametrize(("limit_kg_m2", "cutoff_hz"), [(0.109, inf), (0.236, 30.0)])
def test_the_loop_rings_just_below_the_limit(limit_kg_m2: float, cutoff_hz: float) -> None:
    """What noise sets ringing grows, with next to nobody there to damp it."""
    settings = BenchSettings(
        joints=(JointParameters(inertia_kg_m2=INERTIA, coulomb_nm=0.0, viscous_nms_per_rad=0.0),),
        hidden=elastic(1e-4, 0.03),
        sensors=(replace(IDEAL_SENSORS, torque_noise_nm=0.02),),
        operator=Operator(
            inertia_kg_m2=HAND,
            stiffness_nm_per_rad=20.0,
            damping_nms_per_rad=0.05,
            motion=Sinusoid(amplitude_rad=0.01, ease_s=0.5),
        ),
        duration_s=30.0,
    )
    for share, rings in ((1.05, False), (0.95, True)):
        desired = share * limit_kg_m2
        regulation = TorqueRegulation(inertia_kg_m2=INERTIA, desired_inertia_kg_m2=desired, cutoff_hz=cutoff_hz)
        motion = simulate(replace(settings, compensator=regulation), 0).truth.motion
        assert (np.abs(motion.compensation_nm).max() > 30.0) == rings


# Viscous friction over-compensated in a joint whose gear twists: the passivity controller must not drive the mode.

MOTOR, OUTER, DAMPING_RATIO = 0.3, 1.0, 0.1
OVER = EnergyCompensator(
    forced=Coefficients(viscous_nms_per_rad=2.5), forced_from_cycle=1, forced_until_acted=False,
    max_torque_nm=87.0, max_torque_rate_nm_s=1000.0,
)  # fmt: skip


def vibration(hz: float, compensator: EnergyCompensator) -> float:
    """Return the rms of the interaction torque that is faster than a person, from the second second on. [N m]"""
    compliance = (1.0 / MOTOR + 1.0 / OUTER) / (2.0 * pi * hz) ** 2
    settings = BenchSettings(
        joints=(JointParameters(inertia_kg_m2=MOTOR, coulomb_nm=0.311, viscous_nms_per_rad=0.075),),
        hidden=elastic(compliance, DAMPING_RATIO),
        sensors=(PANDA_SENSORS[0],),
        operator=Operator(inertia_kg_m2=OUTER, stiffness_nm_per_rad=375.0, damping_nms_per_rad=62.0),
        compensator=compensator,
        duration_s=10.0,
    )
    motion = simulate(settings, 0).truth.motion
    return float(sqrt((vibration_nm(motion.interaction_nm)[2000:] ** 2).mean()))


@pytest.mark.parametrize("hz", [10.0, 33.0, 71.0])
def test_over_compensation_does_not_make_the_joint_ring_unless_paid_within_a_tick(hz: float) -> None:
    assert vibration(hz, replace(OVER, payback_s=payback_s(2.0 * pi * hz, DAMPING_RATIO))) < 0.2
    assert hz != 33.0 or vibration(hz, replace(OVER, payback_s=0.0)) > 0.5
