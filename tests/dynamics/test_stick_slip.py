"""A joint with stick and slip against hand calculation and an independent integrator."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.stick_slip import Step, advance
from friction_audit.effects.joint_model import FittedTerm, JointModel, simple_model
from friction_audit.joint_log import Float
from tests.dynamics.joints import simulate, tables_of

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
    t = np.sort(np.concatenate([clock(1.0), [0.7503]]))
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
    """Velocity by scipy, stopped and started again at every reversal; the drive is strong enough never to stick."""
    still = np.zeros(1)

    def make_slope(sign: float) -> Callable[[float, Float], list[float]]:
        def slope(time: float, state: Float) -> list[float]:
            motion = Motion(t=still, q=still, dq=np.array([sign * max(sign * state[1], 1e-9)]), ddq=still)
            return [state[1], (amplitude * np.cos(rate * time) - model.torque(motion)[0]) / model.inertia_kg_m2]

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
