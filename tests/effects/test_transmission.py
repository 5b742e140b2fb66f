"""Delay, elasticity, backlash, lag and stiction by hand: each explained by its own effect, by no other as well."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.optimize import fmin
from scipy.signal import lfilter

from friction_audit.diagnosis.samples import make_samples
from friction_audit.effects import breakaway
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.registry import effect_of
from friction_audit.effects.transmission import STIFFEST_NM_PER_RAD
from friction_audit.joint_log import Float
from friction_audit.reporting.notices import sentence_of
from tests.diagnosis.toy_effects import altered
from tests.effects.joint_data_by_hand import (
    COULOMB_NM,
    EXCESS_NM,
    RISE_NM_PER_S,
    STEP_S,
    baseline,
    share_explained,
    started_and_stopped,
    two_sines,
)

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


# Stiction: moments of break-away by hand, what it takes to be seen, and the excess of a joint that breaks away.

AT_ONCE = {"ageing_s": 0.01, "renewal_rad": breakaway.AT_ONCE_RAD}
GRID_S = 1.0 / 400.0
T: Float = np.arange(800, dtype=np.float64) * GRID_S
DEAD = 3e-3
LEVEL, RISE, INERTIA = 0.3, 2.0, 0.5


def start(onset_s: float, direction: float = 1.0, excess: float = 0.0) -> tuple[Float, Float, Float]:
    """Position, velocity and torque of a joint that breaks away when its rising torque passes level plus excess."""
    u = np.maximum(T - onset_s, 0.0)
    jump, rate = excess / INERTIA, RISE / INERTIA
    q, dq = jump * u**2 / 2 + rate * u**3 / 6, jump * u + rate * u**2 / 2
    return direction * q, direction * dq, direction * (LEVEL + excess + RISE * (T - onset_s))


@given(onset_s=st.floats(0.3, 1.5), direction=st.sampled_from([-1.0, 1.0]))
def test_a_smooth_start_reads_the_level_of_sliding(onset_s: float, direction: float) -> None:
    q, dq, torque = start(onset_s, direction)
    found = breakaway.find_breakaways(q, dq, DEAD, GRID_S)
    assert found.direction.tolist() == [direction]
    assert T[found.onset[0]] == pytest.approx(onset_s, abs=GRID_S)
    assert found.of(torque)[0] == pytest.approx(direction * LEVEL, abs=RISE * GRID_S)
    bent = 1.0 + 3.0 * T - 7.0 * T**2  # is carried on exactly
    assert found.of(np.column_stack([bent, T])) == pytest.approx(np.column_stack([bent, T])[found.onset])
    assert found.samples[0, -1] < found.onset[0]
    assert (found.samples.shape[1] - 1) * GRID_S == pytest.approx(breakaway.STANDSTILL_S)


A_START = start(1.0)[:2]


@pytest.mark.parametrize(
    ("q", "dq", "starts"),
    [
        (*A_START, 1),
        (A_START[0] + 0.02 * DEAD * T, A_START[1], 1),
        (A_START[0] + 0.5 * DEAD * T, A_START[1], 0),
        (-np.cos(2 * np.pi * T), 2 * np.pi * np.sin(2 * np.pi * T), 0),
        (A_START[0] + 1e-4 * (T >= 0.9), A_START[1], 0),
        (A_START[0], np.where(A_START[1] < 1.5 * DEAD, A_START[1], 0.0), 0),
        (0.0 * T, 0.0 * T, 0),
    ],
    ids=["start", "hardly creeps", "creeps", "turns around", "count of the encoder", "twitch", "never moves"],
)
def test_what_is_a_start(q: Float, dq: Float, starts: int) -> None:
    found = breakaway.find_breakaways(q, dq, DEAD, GRID_S)
    assert found.of(np.zeros((len(q), 3))).shape == (starts, 3)


@pytest.mark.parametrize("direction", [-1.0, 1.0])
def test_a_start_by_a_motor_that_held_the_other_way_tells_nothing(direction: float) -> None:
    q, dq, _ = start(1.0, direction)
    torque = direction * (LEVEL + 0.5 * RISE * (T - 1.0))
    found = breakaway.find_breakaways(q, dq, DEAD, GRID_S)
    jumps = np.where(T < 1.0, -direction * LEVEL, direction * (LEVEL + 100.0 * (T - 1.0)))
    falls = np.where(T < 1.0, torque, 0.8 * torque)
    assert [breakaway.torque_known(each, found, GRID_S).tolist() for each in (torque, jumps, falls)] == [
        [True],
        [False],
        [True],
    ]


@pytest.mark.parametrize(("fall", "known"), [(0.0, False), (0.05, False), (0.3, True)])
def test_a_start_under_a_fast_torque_tells_something_where_that_falls_behind_it(fall: float, known: bool) -> None:
    q, dq, _ = start(1.0, excess=0.3)
    found = breakaway.find_breakaways(q, dq, DEAD, GRID_S)
    rising = LEVEL + 0.3 + 10.0 * (T - T[found.onset[0]])
    behind = LEVEL + 0.3 - fall
    assert breakaway.torque_known(np.where(T[found.onset[0]] < T, behind, rising), found, GRID_S).tolist() == [known]


def jumping() -> JointData:
    """A joint that starts so fast that no row tells of it."""
    data = started_and_stopped()
    since = data.t % 1.0 - 0.5
    # The last 20 ms before a start take the torque up to friction: no few milliseconds say what it was.
    direction = np.where(data.t % 2.0 < 1.0, 1.0, -1.0)
    jump = np.where((since > -0.02) & (since < 0.0), 40.0 * (since + 0.02), 0.0) * direction
    held_by_friction = np.where(since >= 0.0, EXCESS_NM + 0.8, 0.0) * direction
    assert effect_of("stiction").not_identifiable(data, baseline(data)) is None
    return replace(data, torque=data.torque + jump + held_by_friction)


@pytest.mark.parametrize(
    ("data", "lacking"),
    [
        (two_sines(), "breaks away from a standstill 0 times"),
        (started_and_stopped(starts=breakaway.FEWEST_BREAKAWAYS - 1), f"at least {breakaway.FEWEST_BREAKAWAYS} times"),
        (started_and_stopped(starts=breakaway.FEWEST_BREAKAWAYS), "None"),
        (jumping(), "0 of them under a torque that rises slowly"),
    ],
    ids=["turns around", "too few starts", "enough", "torque that jumps"],
)
def test_so_many_starts_are_enough(data: JointData, lacking: str) -> None:
    found = effect_of("stiction").not_identifiable(data, baseline(data))
    assert lacking in (sentence_of(found) if found else "None")


def test_an_excess_that_fades_over_a_path_is_looked_for_after_any_start() -> None:
    shapes = effect_of("stiction").identifiable_part(jumping())
    assert len(shapes) == len(effect_of("stiction").grid(jumping())) - len(breakaway.AGEINGS_S)
    assert min(shape["renewal_rad"] for shape in shapes) > breakaway.AT_ONCE_RAD


def test_its_factor_is_the_excess_less_what_the_torque_rises_in_a_few_milliseconds() -> None:
    data = started_and_stopped(noise_nm=0.005, starts=40)
    rows = make_samples(data)
    column = rows.of(effect_of("stiction").regressor(data, baseline(data), AT_ONCE))
    base = rows.of(np.column_stack([data.ddq, np.sign(data.dq)]))
    factors = np.linalg.lstsq(np.hstack([base, column]), rows.y, rcond=None)[0]
    assert factors[1] == pytest.approx(COULOMB_NM, abs=0.005)
    assert EXCESS_NM - 0.015 * RISE_NM_PER_S < factors[2] < EXCESS_NM + 0.005
    assert np.abs(column[rows.weight == 1.0]).max() < 0.01
