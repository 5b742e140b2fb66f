"""LuGre's primitives against the figures of Canudas de Wit, Olsson, Åström and Lischinsky (1995), table I.

Beside them stands SciPy's solution of the same equations, written down here once more.
"""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.velocity import lugre_advance, lugre_force, lugre_rate

SIGMA0, SIGMA1, SIGMA2 = 1e5, math.sqrt(1e5), 0.4
COULOMB_N, STATIC_N, STRIBECK_M_S = 1.0, 1.5, 0.001
MASS_KG = 1.0

Push = Callable[[float, float], float]


def level(v: float) -> float:
    return COULOMB_N + (STATIC_N - COULOMB_N) * math.exp(-((v / STRIBECK_M_S) ** 2))


def push_mass(push: Push, t: Float) -> tuple[Float, Float, Float]:
    """Return position, velocity and friction of the mass under push(t, x), by the primitives."""
    h = float(t[1] - t[0])
    rows = np.zeros((3, len(t)))
    x = v = z = 0.0
    for k in range(1, len(t)):
        z = lugre_advance(z, SIGMA0, level(v), v, h)
        x += h * v
        friction = lugre_force(z, lugre_rate(z, SIGMA0, level(v), v), SIGMA0, SIGMA1) + SIGMA2 * v
        v += h / MASS_KG * (push(t[k], x) - friction)
        rows[:, k] = x, v, friction
    return rows[0], rows[1], rows[2]


def refer_to_scipy(push: Push, t: Float) -> tuple[Float, Float]:
    """Return position and velocity of the mass, by a solver of stiff equations."""

    def slope(now: float, state: Float) -> list[float]:
        x, v, z = state
        rate = v - SIGMA0 * abs(v) / level(v) * z
        return [v, (push(now, x) - SIGMA0 * z - SIGMA1 * rate - SIGMA2 * v) / MASS_KG, rate]

    solution = solve_ivp(
        slope, (t[0], t[-1]), [0.0] * 3, "LSODA", t_eval=t, rtol=1e-8, atol=1e-11, max_step=(t[-1] - t[0]) / 100.0
    )
    return solution.y[0], solution.y[1]


def test_presliding_displacement_is_a_loop_of_some_micrometres() -> None:
    """Figure 2: the force swings within 95 % of the static friction."""
    corners = np.cumsum([0.0, 5.0, 2.0, 10.0, 2.0, 10.0, 2.0])
    forces = 0.95 * STATIC_N * np.array([0.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0])

    def push(now: float, _: float) -> float:
        return float(np.interp(now, corners, forces))

    t = np.arange(0.0, corners[-1], 5e-4)
    x, _, friction = push_mass(push, t)
    reference, _ = refer_to_scipy(push, t[::20])
    np.testing.assert_allclose(x[::20], reference, atol=0.01 * np.ptp(reference))
    assert 1e-5 < np.max(np.abs(x)) < 2e-4
    loop = t >= corners[2]
    assert np.trapezoid(friction[loop], x[loop]) > 0.0


def prescribe_velocity(omega: float) -> tuple[Float, Float, Float]:
    """Return velocity, friction of the last turn and SciPy's, at a velocity that swings about 1.5 mm/s."""

    def velocity(now: float) -> float:
        return 1e-3 * (1.5 + math.cos(omega * now))

    def slope(now: float, state: Float) -> list[float]:
        v = velocity(now)
        return [v - SIGMA0 * abs(v) / level(v) * state[0]]

    turn = 2.0 * math.pi / omega
    t = np.linspace(0.0, 2.0 * turn, 20_001)
    friction = np.zeros(len(t))
    z, h = 0.0, t[1]
    for k in range(1, len(t)):
        middle, v = velocity(t[k] - 0.5 * h), velocity(t[k])
        z = lugre_advance(z, SIGMA0, level(middle), middle, h)
        friction[k] = lugre_force(z, lugre_rate(z, SIGMA0, level(v), v), SIGMA0, SIGMA1) + SIGMA2 * v
    last = slice(10_000, None, 10)
    solution = solve_ivp(slope, (0.0, 2.0 * turn), [0.0], "LSODA", t_eval=t[last], rtol=1e-9, atol=1e-14)
    swing = np.array([velocity(now) for now in t[last]])
    levels = np.array([level(speed) for speed in swing])
    z_scipy = solution.y[0]
    reference = SIGMA0 * z_scipy + SIGMA1 * (swing - SIGMA0 * swing / levels * z_scipy) + SIGMA2 * swing
    return swing, friction[last], reference


def test_frictional_lag_widens_the_loop_with_the_frequency() -> None:
    """Figure 3: friction is higher while the velocity rises than while it falls, more so at 25 rad/s than at 1."""
    widths = []
    for omega in (1.0, 10.0, 25.0):
        v, friction, reference = prescribe_velocity(omega)
        np.testing.assert_allclose(friction, reference, atol=2e-4)
        half = len(v) // 2
        falling = np.interp(1.2e-3, v[: half + 1][::-1], friction[: half + 1][::-1])
        rising = np.interp(1.2e-3, v[half:], friction[half:])
        widths.append(rising - falling)
    assert 0.0 < widths[0] < widths[1] < widths[2]


def test_break_away_force_falls_with_the_rate_of_the_force() -> None:
    """Figure 4: a force ramped up more quickly breaks the mass away at less friction."""
    break_away = []
    for rate in (1.0, 2.0, 5.0, 10.0, 20.0, 50.0):

        def push(now: float, _: float, rate: float = rate) -> float:
            return rate * now

        t = np.arange(0.0, 2.0 / rate, min(1e-4, 1e-3 / rate))
        _, v, friction = push_mass(push, t)
        _, reference = refer_to_scipy(push, t[::10])
        np.testing.assert_allclose(v[::10], reference, atol=0.02 * np.max(reference))
        break_away.append(np.max(friction))
    assert np.all(np.diff(break_away) < 0.0)
    assert COULOMB_N < break_away[-1] < break_away[0] < STATIC_N


@pytest.fixture(scope="module")
def pulled() -> tuple[Float, Float, Float, Float]:
    """Return time, position, velocity and SciPy's position of the mass behind a spring of 2 N/m pulled at 0.1 m/s."""

    def push(now: float, x: float) -> float:
        return 2.0 * (0.1 * now - x)

    t = np.arange(0.0, 20.0, 1e-4)
    x, v, _ = push_mass(push, t)
    reference, _ = refer_to_scipy(push, t[::100])
    return t[::100], x[::100], v[::100], reference


def slide_by_hand() -> Float:
    """Return the velocity after the static friction gave way to Coulomb's, every millisecond of one damped swing.

    dv/dt is (Fs - Fc) / m = 0.5 at first; later m d2v/dt2 + sigma2 dv/dt + k (v - 0.1) = 0.
    """
    t = np.arange(0.0, 4.0, 0.001)
    damping = 0.5 * SIGMA2 / MASS_KG
    omega = math.sqrt(2.0 / MASS_KG - damping**2)
    swing = -0.1 * np.cos(omega * t) + (0.5 - 0.1 * damping) / omega * np.sin(omega * t)
    return 0.1 + np.exp(-damping * t) * swing


def test_a_pulled_mass_sticks_and_slips(pulled: tuple[Float, Float, Float, Float]) -> None:
    """Figure 5: at rest until the spring pulls with the static friction at 7.5 s, then half a swing, then at rest."""
    t, x, v, reference = pulled
    slips = np.flatnonzero(np.diff((v > 0.01).astype(int)) != 0)
    np.testing.assert_allclose(x, reference, atol=2e-3)
    assert t[slips[0]] == pytest.approx(7.5, abs=0.1)
    assert len(slips) == 4
    assert np.max(v) == pytest.approx(np.max(slide_by_hand()), rel=0.02)
    assert t[slips[1]] - t[slips[0]] == pytest.approx(0.001 * np.sum(slide_by_hand() > 0.0), rel=0.03)
