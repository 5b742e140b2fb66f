"""A joint with stick and slip against hand calculation, an independent integrator, and the balance of energy."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.stick_slip import Step, advance_body, make_body
from friction_audit.effects.joint_model import FittedTerm, JointModel, simple_model
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from tests.dynamics.joints import Invented, Law, bare_joint, simulate

B, COULOMB, VISCOUS = 0.3, 0.4, 0.1
MODEL = simple_model(inertia_kg_m2=B, coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
STRIBECK = bare_joint(*MODEL.terms, FittedTerm("stribeck", (0.2, 0.1, 1.0)), FittedTerm("offset", (0.02,)))
HELD = {"mass_kg_m2": 0.5, "damping_nms_per_rad": 0.8, "stiffness_nm_per_rad": 4.0}


def clock(stop: float, step: float = 1e-3) -> Float:
    return np.arange(round(stop / step) + 1, dtype=np.float64) * step


def advance(q: float, v: float, sign: float, h: float, drive: tuple[float, float], body: Any, u: float = 0.0) -> Any:
    return advance_body(q, v, sign, Step(h, *drive, 0.0, 0.0), u, body)


def test_constant_torque_gives_the_exponential_by_hand() -> None:
    t = clock(2.0)
    motion = simulate(MODEL, t, np.full(len(t), 1.0))
    top, time = (1.0 - COULOMB) / VISCOUS, B / VISCOUS
    assert motion.dq == pytest.approx(top * (1.0 - np.exp(-t / time)), abs=1e-8)
    assert motion.q == pytest.approx(top * (t - time * (1.0 - np.exp(-t / time))), abs=1e-8)
    assert motion.friction[1:] == pytest.approx(COULOMB + VISCOUS * motion.dq[1:])


def test_it_runs_out_over_b_v2_by_2c_in_the_time_b_v_by_c() -> None:
    model = simple_model(inertia_kg_m2=B, coulomb_nm=COULOMB, viscous_nms_per_rad=0.0)
    t = np.sort(np.concatenate([clock(1.0), [0.7503]]))
    motion = simulate(model, t, np.zeros(len(t)), dq=1.0)
    assert motion.q[-1] == pytest.approx(B / (2.0 * COULOMB), abs=1e-12)
    assert np.all(motion.dq[t >= B / COULOMB] == 0.0)
    assert motion.dissipated[-1] == pytest.approx(0.5 * B, rel=1e-12)


def test_friction_holds_a_joint_below_coulomb_and_shows_what_holds_it() -> None:
    t = clock(1.0)
    drive = 0.39 * np.sin(7.0 * t)
    motion = simulate(MODEL, t, drive, q=0.5)
    assert np.all(motion.q == 0.5)
    assert np.all(motion.dq == 0.0)
    assert motion.friction == pytest.approx(drive, abs=1e-15)
    assert motion.dissipated[-1] == 0.0


def test_it_breaks_away_inside_a_step() -> None:
    """A torque that rises by 1 N m/s passes Coulomb friction at 0.4 s plus the offset, within one step of 1 s."""
    model = simple_model(inertia_kg_m2=B, coulomb_nm=COULOMB, viscous_nms_per_rad=0.0, offset_nm=0.01234)
    _, v, sign, _ = advance(0.0, 0.0, 0.0, 1.0, (0.0, 1.0), make_body(model))
    assert v == pytest.approx((1.0 - 0.41234) ** 2 / (2.0 * B), rel=1e-12)
    assert sign == 1.0


def test_a_torque_held_over_the_step_is_a_drive() -> None:
    body = make_body(MODEL)
    held = advance(0.1, 0.2, 1.0, 1e-3, (0.5, 0.6), body, 0.3)
    assert held == pytest.approx(advance(0.1, 0.2, 1.0, 1e-3, (0.8, 0.9), body), rel=1e-14)


def reference(model: JointModel, held: dict[str, float], t: Float, amplitude: float, rate: float) -> Float:
    """Velocity by scipy, stopped and started again at every reversal; the drive is strong enough never to stick."""
    mass, still = model.inertia_kg_m2 + held.get("mass_kg_m2", 0.0), np.zeros(1)
    damping, stiffness = held.get("damping_nms_per_rad", 0.0), held.get("stiffness_nm_per_rad", 0.0)

    def make_slope(sign: float) -> Callable[[float, Float], list[float]]:
        def slope(time: float, state: Float) -> list[float]:
            motion = Motion(t=still, q=still, dq=np.array([sign * max(sign * state[1], 1e-9)]), ddq=still)
            push = amplitude * np.cos(rate * time) - damping * state[1] - stiffness * state[0]
            return [state[1], (push - model.torque(motion)[0]) / mass]

        return slope

    def make_stop(sign: float) -> Callable[[float, Float], float]:
        def stop(_time: float, state: Float) -> float:
            return float(state[1])

        stop.terminal, stop.direction = True, -sign  # type: ignore[attr-defined]
        return stop

    state, start, sign, out = np.zeros(2), 0.0, 1.0, np.zeros(len(t))
    while start < t[-1]:
        span, events = (start, float(t[-1])), make_stop(sign)
        part = solve_ivp(
            make_slope(sign), span, state, "DOP853", dense_output=True, events=events, rtol=1e-10, atol=1e-12
        )
        inside = (t >= start) & (t <= part.t[-1])
        out[inside] = part.sol(t[inside])[1] if part.sol else np.nan
        start, state, sign = float(part.t[-1]), np.array([part.y[0, -1], 0.0]), -sign
    return out


@pytest.mark.parametrize("model", [MODEL, STRIBECK], ids=["plain", "stribeck"])
@pytest.mark.parametrize("held", [{}, HELD], ids=["free", "held"])
def test_it_agrees_with_an_independent_integrator(model: JointModel, held: dict[str, float]) -> None:
    t = clock(4.0)
    motion = simulate(model, t, 3.0 * np.cos(6.0 * t), **held)
    assert np.count_nonzero(np.diff(np.sign(motion.dq[1:]))) >= 6
    assert motion.dq == pytest.approx(reference(model, held, t, 3.0, 6.0), abs=1e-4)


def test_the_step_is_of_second_order_through_stops_and_break_aways() -> None:
    body = make_body(MODEL)

    def end(steps: int) -> float:
        h, q, v, sign = 2.0 / steps, 0.0, 0.0, 0.0
        for k in range(steps):
            q, v, sign, _ = advance(q, v, sign, h, (np.sin(5.0 * h * k), np.sin(5.0 * h * (k + 1))), body)
        return q

    exact = end(32_000)
    errors = [abs(end(steps) - exact) for steps in (250, 500, 1000, 2000)]
    assert all(3.5 * fine < coarse < 4.5 * fine for coarse, fine in pairwise(errors))
    assert errors[-1] < 2e-6


@settings(deadline=None, max_examples=40)
@given(
    amplitude=st.floats(0.0, 4.0),
    rate=st.floats(0.5, 40.0),
    coulomb=st.floats(0.0, 1.0),
    viscous=st.floats(0.0, 1.0),
    excess=st.floats(0.0, 0.3),
    speed=st.floats(-2.0, 2.0),
)
def test_energy_is_kept(
    amplitude: float, rate: float, coulomb: float, viscous: float, excess: float, speed: float
) -> None:
    terms = simple_model(inertia_kg_m2=1, coulomb_nm=coulomb, viscous_nms_per_rad=viscous).terms
    model = bare_joint(*terms, FittedTerm("stribeck", (excess, 0.1, 1.0)), inertia_kg_m2=0.2)
    body = make_body(model, stiffness_nm_per_rad=2.0)
    q, v, sign, h, balance = 0.1, speed, float(np.sign(speed)), 2e-4, 0.5 * 0.2 * speed**2 + 0.01
    for k in range(1500):
        drive = (amplitude * np.sin(rate * h * k), amplitude * np.sin(rate * h * (k + 1)))
        q_next, v, sign, taken = advance(q, v, sign, h, drive, body)
        assert taken >= 0.0
        balance += 0.5 * sum(drive) * (q_next - q) - taken
        q = q_next
    assert 0.5 * 0.2 * v**2 + q**2 == pytest.approx(balance, abs=1e-5 * (1.0 + amplitude))


def test_in_a_step_without_event_energy_is_kept_to_rounding() -> None:
    body = make_body(MODEL, mass_kg_m2=0.2, stiffness_nm_per_rad=3.0)
    q, v, _, taken = advance(0.1, 1.0, 1.0, 1e-2, (0.5, 0.9), body)
    stored = 0.25 * (v**2 - 1.0) + 1.5 * (q**2 - 0.01)
    assert 0.7 * (q - 0.1) - taken == pytest.approx(stored, abs=1e-15)


def test_the_torque_of_the_motion_is_the_drive() -> None:
    t = clock(3.0)
    drive = 1.5 * np.sin(5.0 * t)
    motion = simulate(STRIBECK, t, drive)
    moving = motion.dq != 0.0
    torque = STRIBECK.torque(Motion(t=t, q=motion.q, dq=motion.dq, ddq=motion.ddq))
    assert torque[moving] == pytest.approx(drive[moving], abs=1e-4)


def test_what_the_operator_pushes_gives_the_recorded_motion_back() -> None:
    """Push = F_m + m ddq + b dq + k q of one motion, met by the same joint, gives the same motion.

    Up to what a push that is linear between samples cannot show: the jump of acceleration at a reversal.
    """
    t = clock(3.0)
    first = simulate(MODEL, t, 1.5 * np.sin(5.0 * t))
    mass, damping, stiffness = HELD.values()
    push = 1.5 * np.sin(5.0 * t) + mass * first.ddq + damping * first.dq + stiffness * first.q
    assert simulate(MODEL, t, push, **HELD).q == pytest.approx(first.q, abs=1e-3)


@pytest.mark.parametrize("inertia", [0.0, -0.1])
def test_a_joint_without_inertia_is_refused(inertia: float) -> None:
    with pytest.raises(AnalysisError, match=r"inertia_kg_m2 = .*expected a number above 0"):
        make_body(JointModel(inertia_kg_m2=inertia))


def test_a_term_of_more_than_the_velocity_is_refused_by_name() -> None:
    with pytest.raises(AnalysisError, match="the model's invented follow from more than the velocity"):
        make_body(bare_joint(*MODEL.terms, Invented(lambda motion: np.sin(motion.q), 0.1)))


def test_friction_that_pushes_is_refused() -> None:
    pushing = Invented(lambda motion: np.sign(motion.dq), -0.5, Law(speed_only=True))
    with pytest.raises(AnalysisError, match="friction pushes at some speed: invented"):
        make_body(bare_joint(*MODEL.terms, pushing))


def test_friction_may_differ_between_the_directions() -> None:
    """With 0.1 N m more forwards and as much less backwards, 0.45 N m moves it backwards only."""
    uneven = Invented(lambda motion: np.ones(len(motion.t)), 0.1, Law(speed_only=True))
    model, t = bare_joint(*MODEL.terms, uneven), clock(1.0)
    assert simulate(model, t, np.full(len(t), 0.45)).dq[-1] == 0.0
    top, time = (0.45 - 0.3) / VISCOUS, B / VISCOUS
    backwards = simulate(model, t, np.full(len(t), -0.45))
    assert backwards.dq[-1] == pytest.approx(-top * (1.0 - np.exp(-1.0 / time)), abs=1e-8)
