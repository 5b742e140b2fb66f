"""Replay along the recorded motion, on logs of the simulator whose friction is known; in blocks as in one piece."""

from dataclasses import replace
from itertools import cycle
from math import inf
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from friction_audit.compensation.competitors import FixedCompensation
from friction_audit.compensation.law import Coefficients, EnergyCompensator
from friction_audit.compensation.settings import Competitor, ReplaySettings, energy_compensator
from friction_audit.joint_log import JointLog, LogInBlocks
from friction_audit.pipeline import AuditSettings, LogReplay, estimate_log, replay_estimate
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from friction_audit.reporting.notices import sentence_of, text_of
from friction_audit.reporting.replay import REPLAY
from friction_audit.simulation import ArmSettings, simulate
from friction_audit.simulation.bench import BenchSettings, Operator
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.slow_and_events import FrictionStep
from friction_audit.simulation.settings import IDEAL_SENSORS, PANDA_SENSORS, JointParameters, Sensors
from tests.compensation.bench import BENCH, BY_HAND, JOINT, log_of, replay
from tests.each_case import thorough, with_thorough
from tests.friction.test_blocks import in_blocks, recorded
from tests.pinned.commands import pinned
from tests.pinned.test_pinned import differences

VISCOUS_JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.0, viscous_nms_per_rad=0.2)
VISCOUS_BENCH = replace(BENCH, joints=(VISCOUS_JOINT,))
HOW = pytest.mark.parametrize("operator", [Operator(), BY_HAND], ids=["stop and go", "sinusoid"])


def compensated(log: JointLog, compensator: EnergyCompensator, **limits: Any) -> Any:
    return replay(log, ReplaySettings(compensator=compensator, **limits))


def joint_of(log: JointLog, compensator: EnergyCompensator) -> Any:
    return compensated(log, compensator).joints[0]


ONE_BY_ONE = {"viscous": VISCOUS_JOINT, "coulomb": replace(JOINT, viscous_nms_per_rad=0.0), "combined": JOINT}
"""A joint for each friction model."""


def friction_of(joint: JointParameters, history: Any) -> Any:
    """Return the mean friction torque of a joint over the path of each cycle. [N m]"""
    return joint.coulomb_nm + joint.viscous_nms_per_rad * history.square_speed_rad2_s / history.path_rad


def estimated_friction(joint: Any) -> Any:
    """Return the mean friction torque over the path of each cycle, by the estimate that its end made known. [N m]"""
    history = joint.history
    speed = history.square_speed_rad2_s / history.path_rad
    coulomb, viscous = history.coulomb_estimated_nm, history.viscous_estimated_nms_per_rad
    return np.nan_to_num(coulomb) + np.nan_to_num(viscous) * speed


@pytest.mark.parametrize(
    ("settings", "compensator"),
    [(BENCH, EnergyCompensator()), (VISCOUS_BENCH, EnergyCompensator(model="viscous")), (BENCH, energy_compensator())],
    ids=["combined", "viscous", "default"],
)
def test_without_noise_no_dissipation_is_left_after_the_second_update(
    settings: BenchSettings, compensator: EnergyCompensator
) -> None:
    numbers = joint_of(log_of(settings), compensator).numbers
    assert numbers.dissipation_removed_updated >= 0.99
    assert numbers.dissipation_removed < numbers.dissipation_removed_updated


NOISY = replace(PANDA_SENSORS[0], clock_jitter_s=0.0, stale=0.0, lost=0.0)


@pytest.mark.parametrize(
    ("compensator", "sensors"),
    [
        (EnergyCompensator(), NOISY),
        (EnergyCompensator(model="coulomb"), IDEAL_SENSORS),
        (EnergyCompensator(window=4, factor=1.5, max_torque_rate_nm_s=1000.0), IDEAL_SENSORS),
    ],
    ids=["combined", "coulomb", "limited"],
)
def test_a_log_of_the_closed_loop_gives_the_same_torque_again(compensator: EnergyCompensator, sensors: Sensors) -> None:
    """The log is what the compensator saw, noise and all."""
    log: Any = log_of(replace(BENCH, sensors=(sensors,), compensator=compensator))
    joint = joint_of(log, compensator)
    assert np.abs(log.tau_compensation[:, 0]).max() > 0.2
    np.testing.assert_allclose(joint.replayed.compensation_nm, log.tau_compensation[:, 0], atol=1e-6)
    np.testing.assert_allclose(joint.replayed.passivity_nm, log.tau_passivity[:, 0], atol=1e-6)
    np.testing.assert_allclose(joint.replayed.interaction_nm, log.tau_interaction[:, 0], atol=1e-6)
    assert joint.numbers.energy_with_j == pytest.approx(joint.numbers.energy_recorded_j, abs=1e-6)
    assert joint.numbers.energy_without_j > 2.0 * joint.numbers.energy_recorded_j


OVER = EnergyCompensator(model="viscous", forced=Coefficients(viscous_nms_per_rad=0.3))
TOO_MUCH: dict[str, dict[str, Any]] = {
    "viscous": {"forced": Coefficients(viscous_nms_per_rad=0.3)},
    "coulomb": {"forced": Coefficients(coulomb_nm=0.45)},
    "combined": {"forced": Coefficients(coulomb_nm=0.45, viscous_nms_per_rad=0.105), "window": 4},
}
"""Half as much again as the joints of ONE_BY_ONE have, by model."""


# Pairwise: each model forced, recorded with it, and by a factor, recorded without; each under both operators.
FORCED = [("viscous", True, Operator()), ("coulomb", True, BY_HAND), ("combined", True, Operator())]
SIX = [*FORCED, ("viscous", False, BY_HAND), ("coulomb", False, Operator()), ("combined", False, BY_HAND)]


@pytest.mark.parametrize(
    ("model", "forced", "operator"), with_thorough(SIX, TOO_MUCH, (True, False), (Operator(), BY_HAND))
)
def test_over_compensation_by_half_is_taken_back(model: str, forced: bool, operator: Operator) -> None:
    """No cycle ends below zero by more than the payback exchanges, and two cycles later the estimate is within 2 %."""
    window = 4 if model == "combined" else 1
    told = TOO_MUCH[model] if forced else {"factor": 1.5, "window": window}
    compensator = EnergyCompensator(model=model, **told)
    bench = replace(BENCH, joints=(ONE_BY_ONE[model],), operator=operator, duration_s=60.0)
    joint = joint_of(log_of(replace(bench, compensator=compensator if forced else None)), compensator)
    history, replayed, passivity = joint.history, joint.replayed, joint.passivity
    owed = float(np.abs(joint.without.interaction_nm * replayed.dq).max()) * compensator.payback_s
    energy = replayed.net_energy_j
    assert min(energy[-1], *energy[history.stop]) >= -owed
    assert passivity.lowest_j >= -owed
    assert passivity.violations == 0
    assert passivity.injected_j > 0.0
    acted = int(np.argmax(history.acted))
    assert history.acted[acted]
    found, truth = estimated_friction(joint), friction_of(ONE_BY_ONE[model], history)
    np.testing.assert_allclose(found[acted + 2 :], truth[acted + 2 :], rtol=0.02)
    if model != "combined":
        coulomb, viscous = history.coulomb_estimated_nm, history.viscous_estimated_nms_per_rad
        own, true = (coulomb, 0.3) if model == "coulomb" else (viscous, 0.2)
        np.testing.assert_allclose(own[acted + 1 :], true, rtol=0.02)


def test_the_reserve_of_the_first_cycle_is_said_to_hide_over_compensation() -> None:
    found = compensated(log_of(VISCOUS_BENCH), OVER)
    passivity = found.joints[0].passivity
    assert passivity.hidden
    assert passivity.active_cycles >= 1
    assert passivity.lowest_since_activation_j < -0.9 * passivity.reserve_j
    assert "over_compensation_hidden" in {caution.code for caution in found.warnings}
    quiet = compensated(log_of(VISCOUS_BENCH), EnergyCompensator(model="viscous"))
    assert quiet.warnings == ()


OVERCOME = (("viscous", 1), ("viscous", 2), ("coulomb", 1), ("coulomb", 2), ("combined", 2), ("combined", 4))
"""Model and window k; with a Panda's noise the estimate from a single cycle is up to 8 % off, step or no step."""
SEEN = [*((*one, IDEAL_SENSORS) for one in OVERCOME), *((*one, PANDA_SENSORS[0]) for one in OVERCOME if one[1] > 1)]
BOTH = (Operator(), BY_HAND)
IN_TURN = [(*one, operator) for one, operator in zip(SEEN, cycle(BOTH))]


@pytest.mark.parametrize(
    ("model", "k", "sensors", "operator"),
    [*IN_TURN, *thorough((*one, operator) for one in SEEN for operator in BOTH if (*one, operator) not in IN_TURN)],
)
def test_a_step_of_friction_is_overcome_after_a_window_and_a_cycle(
    model: str, k: int, sensors: Sensors, operator: Operator
) -> None:
    """The estimate is within 5 % of the friction at the speed of each cycle, from k + 1 cycles after the step on."""
    joint = ONE_BY_ONE[model]
    step = Hidden(friction_step=FrictionStep(change=1.0))
    stepped = replace(BENCH, joints=(joint,), sensors=(sensors,), operator=operator, hidden=(step,), duration_s=60.0)
    found = joint_of(log_of(stepped, 0), EnergyCompensator(model=model, window=k))
    history, recovery = found.history, found.recovery
    assert recovery.step_s == pytest.approx(30.0, abs=2.0)
    assert recovery.change == pytest.approx(2.0, rel=0.05)
    assert recovery.cycles <= k + 1
    right = int(np.argmax(history.stop_s > 30.0)) + k
    truth = 2.0 * friction_of(joint, history)
    np.testing.assert_allclose(estimated_friction(found)[right:], truth[right:], rtol=0.05)


def test_limits_of_an_arm_hold_and_are_reported() -> None:
    panda = log_of(BENCH)
    named = replace(panda, source=replace(panda.source, robot="panda"))
    joint = joint_of(named, energy_compensator())
    assert (joint.limits.torque_nm, joint.limits.rate_nm_s) == (87.0, 1000.0)
    found = compensated(named, energy_compensator(), max_torque_nm=0.1)
    joint = found.joints[0]
    assert joint.numbers.peak_compensation_nm == pytest.approx(0.1)
    assert joint.numbers.limited_fraction > 0.3
    (caution,) = found.warnings
    assert caution.code == "torque_limited"
    assert "at a limit (0.1 N m, 1000 N m/s) in" in sentence_of(caution)


@pytest.mark.parametrize("end_s", [5.0, 9.0])  # of the second, the last of four cycles gives the first estimate
def test_too_few_cycles_say_so(end_s: float) -> None:
    joint = joint_of(log_of(BENCH).take_window(0.0, end_s), EnergyCompensator(window=4))
    assert text_of(joint.reason).startswith("only ")
    assert joint.history is None


# Robot, compensator, and what the warning says; a healthy joint of a Panda has more friction than the last leaves.
@pytest.mark.parametrize(
    ("robot", "compensator", "message"),
    [
        ("", EnergyCompensator(), "all but vanishes within the log"),
        ("", EnergyCompensator(window=4, factor=1.2, passivity=False), "gives out energy in the later half"),
        ("", FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.07), "takes next to nothing"),
        ("panda", FixedCompensation(coulomb_nm=0.27, viscous_nms_per_rad=0.06), "--map tau_compensation"),
    ],
    ids=["learns", "over-compensates", "knows", "far below"],
)
@HOW
def test_a_compensator_that_does_its_work_is_suspected(
    robot: str, compensator: EnergyCompensator | FixedCompensation, message: str, operator: Operator
) -> None:
    bench = replace(BENCH, sensors=(PANDA_SENSORS[0],), operator=operator, duration_s=60.0)
    log = log_of(replace(bench, compensator=compensator))
    source = replace(log.source, robot=robot or log.source.robot)
    silent = replace(log, tau_compensation=None, tau_passivity=None, source=source)
    found = [sentence_of(one) for one in compensated(silent, energy_compensator()).warnings]
    assert any(message in one and "--map tau_compensation" in one for one in found), found


@HOW
def test_friction_that_changes_is_not_suspected(operator: Operator) -> None:
    step = Hidden(friction_step=FrictionStep(change=-0.5))
    bench = replace(BENCH, sensors=(PANDA_SENSORS[0],), operator=operator, hidden=(step,), duration_s=60.0)
    codes = {caution.code for caution in compensated(log_of(bench), energy_compensator()).warnings}
    assert "seems_compensated" not in codes


def test_the_hand_ends_the_cycles_as_it_did_and_the_torque_of_the_closed_loop_comes_out_again() -> None:
    compensator = EnergyCompensator(window=4)
    arm = ArmSettings(joints=(JOINT,) * 7, sensors=(IDEAL_SENSORS,) * 7, compensator=compensator, duration_s=20.0)
    simulation: Any = simulate(arm, 2)
    # The simulated controller knows no limits of a Panda.
    what = ReplaySettings(compensator=compensator, max_torque_nm=inf, max_torque_rate_nm_s=inf)
    found: Any = replay_estimate(
        estimate_log(simulation.log, AuditSettings(cycles=CycleSettings(cycles_from="hand"))), what
    )
    ticks = np.flatnonzero(np.diff(simulation.truth.compensators["cycle"][:, 0])) + 1
    assert len(ticks) > 5
    for joint in found.replay.joints:
        np.testing.assert_array_equal(joint.history.stop, ticks)
        column = simulation.log.tau_compensation[:, joint.joint - 1]
        assert np.abs(column).max() > 0.1
        np.testing.assert_allclose(joint.replayed.compensation_nm, column, atol=1e-6)


# It does not depend on the blocks in which the log is read.

AUDIT = AuditSettings(torque=TorqueSettings(torque="interaction", drive="hand"))
SETTINGS = {
    "energy": ReplaySettings(),
    "limited": ReplaySettings(compensator=energy_compensator(factor=2.0), max_torque_nm=0.3, max_torque_rate_nm_s=5.0),
    "over": ReplaySettings(compensator=energy_compensator("coulomb", factor=1.5)),
    "fixed": ReplaySettings(competitor=Competitor(name="fixed")),
    "sigmoid": ReplaySettings(competitor=Competitor(name="sigmoid")),
    "lugre": ReplaySettings(competitor=Competitor(name="lugre")),
    "diverges": ReplaySettings(
        compensator=EnergyCompensator(forced=Coefficients(coulomb_nm=2e4), forced_from_cycle=5, passivity=False)
    ),
}


def replayed(log: JointLog, name: str) -> LogReplay:
    return replay_estimate(estimate_log(log, AUDIT), SETTINGS[name])


def numbers(found: LogReplay) -> dict[str, Any]:
    """Return all that the document says of the joints and warns of, path by path."""
    document = REPLAY.of(found)
    return pinned([document["joints"], document["warnings"]], "")


@settings(max_examples=settings().max_examples // 2)  # one takes a quarter of a second
@given(
    name=st.sampled_from([*SETTINGS]),
    seed=st.integers(0, 1000),
    sizes=st.lists(st.integers(1, 4000), min_size=1, max_size=60),
    compensated=st.booleans(),
)
def test_block_borders_change_nothing(name: str, seed: int, sizes: list[int], compensated: bool) -> None:
    log = recorded(seed)
    if compensated:
        log = replace(log, tau_compensation=np.asfortranarray(0.1 * np.tanh(log.dq / 0.05)))
    borders = [border for border in np.cumsum(sizes).tolist() if border < len(log.t)]
    part, whole = replayed(in_blocks(log, borders), name), replayed(log, name)
    assert not differences({name: numbers(part)}, {name: numbers(whole)}, relative=1e-9)
    assert all(joint.replayed is None or len(joint.replayed.t) == 0 for joint in part.replay.joints)


def test_a_joint_that_moves_otherwise_takes_the_whole_log() -> None:
    log = recorded(3)
    settings = ReplaySettings(assume="same-torque")
    found = replay_estimate(estimate_log(in_blocks(log, [1000]), AUDIT), settings)
    assert not isinstance(found.estimate.log, LogInBlocks)
    assert numbers(found) == numbers(replay_estimate(estimate_log(log, AUDIT), settings))
