"""Springs, gaps and torque control between motor and link: what can be known by hand, or from SciPy."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation import IDEAL_SENSORS, BenchSettings, Hidden, simulate
from friction_audit.simulation.bench import Operator
from friction_audit.simulation.effects.structure import HARDENING, KNEE_NM, Backlash, JointElasticity
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.settings import JointParameters, TorqueLoop, TrueMotion
from tests.simulation.mechanics.test_friction import bench, release

# Two masses and a spring: what can be known of them by hand, or from SciPy.

MOTOR, LINK = 0.3, 0.2
REDUCED = MOTOR * LINK / (MOTOR + LINK)
SMOOTH = JointParameters(inertia_kg_m2=MOTOR, coulomb_nm=0.0, viscous_nms_per_rad=0.0)


def ring(elastic: JointElasticity, stretch_rad: float, duration_s: float = 2.0, gap_rad: float = 0.0) -> TrueMotion:
    """Stretch the joint about its centre of mass and let go."""
    hidden = Hidden(joint_elasticity=elastic, backlash=Backlash(gap_rad=gap_rad))
    q = (stretch_rad * MOTOR / (MOTOR + LINK), -stretch_rad * LINK / (MOTOR + LINK))
    return release(bench(SMOOTH, hidden, inertia_kg_m2=LINK), duration_s, q=q)


def stretch(motion: TrueMotion) -> Float:
    return (motion.inner_q - motion.q)[:, 0]


def frequency(motion: TrueMotion) -> float:
    """Return the frequency between the first and the last upward passage through zero. [Hz]"""
    x = stretch(motion)
    before = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    times = motion.t[before] - x[before] * np.diff(motion.t)[before] / np.diff(x)[before]
    return float((len(times) - 1) / (times[-1] - times[0]))


@pytest.mark.parametrize("compliance", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("ratio", [0.0, 0.01, 0.03, 0.1])
def test_two_masses_ring_at_the_frequency_of_the_textbook_and_decay_by_their_damping(
    compliance: float, ratio: float
) -> None:
    """Sqrt(K (1/B + 1/J)) / 2 pi, lower by sqrt(1 - zeta^2) where damped."""
    motion = ring(JointElasticity(compliance_rad_per_nm=compliance, damping_ratio=ratio), 1e-3)
    undamped = np.sqrt((1.0 / MOTOR + 1.0 / LINK) / compliance) / (2.0 * np.pi)
    assert_allclose(frequency(motion), undamped * np.sqrt(1.0 - ratio**2), rtol=1e-4)
    assert_allclose(MOTOR * motion.inner_q + LINK * motion.q, 0.0, atol=1e-15)
    x = stretch(motion)
    peaks = np.flatnonzero((x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:]) & (x[1:-1] > 1e-6)) + 1
    decrement = np.log(x[peaks[0]] / x[peaks[-1]]) / (len(peaks) - 1)
    assert_allclose(decrement / np.hypot(2.0 * np.pi, decrement), ratio, rtol=3e-3, atol=1e-4)


@pytest.mark.parametrize("amplitude", [1e-4, 2e-3, 2e-2])
def test_hardening_spring_follows_scipy(amplitude: float) -> None:
    """The strain-wave gear is half as stiff near zero: its frequency rises by up to sqrt(2) with the amplitude."""
    compliance = 1e-3
    elastic = JointElasticity(compliance_rad_per_nm=compliance, damping_ratio=0.0, form=HARDENING)
    motion = ring(elastic, amplitude, duration_s=0.5)
    knee = KNEE_NM * compliance

    def slope(_: float, state: Float) -> list[float]:
        spring = (state[0] - knee * np.tanh(0.5 * state[0] / knee)) / compliance
        return [state[1], -spring / REDUCED]

    known = solve_ivp(slope, (0.0, 0.5), [-amplitude, 0.0], "DOP853", rtol=1e-10, atol=1e-14, t_eval=motion.t)
    assert_allclose(stretch(motion), known.y[0], atol=3e-4 * amplitude)


def test_elasticity_and_backlash_in_series_swing_through_the_gap_unpushed() -> None:
    """Period: that of the spring plus twice the flight through the gap at the speed that the spring gave."""
    gap, twist = 2e-3, 5e-3
    elastic = JointElasticity(compliance_rad_per_nm=1e-3, damping_ratio=0.0)
    motion = ring(elastic, twist + gap / 2.0, gap_rad=gap)
    pulsation = np.sqrt(1.0 / REDUCED / 1e-3)
    period = 2.0 * np.pi / pulsation + 2.0 * gap / (twist * pulsation)
    assert_allclose(frequency(motion), 1.0 / period, rtol=1e-3)
    assert_allclose(motion.port_nm[np.abs(stretch(motion)) < gap / 2.0], 0.0, atol=1e-12)
    assert_allclose(np.abs(motion.port_nm).max(), twist / 1e-3, rtol=1e-3)


# A gap between the sides of the joint: what it transmits, and what its impacts take.

GAP = 0.02


def beyond(motion: TrueMotion) -> Float:
    """Return by how much the stretch is beyond the gap, signed."""
    return np.asarray(np.sign(stretch(motion)) * np.maximum(np.abs(stretch(motion)) - GAP / 2, 0.0))


@pytest.mark.parametrize("damping_ratio", [0.0, 0.2, 1.0])
def test_impacts_keep_momentum_and_never_add_energy(damping_ratio: float) -> None:
    """The link, at 0.5 rad/s, runs to and fro in the gap of a motor at rest."""
    hidden = Hidden(backlash=Backlash(gap_rad=GAP, contact_damping_ratio=damping_ratio))
    motion = release(bench(SMOOTH, hidden, inertia_kg_m2=LINK), 0.6, dq=(0.5, 0.0))
    assert_allclose(MOTOR * motion.inner_dq + LINK * motion.dq, LINK * 0.5, atol=1e-12)
    held = 0.5 * (MOTOR * motion.inner_dq**2 + LINK * motion.dq**2)[:, 0] + 0.5 * beyond(motion) ** 2 / 1e-4
    lost = held[0] - held[-1]
    at_stake = held[0] - 0.5 * (LINK * 0.5) ** 2 / (MOTOR + LINK)
    assert np.diff(held).max() < 3e-4 * held[0]
    assert -2e-4 * held[0] < lost < at_stake
    assert lost > 0.9 * at_stake if damping_ratio else abs(lost) < 2e-4 * held[0]


def test_torque_rests_at_nothing_while_the_hand_crosses_the_gap() -> None:
    """Friction stops the motor sooner than the hand turns round; the hand then crosses the gap without a torque."""
    stiff = {"stiffness_nm_per_rad": 2000.0, "damping_nms_per_rad": 60.0}
    settings = bench(JointParameters(), Hidden(backlash=Backlash(gap_rad=GAP)), **stiff)
    tick, reach, omega = 1e-3, 0.1, np.pi / 2.0
    t = np.arange(4001) * tick
    push = 2000.0 * reach * (1.0 - np.cos(omega * t)) + 60.0 * reach * omega * np.sin(omega * t)
    motion = release(settings, 4.0, tick_s=tick, push=push)
    crossing = (motion.t > 1.5) & (motion.t < 3.0) & (beyond(motion) == 0.0)
    assert_allclose(motion.port_nm[crossing], 0.0, atol=1e-12)
    assert_array_equal(motion.inner_dq[crossing], 0.0)
    assert_allclose(np.ptp(motion.q[crossing]), GAP, atol=4e-4)
    assert_allclose(crossing.sum() * tick, np.arccos(1.0 - GAP / reach) / omega, rtol=0.05)
    pulling = (motion.t > 3.2) & (motion.t < 3.6)
    assert_allclose(motion.port_nm[pulling], (0.3 * motion.inner_ddq - 0.30 + 0.07 * motion.inner_dq)[pulling])


# Joint torque control with its motor's friction inside: what can be known by hand.

DRIVE, ARM, STIFFNESS, GAIN, DAMPING_S = 0.3, 1.0, 1e4, 4.0, 0.004
GEAR = Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=1.0 / STIFFNESS, damping_ratio=0.0))


def joint(coulomb_nm: float = 0.0, viscous: float = 0.0, **loop: float) -> JointParameters:
    control = TorqueLoop(**{"gain": GAIN, "damping_s": DAMPING_S} | loop)
    return JointParameters(inertia_kg_m2=DRIVE, coulomb_nm=coulomb_nm, viscous_nms_per_rad=viscous, torque_loop=control)


@pytest.mark.parametrize("gain", [1.0, 4.0, 9.0])
def test_friction_and_inertia_at_the_link_are_those_of_the_motor_over_one_plus_the_gain(gain: float) -> None:
    settings = BenchSettings(
        joints=(joint(0.3, 0.1, gain=gain, dead_time_s=0.0003),),
        hidden=(GEAR,),
        sensors=(IDEAL_SENSORS,),
        operator=Operator(motion=Sinusoid()),
        duration_s=12.0,
    )
    motion = simulate(settings, 1).truth.motion
    dq, ddq, torque = (values[:, 0] for values in (motion.inner_dq, motion.inner_ddq, motion.interaction_nm))
    sliding = np.abs(dq) > 0.1
    columns = np.stack([ddq, np.sign(dq), dq], axis=1)[sliding]
    found = np.linalg.lstsq(columns, torque[sliding], rcond=None)[0]
    assert_allclose(found, np.array([DRIVE, 0.3, 0.1]) / (1.0 + gain), rtol=0.02)
    link = settings.joints[0].at_link
    assert_allclose([link.inertia_kg_m2, link.coulomb_nm, link.viscous_nms_per_rad], found, rtol=0.02)


@pytest.mark.parametrize(("beyond_s", "grows"), [(-1.5e-4, False), (1e-4, True)])
def test_the_loop_rings_from_the_dead_time_of_its_characteristic_equation(beyond_s: float, *, grows: bool) -> None:
    """The torque is held for a step of 0.1 ms, half a step more of dead time.

    s^2 + K (1/B + 1/m) + K/B (k + d s) e^(-s T) = 0 has an imaginary root at the critical dead time.
    """
    rigid = STIFFNESS * (1.0 / DRIVE + 1.0 / ARM)
    w = brentq(lambda w: w * w - rigid - STIFFNESS / DRIVE * np.hypot(GAIN, DAMPING_S * w), 1.0, 1e5)
    critical_s = float(np.arctan2(DAMPING_S * w, GAIN) / w)
    settings = bench(joint(dead_time_s=critical_s + beyond_s), GEAR, inertia_kg_m2=ARM)
    motion = release(settings, 0.5, q=(0.0, 1e-4))
    twist = np.abs(motion.inner_q - motion.q)[:, 0]
    last, first = twist[-500:].max(), twist[250:750].max()
    assert (last > 2.0 * first) == grows
    assert (last < 0.5 * first) != grows


@pytest.mark.parametrize("changed", [{"hidden": (Hidden(),)}, {"driven": True, "logs_sensor": True}])
def test_it_takes_an_elastic_joint_that_a_hand_moves(changed: dict[str, object]) -> None:
    settings = BenchSettings(joints=(joint(),), hidden=(GEAR,), duration_s=1.0)
    with pytest.raises(UsageError, match="expected a hand that moves an elastic joint"):
        simulate(replace(settings, **changed), 0)  # type: ignore[arg-type]


SOFT = JointElasticity(compliance_rad_per_nm=2e-3)
STILL = BenchSettings(sensors=(IDEAL_SENSORS,), gravity_nm=8.0, gravity_phase_rad=1.0, logs_sensor=True, duration_s=0.4)
LOAD_NM = 8.0 * np.sin(1.0)
WITH_ONE_JOINT = [
    (Hidden(joint_elasticity=SOFT), 2e-3 * LOAD_NM),
    (Hidden(backlash=Backlash(gap_rad=4e-3)), 2e-3 + 1e-4 * LOAD_NM),
    (Hidden(joint_elasticity=SOFT, backlash=Backlash(gap_rad=4e-3)), 2e-3 + 2e-3 * LOAD_NM),
]


@pytest.mark.parametrize(("hidden", "twist"), WITH_ONE_JOINT, ids=["elastic", "backlash", "both"])
def test_load_rests_on_a_twisted_transmission(hidden: Hidden, twist: float) -> None:
    motion = simulate(replace(STILL, hidden=(hidden,)), 1).truth.motion
    assert_allclose(motion.inner_q[0] - motion.q[0], twist, rtol=1e-12)
    assert_allclose(motion.interaction_nm, 0.0, atol=1e-9)
    assert_allclose(motion.dq, 0.0, atol=1e-9)
    # The weight of a driven link is that of the sagged place: not quite what the twist was made for.
    sagged = simulate(replace(STILL, hidden=(hidden,), driven=True), 1).truth.motion
    assert sagged.q[0, 0] < -1e-3
    assert_allclose(sagged.dq, 0.0, atol=2e-3)
    assert_allclose(sagged.interaction_nm, 0.0, atol=0.1)
