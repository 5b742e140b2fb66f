"""Two masses and a spring: what can be known of them by hand, or from SciPy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from friction_audit.joint_log import Float
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import HARDENING, KNEE_NM, Backlash, JointElasticity
from friction_audit.simulation.settings import JointParameters
from friction_audit.simulation.simulation import TrueMotion
from tests.simulation.mechanics.any_step import bench, release

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
@pytest.mark.parametrize("ratio", [0.0, 0.03, 0.1])
def test_two_masses_ring_at_the_frequency_of_the_textbook(compliance: float, ratio: float) -> None:
    """Sqrt(K (1/B + 1/J)) / 2 pi, lower by sqrt(1 - zeta^2) where damped."""
    motion = ring(JointElasticity(compliance_rad_per_nm=compliance, damping_ratio=ratio), 1e-3)
    undamped = np.sqrt((1.0 / MOTOR + 1.0 / LINK) / compliance) / (2.0 * np.pi)
    assert_allclose(frequency(motion), undamped * np.sqrt(1.0 - ratio**2), rtol=1e-4)
    assert_allclose(MOTOR * motion.inner_q + LINK * motion.q, 0.0, atol=1e-15)


@pytest.mark.parametrize("ratio", [0.01, 0.03, 0.1])
def test_ringing_decays_by_its_damping_ratio(ratio: float) -> None:
    x = stretch(ring(JointElasticity(compliance_rad_per_nm=1e-3, damping_ratio=ratio), 1e-3))
    peaks = np.flatnonzero((x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:])) + 1
    peaks = peaks[x[peaks] > 1e-6]
    decrement = np.log(x[peaks[0]] / x[peaks[-1]]) / (len(peaks) - 1)
    assert_allclose(decrement / np.hypot(2.0 * np.pi, decrement), ratio, rtol=1e-3)


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
