"""Replay along the recorded motion, on logs of the simulator whose friction is known."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from friction_audit.audit import AuditSettings, LogReplay, replay_log
from friction_audit.joint_log import Float, JointLog
from friction_audit.replay.compensator import Coefficients, EnergyCompensator, FixedCompensation
from friction_audit.replay.result import JointReplay
from friction_audit.replay.settings import ReplaySettings, energy_compensator
from friction_audit.simulate.bench import BenchSettings, simulate_bench
from friction_audit.simulate.effects.friction_step import FrictionStep
from friction_audit.simulate.effects.hidden import Hidden
from friction_audit.simulate.motion import Sinusoid
from friction_audit.simulate.operator import Operator
from friction_audit.simulate.settings import IDEAL_SENSORS, PANDA_SENSORS, JointParameters

JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
VISCOUS_JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.0, viscous_nms_per_rad=0.2)
BY_HAND = Operator(motion=Sinusoid(spread=0.3))
BENCH = BenchSettings(joints=(JOINT,), sensors=(IDEAL_SENSORS,), operator=BY_HAND, duration_s=30.0)
VISCOUS_BENCH = replace(BENCH, joints=(VISCOUS_JOINT,))


@cache
def log_of(settings: BenchSettings, seed: int = 1) -> JointLog:
    return simulate_bench(settings, seed).log


def replay(
    log: JointLog, compensator: EnergyCompensator | FixedCompensation, max_torque_nm: float | None = None
) -> LogReplay:
    settings = ReplaySettings(compensator=compensator, max_torque_nm=max_torque_nm)
    return replay_log(log, AuditSettings(), settings)


def column(channel: Float | None) -> Float:
    assert channel is not None
    return channel[:, 0]


def joint_of(log: JointLog, compensator: EnergyCompensator | FixedCompensation) -> JointReplay:
    return replay(log, compensator).replay.joints[0]


@pytest.mark.parametrize(
    ("settings", "compensator"),
    [(BENCH, EnergyCompensator()), (VISCOUS_BENCH, EnergyCompensator(model="viscous")), (BENCH, energy_compensator())],
    ids=["combined", "viscous", "default"],
)
def test_without_noise_no_dissipation_is_left_after_the_second_update(
    settings: BenchSettings, compensator: EnergyCompensator
) -> None:
    numbers = joint_of(log_of(settings), compensator).numbers
    assert numbers is not None
    assert numbers.dissipation_removed_updated >= 0.99
    assert numbers.dissipation_removed < numbers.dissipation_removed_updated


def test_with_the_noise_of_a_panda_little_is_left() -> None:
    noisy = BenchSettings(joints=(JOINT,), sensors=(PANDA_SENSORS[0],), duration_s=60.0)
    found = [joint_of(log_of(noisy, seed), energy_compensator()).numbers for seed in range(5)]
    removed = [numbers.dissipation_removed_updated for numbers in found if numbers is not None]
    assert len(removed) == 5
    assert np.median(removed) >= 0.95


def test_torques_and_energies_add_up() -> None:
    log = log_of(BENCH)
    joint = joint_of(log, energy_compensator())
    assert joint.replayed is not None
    assert joint.numbers is not None
    given = joint.replayed.compensation_nm + joint.replayed.passivity_nm
    np.testing.assert_allclose(joint.replayed.interaction_nm + given, column(log.tau_interaction), atol=1e-12)
    dq = log.dq[:, 0]
    work = float(np.sum(0.25 * (given[1:] + given[:-1]) * (dq[1:] + dq[:-1]) * np.diff(log.t)))
    assert joint.numbers.energy_without_j - joint.numbers.energy_with_j == pytest.approx(work, abs=1e-9)
    assert joint.replayed.net_energy_j[-1] == pytest.approx(joint.numbers.energy_with_j, abs=1e-9)


def test_a_compensator_that_gives_nothing_changes_nothing() -> None:
    joint = joint_of(log_of(BENCH), FixedCompensation(coulomb_nm=0.0, viscous_nms_per_rad=0.0))
    assert joint.replayed is not None
    assert joint.numbers is not None
    np.testing.assert_array_equal(joint.replayed.interaction_nm, joint.without.interaction_nm)
    assert joint.numbers.dissipation_removed == 0.0
    assert joint.numbers.cycles_to_converge is None


@pytest.mark.parametrize(
    "compensator",
    [
        EnergyCompensator(),
        EnergyCompensator(model="coulomb"),
        EnergyCompensator(window=4, factor=1.5, max_torque_rate_nm_s=1000.0),
    ],
    ids=["combined", "coulomb", "limited"],
)
def test_a_log_of_the_closed_loop_gives_the_same_torque_again(compensator: EnergyCompensator) -> None:
    log = log_of(replace(BENCH, compensator=compensator))
    joint = joint_of(log, compensator)
    assert joint.replayed is not None
    assert joint.numbers is not None
    assert np.abs(column(log.tau_compensation)).max() > 0.2
    np.testing.assert_allclose(joint.replayed.compensation_nm, column(log.tau_compensation), atol=1e-6)
    np.testing.assert_allclose(joint.replayed.passivity_nm, column(log.tau_passivity), atol=1e-6)
    np.testing.assert_allclose(joint.replayed.interaction_nm, column(log.tau_interaction), atol=1e-6)
    assert joint.numbers.energy_with_j == pytest.approx(joint.numbers.energy_recorded_j, abs=1e-6)
    assert joint.numbers.energy_without_j > 2.0 * joint.numbers.energy_recorded_j


OVER = EnergyCompensator(model="viscous", forced=Coefficients(viscous_nms_per_rad=0.3))


@pytest.mark.parametrize(
    "compensator", [OVER, EnergyCompensator(model="viscous", factor=1.5)], ids=["forced", "factor"]
)
def test_over_compensation_is_taken_back(compensator: EnergyCompensator) -> None:
    joint = joint_of(log_of(VISCOUS_BENCH), compensator)
    history, replayed, passivity = joint.history, joint.replayed, joint.passivity
    assert history is not None
    assert replayed is not None
    assert passivity is not None
    sample = float(np.abs(replayed.interaction_nm * replayed.dq).max()) * 1e-3
    assert replayed.net_energy_j[history.stop].min() >= -sample
    assert passivity.lowest_j >= -2 * sample
    assert passivity.violations == 0
    assert passivity.injected_j > 0.0
    acted = int(np.argmax(history.acted))
    assert history.acted[acted]
    np.testing.assert_allclose(history.viscous_estimated_nms_per_rad[acted:], 0.2, rtol=0.02)


def test_the_reserve_of_the_first_cycle_is_said_to_hide_over_compensation() -> None:
    found = replay(log_of(VISCOUS_BENCH), OVER)
    passivity = found.replay.joints[0].passivity
    assert passivity is not None
    assert passivity.hidden
    assert passivity.active_cycles >= 1
    assert passivity.lowest_since_activation_j < -0.9 * passivity.reserve_j
    assert "over_compensation_hidden" in {caution.code for caution in found.replay.warnings}
    quiet = replay(log_of(VISCOUS_BENCH), EnergyCompensator(model="viscous"))
    assert quiet.replay.warnings == ()


def test_without_the_controller_the_ledger_falls() -> None:
    joint = joint_of(log_of(VISCOUS_BENCH), EnergyCompensator(model="viscous", factor=1.5, passivity=False))
    assert joint.passivity is not None
    assert joint.passivity.violations > 1000
    assert joint.passivity.injected_j == 0.0


@pytest.mark.parametrize(("model", "k"), [("viscous", 1), ("viscous", 3), ("coulomb", 1)])
def test_a_step_of_friction_is_found_and_overcome(model: str, k: int) -> None:
    joint = replace(VISCOUS_JOINT) if model == "viscous" else replace(JOINT, viscous_nms_per_rad=0.0)
    stepped = replace(BENCH, joints=(joint,), hidden=(Hidden(friction_step=FrictionStep(change=1.0)),), duration_s=40.0)
    found = joint_of(log_of(stepped), EnergyCompensator(model=model, window=k, dead_band_rad_s=0.0, ramp_rad_s=0.0))
    history, recovery = found.history, found.recovery
    assert history is not None
    assert recovery is not None
    assert recovery.step_s == pytest.approx(20.0, abs=2.0)
    assert recovery.change == pytest.approx(2.0, rel=0.05)
    assert recovery.cycles is not None
    assert recovery.cycles <= k + 1
    truth = 0.4 if model == "viscous" else 0.6
    unit = "viscous_estimated_nms_per_rad" if model == "viscous" else "coulomb_estimated_nm"
    after = history.start_s >= 20.0 - 0.5
    estimates = getattr(history, unit)[after]
    np.testing.assert_allclose(estimates[k:], truth, rtol=0.05)


def test_limits_of_an_arm_hold_and_are_reported() -> None:
    panda = log_of(BENCH)
    named = replace(panda, source=replace(panda.source, robot="panda"))
    joint = joint_of(named, energy_compensator())
    assert (joint.limits.torque_nm, joint.limits.rate_nm_s) == (87.0, 1000.0)
    found = replay(named, energy_compensator(), max_torque_nm=0.1)
    joint = found.replay.joints[0]
    assert joint.numbers is not None
    assert joint.numbers.peak_compensation_nm == pytest.approx(0.1)
    assert joint.numbers.limited_fraction > 0.3
    assert [caution.code for caution in found.replay.warnings] == ["torque_limited"]


def test_a_joint_at_rest_says_why() -> None:
    log = log_of(BENCH)
    still = replace(log, q=0.0 * log.q, dq=0.0 * log.dq, tau_interaction=0.0 * log.q)
    found = replay(still, energy_compensator())
    joint = found.replay.joints[0]
    assert "did not move" in joint.reason
    assert joint.numbers is None
    assert [caution.code for caution in found.replay.warnings] == ["not_replayed"]


def test_too_few_cycles_say_so() -> None:
    joint = joint_of(log_of(BENCH).take_window(0.0, 5.0), EnergyCompensator(window=4))
    assert joint.reason.startswith("only ")
    assert joint.history is None


def test_an_unnamed_compensator_is_suspected() -> None:
    too_much = FixedCompensation(coulomb_nm=0.5, viscous_nms_per_rad=0.1)
    log = log_of(replace(BENCH, compensator=too_much))
    assert replay(log, energy_compensator()).replay.warnings == ()
    silent = replace(log, tau_compensation=None, tau_passivity=None)
    codes = {caution.code for caution in replay(silent, energy_compensator()).replay.warnings}
    assert "seems_compensated" in codes


def test_friction_far_below_a_panda_s_is_suspected() -> None:
    most = FixedCompensation(coulomb_nm=0.27, viscous_nms_per_rad=0.06)
    log = log_of(replace(BENCH, compensator=most))
    silent = replace(log, tau_compensation=None, tau_passivity=None, source=replace(log.source, robot="panda"))
    codes = {caution.code for caution in replay(silent, energy_compensator()).replay.warnings}
    assert "seems_compensated" in codes
