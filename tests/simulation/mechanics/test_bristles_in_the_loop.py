"""Presliding while the joint moves: LuGre against SciPy, loops, steady motion."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from friction_audit.joint_log import Float
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.velocity import BRISTLES as BRISTLE_COUNT
from friction_audit.simulation.effects.velocity import DAHL, FIRST_YIELD, LUGRE, MAXWELL_SLIP, Presliding, Stribeck
from friction_audit.simulation.settings import JointParameters
from friction_audit.simulation.simulation import TrueMotion
from tests.simulation.mechanics.any_step import STEP_S, bench, release

JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
FORMS = (LUGRE, DAHL, MAXWELL_SLIP)
TICK_S = 1e-3
SPRING, DAMPER, CREEP = 10.0, 0.05, 0.05
SOFT = Presliding(displacement_rad=0.002, damping_s=0.02)


def creep(step_s: float) -> TrueMotion:
    """Pull the joint by a soft spring, slowly: it sticks and slips."""
    hidden = Hidden(presliding=SOFT, stribeck=Stribeck(excess_nm=0.3, speed_rad_s=0.1))
    t = np.arange(6001, dtype=np.float64) * TICK_S
    push = SPRING * CREEP * t + DAMPER * CREEP
    settings = bench(JOINT, hidden, stiffness_nm_per_rad=SPRING, damping_nms_per_rad=DAMPER)
    return release(settings, 6.0, step_s=step_s, tick_s=TICK_S, push=push)


def published(t: Float, *, constant_damping: bool) -> Float:
    """Return position and velocity after Canudas de Wit et al. (1995), shape (2, n), with its sigma1 or a passive one.

    Passive: sigma1 falls with speed such that sigma1 |v| stays below 4 g (Barabanov and Ortega 2000).
    """
    sigma0 = 0.3 / SOFT.displacement_rad
    sigma1 = SOFT.damping_s * sigma0

    def slope(now: float, state: Float) -> list[float]:
        q, v, z = state
        level = 0.3 + 0.3 * np.exp(-((v / 0.1) ** 2))
        rate = v - sigma0 * abs(v) / level * z
        damping = sigma1 if constant_damping else sigma1 / (1.0 + sigma1 * abs(v) / (4.0 * level))
        pull = SPRING * (CREEP * now - q) + DAMPER * (CREEP - v)
        return [v, (pull - sigma0 * z - damping * rate - 0.07 * v) / 0.6, rate]

    known = solve_ivp(slope, (0.0, t[-1]), [0.0] * 3, "LSODA", rtol=1e-9, atol=1e-12, t_eval=t, max_step=5e-3)
    return known.y[:2]


def test_stick_slip_of_lugre_follows_the_published_equations() -> None:
    motion = creep(STEP_S)
    q, v = published(motion.t, constant_damping=False)
    assert v.max() > 2.5 * CREEP
    assert np.sort(v)[len(v) // 4] < 0.2 * CREEP
    assert_allclose(motion.q[:, 0], q, atol=2e-8)
    assert_allclose(motion.dq[:, 0], v, atol=1e-7)
    q, _ = published(motion.t, constant_damping=True)
    assert_allclose(motion.q[:, 0], q, atol=1e-3)


def test_stick_slip_of_lugre_is_of_order_two() -> None:
    coarse, middle, fine = (creep(step).q[:, 0] for step in (5e-4, 2.5e-4, 1.25e-4))
    order = np.log2(np.abs(coarse - middle).max() / np.abs(middle - fine).max())
    assert 1.5 < order < 2.7


def guided(form: int, course: Float, speed: Float) -> TrueMotion:
    """Guide the joint by a stiff hand."""
    stiff = {"stiffness_nm_per_rad": 600.0, "damping_nms_per_rad": 60.0}
    hidden = Hidden(presliding=Presliding(displacement_rad=0.005, form=form))
    push = 600.0 * course + 60.0 * speed
    return release(bench(JOINT, hidden, **stiff), (len(push) - 1) * TICK_S, tick_s=TICK_S, push=push)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("reach", [0.001, 0.004, 0.05])
def test_closed_loops_take_energy_and_run_clockwise_about_the_spring(form: int, reach: float) -> None:
    """Once settled, friction takes the area of the loop: not below zero, at most the Coulomb level times the path.

    Of Maxwell-slip the area is known: every element that yields takes four times its torque times the way it slips.
    """
    pace = np.pi
    t = np.arange(12001) * TICK_S
    motion = guided(form, reach * (1.0 - np.cos(pace * t)), reach * pace * np.sin(pace * t))
    loop = slice(10000, 12001)
    moved = np.diff(motion.q[loop, 0])
    dry = (motion.friction_nm - 0.07 * motion.dq)[loop, 0]
    area = float(np.sum(0.5 * (dry[1:] + dry[:-1]) * moved))
    viscous = float(np.sum(0.07 * np.diff(motion.t[loop]) * motion.dq[loop][1:, 0] ** 2))
    assert -1e-12 < area <= 0.3 * np.abs(moved).sum()
    assert_allclose(motion.dissipated_j[12000, 0] - motion.dissipated_j[10000, 0], area + viscous, rtol=0.01, atol=1e-9)
    if form == MAXWELL_SLIP:
        slipped = np.maximum(np.ptp(motion.q[loop]) / 2.0 - 0.005 * FIRST_YIELD * np.arange(1, BRISTLE_COUNT + 1), 0.0)
        assert_allclose(area, 4.0 * 0.3 / BRISTLE_COUNT * slipped.sum(), rtol=1e-3, atol=1e-9)
    elif reach == 0.05:
        assert area > 0.85 * 0.3 * np.abs(moved).sum()
