"""One mass, and two on a spring or with a gap, against hand calculation, SciPy, energy and the term."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.stick_slip import Step, advance, integrate_two_masses, two_mass_model
from friction_audit.dynamics.torque_tables import tabulate
from friction_audit.dynamics.transmission import Transmission
from friction_audit.effects.joint_model import FittedTerm, JointModel, simple_model
from friction_audit.joint_log import Float
from tests.dynamics.joints import recording_of, simulate, simulate_segments, tables_of

B, COULOMB, VISCOUS = 0.3, 0.4, 0.1
MODEL = simple_model(inertia_kg_m2=B, coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
STRIBECK = replace(MODEL, terms=(*MODEL.terms, FittedTerm("stribeck", (0.2, 0.1, 1.0)), FittedTerm("offset", (0.02,))))


def clock(stop: float, step: float = 1e-3) -> Float:
    return np.arange(round(stop / step) + 1, dtype=np.float64) * step


def test_constant_torque_gives_the_exponential_by_hand() -> None:
    t = clock(2.0)
    motion = simulate(MODEL, t, np.full(len(t), 1.0))
    top, time = (1.0 - COULOMB) / VISCOUS, B / VISCOUS
    assert motion.dq == pytest.approx(top * (1.0 - np.exp(-t / time)), abs=1e-8)
    assert motion.q == pytest.approx(top * (t - time * (1.0 - np.exp(-t / time))), abs=1e-8)


def test_it_runs_out_over_b_v2_by_2c_in_the_time_b_v_by_c() -> None:
    model = simple_model(inertia_kg_m2=B, coulomb_nm=COULOMB, viscous_nms_per_rad=0.0)
    t = clock(1.0)
    motion = simulate(model, t, np.zeros(len(t)), dq=1.0)
    assert motion.q[-1] == pytest.approx(B / (2.0 * COULOMB), abs=1e-12)
    assert motion.dq[t >= B / COULOMB] == pytest.approx(0.0, abs=1e-12)


def test_it_breaks_away_inside_a_step() -> None:
    """A torque that rises by 1 N m/s passes Coulomb friction at 0.4 s plus the offset, within one step of 1 s."""
    model = JointModel(inertia_kg_m2=B, terms=(FittedTerm("coulomb", (COULOMB,)), FittedTerm("offset", (0.01234,))))
    _, v, sign = advance(0.0, 0.0, 0.0, Step(1.0, 0.0, 1.0, 0.0, 0.0), np.zeros(1), tables_of(model))
    assert v == pytest.approx((1.0 - 0.41234) ** 2 / (2.0 * B), rel=1e-12)
    assert sign == 1.0


def reference(model: JointModel, t: Float, amplitude: float, rate: float) -> Float:
    """Velocity by scipy, its sign smooth over 1e-5 rad/s; the drive is strong enough never to stick."""
    still = np.zeros(1)

    def slope(time: float, state: Float) -> list[float]:
        motion = Motion(t=still, q=still, dq=state[1:], ddq=still, smooth_direction=np.tanh(state[1:] / 1e-5))
        return [state[1], (amplitude * np.cos(rate * time) - model.torque(motion)[0]) / model.inertia_kg_m2]

    return np.asarray(solve_ivp(slope, (0.0, t[-1]), np.zeros(2), "LSODA", t_eval=t, rtol=1e-8, atol=1e-10).y[1])


@pytest.mark.parametrize("model", [MODEL, STRIBECK], ids=["plain", "stribeck"])
def test_it_agrees_with_an_independent_integrator(model: JointModel) -> None:
    t = clock(4.0)
    motion = simulate(model, t, 3.0 * np.cos(6.0 * t))
    assert np.count_nonzero(np.diff(np.sign(motion.dq[1:]))) >= 6
    assert motion.dq == pytest.approx(reference(model, t, 3.0, 6.0), abs=1e-4)


def test_the_step_is_of_second_order_through_stops_and_break_aways() -> None:
    tables = tables_of(MODEL)

    def end(steps: int) -> float:
        h, q, v, sign = 2.0 / steps, 0.0, 0.0, 0.0
        for k in range(steps):
            step = Step(h, np.sin(5.0 * h * k), np.sin(5.0 * h * (k + 1)), 0.0, 0.0)
            q, v, sign = advance(q, v, sign, step, np.zeros(1), tables)
        return q

    exact = end(32_000)
    errors = [abs(end(steps) - exact) for steps in (250, 500, 1000, 2000)]
    assert all(3.0 * fine < coarse < 5.0 * fine for coarse, fine in pairwise(errors))
    assert errors[-1] < 1e-5


# Two masses.

STEP_S = 0.0025
T = np.arange(0.0, 3.0, STEP_S)
DRAG, STIFFNESS = 0.07, 900.0
WHOLE = np.array([[0, len(T) - 1]])


def spring(share: float, damping_ratio: float = 0.05) -> FittedTerm:
    return FittedTerm("joint_elasticity", (1.0 / STIFFNESS, STIFFNESS, 0.0, damping_ratio, share))


def moved(share: float, coulomb_nm: float = 0.0, gap_rad: float = 0.0, damping_ratio: float = 0.0) -> Float:
    """Both sides of a joint under a torque from rest: position and velocity of either, shape (4, n)."""
    terms = (FittedTerm("coulomb", (coulomb_nm,)), FittedTerm("viscous", (0.0,)))
    still = recording_of(T, 0.5 * np.sin(T), 0.5 * np.cos(T))
    tables, _ = tabulate(share * B, terms, still)
    gear = Transmission(stiffness_nm_per_rad=STIFFNESS, damping_ratio=damping_ratio, gap_rad=gap_rad)
    model = two_mass_model(gear, (1.0 - share) * B, share * B)
    nothing = np.zeros(len(T))
    return integrate_two_masses(np.stack([drive(), nothing]), (nothing, nothing), STEP_S, WHOLE, model, tables)


def drive() -> Float:
    return 0.9 * np.sin(5.0 * T) + 0.3 * np.sin(31.0 * T)


def energy(rows: Float, share: float, gap_rad: float = 0.0) -> Float:
    """Kinetic and elastic energy. [J]"""
    twist = rows[0] - rows[2]
    engaged = twist - np.clip(twist, -0.5 * gap_rad, 0.5 * gap_rad)
    moving = (1.0 - share) * B * rows[1] ** 2 + share * B * rows[3] ** 2
    return np.asarray(0.5 * (moving + STIFFNESS * engaged**2))


def work(rows: Float) -> Float:
    """What the drive has put in. [J]"""
    power = drive() * rows[1]
    return np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * STEP_S)])


@pytest.mark.parametrize("share", [0.3, 0.97])
def test_both_sides_of_a_spring_move_as_scipy_finds(share: float) -> None:
    near, far = (1.0 - share) * B, share * B
    damping = 2.0 * 0.05 * np.sqrt(STIFFNESS * far)
    driven = drive()

    def rates(t: float, s: Float) -> list[float]:
        torque = STIFFNESS * (s[0] - s[2]) + damping * (s[1] - s[3])
        push = np.interp(t, T, driven)
        return [s[1], (push - torque) / near, s[3], (torque - DRAG * s[3]) / far]

    exact = solve_ivp(rates, (0.0, T[-1]), np.zeros(4), t_eval=T, rtol=1e-7, atol=1e-9, max_step=STEP_S).y
    seen = recording_of(T, np.where(np.arange(len(T)) % 2, exact[0], 0.0), exact[1])
    model = JointModel(inertia_kg_m2=B, terms=(FittedTerm("viscous", (DRAG,)), spring(share)))
    found = simulate_segments(model, seen, drive(), WHOLE)
    assert found == pytest.approx(exact[1], abs=6e-3)
    rigid = simulate_segments(replace(model, terms=model.terms[:1]), seen, drive(), WHOLE)
    assert np.sqrt(np.mean((found - exact[1]) ** 2)) < 0.3 * np.sqrt(np.mean((rigid - exact[1]) ** 2))


@settings(deadline=None, max_examples=15)
@given(st.floats(0.2, 0.95), st.sampled_from([0.0, 0.004]))
def test_energy_is_what_the_drive_put_in(share: float, gap_rad: float) -> None:
    rows = moved(share, gap_rad=gap_rad)
    put, held = work(rows), energy(rows, share, gap_rad)
    assert np.abs(held - put).max() < 0.02 * np.abs(put).max()


@settings(deadline=None, max_examples=15)
@given(st.floats(0.2, 0.95), st.sampled_from([0.0, 0.004]), st.floats(0.05, 0.4), st.floats(0.02, 1.0))
def test_friction_and_damping_only_ever_take_energy(share: float, gap: float, coulomb_nm: float, ratio: float) -> None:
    rows = moved(share, coulomb_nm, gap, ratio)
    taken = work(rows) - energy(rows, share, gap)
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(rows[2])))])
    assert (taken > coulomb_nm * path - 0.02 * np.abs(work(rows)).max()).all()


def test_pieces_begin_with_what_the_recording_has_done_to_the_spring() -> None:
    share, friction = 0.7, 0.2
    rows = moved(share, friction, damping_ratio=0.1)
    model = JointModel(inertia_kg_m2=B, terms=(FittedTerm("coulomb", (friction,)), spring(share, 0.1)))
    pieces = np.array([[300, 700], [700, 1100]])
    found = simulate_segments(model, recording_of(T, rows[0], rows[1]), drive(), pieces)
    inside = np.isfinite(found)
    assert inside.sum() == 801
    assert found[700] == rows[1, 700]
    assert np.sqrt(np.mean((found - rows[1])[inside] ** 2)) < 0.03 * np.sqrt(np.mean(rows[1] ** 2))
