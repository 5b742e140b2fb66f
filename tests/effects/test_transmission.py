"""Delay, elasticity, backlash and lag by hand: each explained by its own effect, by no other as well."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from scipy.optimize import fmin
from scipy.signal import lfilter

from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.registry import effect_of
from friction_audit.effects.transmission import STIFFEST_NM_PER_RAD
from friction_audit.joint_log import Float
from tests.diagnosis.toy_effects import altered
from tests.effects.joint_data_by_hand import STEP_S, baseline, share_explained, two_sines

DATA = two_sines(20.0)
BASE = baseline(DATA)
SUBSTEPS = 10
DELAY, LAG, SPRING, GAP, _ = RIVALS = tuple(
    effect_of(name) for name in ("time_delay", "frictional_lag", "joint_elasticity", "backlash", "presliding")
)


def far_side_torque(stiffness: float, damping: float, half_gap: float, inertia: float = 0.3) -> Float:
    """An inertia with the baseline's friction behind a spring with a dead zone: explicit steps, a ramp for the sign."""
    h = STEP_S / SUBSTEPS
    # From half a sample before to half a sample after each, at a constant speed beyond both ends.
    number = np.arange(len(DATA.q))
    at = (np.arange(len(DATA.q) * SUBSTEPS) + 0.5) / SUBSTEPS - 0.5
    speed = np.interp(at, number, DATA.dq)
    fine = np.interp(at, number, DATA.q) + (at - np.clip(at, 0, number[-1])) * STEP_S * speed
    theta, omega, total = fine[0], speed[0], np.zeros(len(fine))
    for i, (q, v) in enumerate(zip(fine.tolist(), speed.tolist(), strict=True)):
        twist = q - theta
        engaged = max(abs(twist) - half_gap, 0.0)
        push = (stiffness * engaged if twist > 0 else -stiffness * engaged) + (
            damping * (v - omega) if engaged else 0.0
        )
        push = push if push * twist > 0 or half_gap == 0.0 else 0.0
        friction = 0.3 * max(-1.0, min(1.0, omega / 2e-3)) + 0.07 * omega
        omega += h * (push - friction) / inertia
        theta += h * omega
        total[i] = push
    return np.asarray(total.reshape(-1, SUBSTEPS).mean(axis=1))


def seen(torque: Float) -> Float:
    """What a regression sees of a torque: half of its amplitude at 24 Hz."""
    window = np.hanning(9)
    return np.asarray(np.convolve(torque, window / window.sum(), mode="same"))


def share_seen(candidate: Effect, torque: Float) -> float:
    """The share of a torque that a candidate explains, both as a regression sees them."""

    def columns(data: JointData, base: Nominal, shape: Nonlinear) -> Float:
        return seen(candidate.regressor(data, base, shape)[:, 0])[:, None]

    return share_explained(altered(candidate, regressor=columns), DATA, seen(torque))


def best_near_the_grid(candidate: Effect, grid: tuple[Nonlinear, ...], torque: Float) -> float:
    """The same between the points of the grid, from the best one."""

    def left(x: Float, start: Nonlinear) -> float:
        shape = {name: value * np.exp(by) for (name, value), by in zip(start.items(), x, strict=True)}
        return 1.0 - share_seen(altered(candidate, grid=(shape,)), torque)

    best = min(grid, key=lambda shape: left(np.zeros(len(shape)), shape))
    corners = np.vstack([np.zeros(len(best)), 0.1 * np.eye(len(best))])
    found = fmin(left, corners[0], (best,), maxfun=150, disp=False, full_output=True, initial_simplex=corners)
    return 1.0 - float(found[1])


SPEED = np.abs(DATA.dq)
SEEN = lfilter([0.0, STEP_S / 0.06], [1.0, STEP_S / 0.06 - 1.0], SPEED)  # with a lag of 60 ms
LAGGING = np.sign(DATA.dq) * 0.15 * (np.exp(-SEEN / 0.2) - np.exp(-SPEED / 0.2))
LATE = [(DELAY, np.interp(DATA.t - delay, DATA.t, BASE.torque), 0.97) for delay in (0.004, -0.015, 0.03)]


@pytest.mark.parametrize(
    ("own", "torque", "least"), [*LATE, (SPRING, far_side_torque(1e3, 2.0, 0.0), 0.8), (LAG, LAGGING, 0.9)]
)
def test_a_torque_is_its_own_effect_and_no_rival(own: Effect, torque: Float, least: float) -> None:
    share = share_explained(own, DATA, torque)
    assert share > least
    assert max(share_explained(other, DATA, torque) for other in RIVALS if other is not own) < share - 0.1


def test_a_dead_zone_is_a_backlash() -> None:
    """Of one width the grid has more than of another: flanks that strike a moment late ring out of step."""
    widths = (2e-3, 4e-3, 5e-3)
    torques = [far_side_torque(1e4, 20.0, 0.5 * width) for width in widths]
    assert np.median([best_near_the_grid(GAP, GAP.grid(DATA), one) for one in torques]) > 0.9
    rate = sqrt(1e4 / BASE.inertia_kg_m2)
    flanks = {"contact_hz": rate / (2.0 * pi), "flank_damping_ratio": 20.0 / (2.0 * BASE.inertia_kg_m2 * rate)}
    truth = [
        share_seen(altered(GAP, grid=({"gap_rad": width, **flanks},)), torque)
        for width, torque in zip(widths, torques, strict=True)
    ]
    assert min(truth) > 0.94
    assert max(share_seen(other, torques[1]) for other in RIVALS if other is not GAP) < truth[1] - 0.3


@pytest.mark.parametrize(("candidate", "link"), [(SPRING, (600.0, 1.5, 0.0)), (GAP, (1e4, 20.0, 2e-3))])
def test_a_rotor_before_the_transmission_is_not_behind_it(candidate: Effect, link: tuple[float, float, float]) -> None:
    stiffness, damping, half_gap = link
    torque = 0.12 * DATA.ddq + far_side_torque(stiffness, damping, half_gap, 0.18)
    shapes = candidate.grid(DATA)
    one, several = (
        best_near_the_grid(candidate, tuple(s for s in shapes if ("far_share" in s) == lighter), torque)
        for lighter in (False, True)
    )
    assert several > 0.8
    assert 1.0 - several < 0.5 * (1.0 - one)


def test_a_spring_whose_twist_drowns_in_noise_of_the_position_is_none() -> None:
    noise = 1e-4 * np.random.default_rng(0).standard_normal(len(DATA.q))
    moved = replace(DATA, torque=BASE.torque)
    stiffest, coarsest = (
        max(shape["spring_nm_per_rad"] for shape in SPRING.grid(one))
        for one in (moved, replace(moved, q=DATA.q + noise))
    )
    assert stiffest == STIFFEST_NM_PER_RAD
    # Twice 0.3 N m twist it by less than twice the noise; one that rings below 25 Hz is seen by its ringing.
    assert coarsest < 0.3 * (2 * np.pi * 25.0) ** 2 * 1.01


def test_noise_of_the_position_shifts_the_strikes_of_a_play_but_not_along_a_smooth_motion() -> None:
    torque = seen(far_side_torque(1e4, 20.0, 2e-3) - BASE.torque)[400:-400]
    noise = 3e-5 * np.random.default_rng(0).standard_normal(len(DATA.q))
    speed = np.gradient(noise, STEP_S)
    noisy = replace(DATA, q=DATA.q + noise, dq=DATA.dq + speed, ddq=DATA.ddq + np.gradient(speed, STEP_S))
    sharp = {"gap_rad": 4e-3, "contact_hz": 29.0}

    def correlation(shape: Nonlinear) -> float:
        column = seen(GAP.regressor(noisy, baseline(noisy), shape)[:, 0])[400:-400]
        return float(np.corrcoef(column, torque)[0, 1])

    assert correlation(sharp) < 0.8
    assert correlation({**sharp, "motion_below_hz": 18.0}) > 0.9
