"""The compensator in closed loop with a hand, a mass and friction whose size is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.compensation.compensators import Coefficients, EnergyCompensator, FixedCompensation
from friction_audit.compensation.records import ESTIMATED, TOO_ALIKE, TOO_FEW
from friction_audit.joint_log import Float
from tests.compensation.hand_bench import TICK_S, Bench, drive

VISCOUS = Bench(viscous_nms_per_rad=0.2)
COULOMB = Bench(coulomb_nm=0.3)
COMBINED = Bench(coulomb_nm=0.3, viscous_nms_per_rad=0.07, growth_per_s=0.1)
OVER: dict[str, Any] = {
    "model": "viscous",
    "zero_crossings": True,
    "forced": Coefficients(viscous_nms_per_rad=0.3),
}
"""Compensated with 30 where 20 is true, as in Fig 7."""


def ends(signals: dict[str, Float]) -> np.ndarray[Any, Any]:
    return np.flatnonzero(np.diff(signals["cycle"])) + 1


def test_the_bench_conserves_energy() -> None:
    bench = replace(COMBINED, link_kg_m2=0.2)
    signals = drive(bench, FixedCompensation(coulomb_nm=0.2, viscous_nms_per_rad=0.05))
    moved = 0.5 * (signals["dq"][1:] + signals["dq"][:-1]) * TICK_S
    put_in = signals["energy_j"] + np.concatenate([[0.0], np.cumsum(signals["u_nm"][:-1] * moved)])
    kinetic = 0.5 * bench.motor_kg_m2 * signals["dq"] ** 2
    assert put_in == pytest.approx(kinetic + signals["friction_j"], abs=2e-4 * signals["friction_j"][-1])


@pytest.mark.parametrize("link", [0.0, 0.3])
@pytest.mark.parametrize("zero_crossings", [False, True])
@pytest.mark.parametrize(
    ("bench", "model", "name", "truth"),
    [
        (VISCOUS, "viscous", "estimated_viscous_nms_per_rad", 0.2),
        (COULOMB, "coulomb", "estimated_coulomb_nm", 0.3),
    ],
)
def test_one_coefficient_is_right_after_the_first_cycle(
    bench: Bench, model: str, name: str, truth: float, zero_crossings: bool, link: float
) -> None:
    signals = drive(replace(bench, link_kg_m2=link), EnergyCompensator(model=model, zero_crossings=zero_crossings))
    first = ends(signals)[0]
    assert first * TICK_S == pytest.approx(bench.stroke_s, abs=0.02)
    assert np.all(np.isnan(signals[name][:first]))
    assert np.all(signals["u_nm"][:first] == 0.0)
    assert signals[name][first:] == pytest.approx(truth, rel=2e-3)


@pytest.mark.parametrize("link", [0.0, 0.3])
def test_combined_is_right_after_two_cycles(link: float) -> None:
    signals = drive(replace(COMBINED, link_kg_m2=link), EnergyCompensator())
    first, second = ends(signals)[:2]
    assert signals["status"][first] == TOO_FEW
    assert signals["status"][second] == ESTIMATED
    assert signals["estimated_coulomb_nm"][second:] == pytest.approx(0.3, rel=1e-2)
    assert signals["estimated_viscous_nms_per_rad"][second:] == pytest.approx(0.07, rel=3e-2)
    assert signals["estimated_viscous_nms_per_rad"][-1] == pytest.approx(0.07, rel=5e-3)


@pytest.mark.parametrize(("bench", "model"), [(VISCOUS, "viscous"), (COULOMB, "coulomb"), (COMBINED, "combined")])
def test_the_energy_stays_once_friction_is_compensated(bench: Bench, model: str) -> None:
    signals = drive(bench, EnergyCompensator(model=model))
    cyclic = signals["energy_j"][ends(signals)]
    known = 1 if model == "combined" else 0
    per_cycle = cyclic[0]
    assert np.abs(np.diff(cyclic[known:])).max() < 0.01 * per_cycle
    assert drive(bench, None)["energy_j"][-1] > 5 * per_cycle


def test_a_step_of_friction_is_found_at_the_end_of_the_cycle_after_it() -> None:
    bench = replace(VISCOUS, viscous_nms_per_rad=0.1, later_viscous_nms_per_rad=0.2, later_s=3.0, duration_s=6.0)
    signals = drive(bench, EnergyCompensator(model="viscous", zero_crossings=True))
    borders = ends(signals)
    estimates = signals["estimated_viscous_nms_per_rad"][borders]
    assert estimates[:3] == pytest.approx(0.1, rel=5e-3)
    assert estimates[3:] == pytest.approx(0.2, rel=5e-3)
    cyclic = signals["energy_j"][borders]
    assert cyclic[1:3] == pytest.approx(cyclic[0], rel=5e-3)
    assert cyclic[3] > 1.8 * cyclic[0]
    assert cyclic[4:] == pytest.approx(cyclic[3], rel=5e-3)


def test_a_step_within_a_cycle_is_right_after_the_next_one() -> None:
    bench = replace(VISCOUS, viscous_nms_per_rad=0.1, later_viscous_nms_per_rad=0.2, later_s=2.5, duration_s=5.0)
    signals = drive(bench, EnergyCompensator(model="viscous"))
    estimates = signals["estimated_viscous_nms_per_rad"][ends(signals)]
    assert 0.12 < estimates[2] < 0.18
    assert estimates[3] == pytest.approx(0.2, rel=5e-3)


def test_cycles_too_alike_give_no_first_estimate() -> None:
    signals = drive(replace(COMBINED, growth_per_s=0.0, duration_s=6.0), EnergyCompensator(condition_limit=100.0))
    assert TOO_ALIKE in signals["status"]
    assert signals["refused"][-1] > 0
    refused = np.flatnonzero(np.diff(signals["refused"])) + 1
    for name in ("estimated_coulomb_nm", "estimated_viscous_nms_per_rad"):
        assert np.array_equal(signals[name][refused], signals[name][refused - 1], equal_nan=True)


def test_over_compensated_without_the_controller_the_energy_falls_below_zero() -> None:
    signals = drive(VISCOUS, EnergyCompensator(passivity=False, **OVER))
    cyclic = signals["energy_j"][ends(signals)]
    assert np.all(np.diff(cyclic) < -0.4 * cyclic[0])
    assert signals["energy_j"].min() < -cyclic[0]
    assert np.all(signals["passivity_nm"] == 0.0)
    assert signals["active_energy_j"][-1] < signals["energy_j"][-1] - 0.9 * cyclic[0]


@pytest.mark.parametrize("link", [0.0, 0.3])
def test_over_compensated_with_the_controller_it_does_not_and_the_estimate_takes_over(link: float) -> None:
    signals = drive(replace(VISCOUS, link_kg_m2=link), EnergyCompensator(**OVER))
    borders = ends(signals)
    cyclic = signals["energy_j"][borders]
    assert signals["energy_j"].min() > -0.01 * cyclic[0]
    acted = np.flatnonzero(signals["damping_nms_per_rad"] > 0.0)[0]
    after = borders[borders > acted][0]
    assert np.all(signals["viscous_nms_per_rad"][borders[0] : after] == 0.3)
    assert signals["viscous_nms_per_rad"][after:] == pytest.approx(0.2, rel=1e-2)
    assert signals["acted"][acted:after].min() == 1.0
    assert np.all(signals["passivity_nm"] * signals["dq"] <= 0.0)
    assert signals["dissipated_j"][-1] > 0.0


def test_in_a_closed_loop_the_dissipation_must_not_be_counted_twice() -> None:
    once = drive(VISCOUS, EnergyCompensator(**OVER))
    twice = drive(VISCOUS, EnergyCompensator(controller_in_interaction=False, **OVER))
    assert twice["energy_j"].min() == pytest.approx(-twice["dissipated_j"][-1], rel=0.05)
    assert twice["energy_j"][-1] < 0.9 * twice["energy_j"].min()
    assert once["energy_j"].min() > 0.6 * twice["energy_j"].min()


def test_damping_without_bound_makes_a_soft_hand_unstable() -> None:
    bench = replace(VISCOUS, duration_s=3.05)
    assert np.abs(drive(bench, EnergyCompensator(**OVER))["u_nm"]).max() < 5.0
    assert np.abs(drive(bench, EnergyCompensator(max_damping_nms_per_rad=1e9, **OVER))["u_nm"]).max() > 50.0


def test_forced_coefficients_may_stay() -> None:
    given_ones = EnergyCompensator(model="viscous", forced=Coefficients(viscous_nms_per_rad=0.3), forced_from_cycle=1)
    signals = drive(VISCOUS, replace(given_ones, forced_until_acted=False))
    assert np.all(signals["viscous_nms_per_rad"] == 0.3)
    assert np.any(signals["damping_nms_per_rad"] > 0.0)


def test_the_factor_over_compensates_and_the_estimate_stays_right() -> None:
    signals = drive(VISCOUS, EnergyCompensator(model="viscous", factor=1.5, passivity=False))
    first = ends(signals)[0]
    assert signals["viscous_nms_per_rad"][first:] == pytest.approx(0.3, rel=5e-3)
    assert signals["estimated_viscous_nms_per_rad"][first:] == pytest.approx(0.2, rel=5e-3)


def test_the_work_of_a_clipped_torque_is_that_of_the_torque_applied() -> None:
    limited = EnergyCompensator(model="viscous", max_torque_nm=0.1, max_torque_rate_nm_s=1.0)
    signals = drive(VISCOUS, limited)
    first = ends(signals)[0]
    assert signals["estimated_viscous_nms_per_rad"][first:] == pytest.approx(0.2, rel=5e-3)
    assert np.abs(signals["u_nm"]).max() == 0.1
    assert np.abs(np.diff(signals["u_nm"])).max() == pytest.approx(1.0 * TICK_S)


def test_the_coulomb_term_does_not_chatter_at_standstill() -> None:
    signals = drive(replace(COULOMB, amplitude_rad=1e-4), EnergyCompensator(forced=Coefficients(coulomb_nm=0.3)))
    assert np.all(signals["dq"] == 0.0)
    assert np.all(signals["u_nm"] == 0.0)


@settings(max_examples=25, deadline=None)
@given(
    viscous=st.floats(0.05, 0.3),
    excess=st.floats(1.1, 2.0),
    motor=st.floats(0.1, 0.6),
    link=st.floats(0.05, 0.6),
)
def test_the_controller_holds_the_energy_whatever_the_joint(
    viscous: float, excess: float, motor: float, link: float
) -> None:
    bench = Bench(viscous_nms_per_rad=viscous, motor_kg_m2=motor, link_kg_m2=link, duration_s=6.0)
    forced = Coefficients(viscous_nms_per_rad=excess * viscous)
    compensator = EnergyCompensator(
        model="viscous", forced=forced, forced_from_cycle=1, forced_until_acted=False, zero_crossings=True
    )
    free = drive(bench, replace(compensator, passivity=False))["energy_j"]
    held = drive(bench, compensator)["energy_j"]
    peak = 0.5 * motor * (bench.amplitude_rad * np.pi / bench.stroke_s) ** 2
    assert held.min() > 0.1 * free.min() - 0.01 * peak
