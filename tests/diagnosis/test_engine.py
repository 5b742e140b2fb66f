"""The answer of the engine on joints whose motion and torque are formulas: verdicts, names, numbers, invariances."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.diagnosis.diagnose import FEWEST_CYCLES, diagnose_joint
from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import FittedTerm, simple_model
from friction_audit.effects.registry import effect_of, effects
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import quoted
from tests.diagnosis.toy_effects import BUMP, CUBE, LINE, LOCKED_OUT, SQUARE, TOYS, altered, bump, rising
from tests.each_case import thorough
from tests.effects.joint_data_by_hand import COULOMB_NM, INERTIA_KG_M2, TRUTH, VISCOUS_NMS_PER_RAD, moved_joint

Torque = Callable[[JointData], Float]
NOISE_NM = 0.02
STATED = simple_model(inertia_kg_m2=INERTIA_KG_M2, coulomb_nm=COULOMB_NM, viscous_nms_per_rad=VISCOUS_NMS_PER_RAD)
HELD = replace(STATED, held=("coulomb",))


def diagnosed(data: JointData, candidates: Sequence[Effect] | None = None, *, asked: Any = None, **known: Any) -> Any:
    subject: Any = {"data": data, "number": 3, "name": "elbow", "findings": (), "from_energy": {}} | known
    candidates = effects() if candidates is None else candidates
    return diagnose_joint(Subject(**subject), candidates, DiagnosisSettings(**asked or {}))


def names(found: Any) -> list[str]:
    return [effect.name for effect in found.effects]


def scattered(data: JointData) -> Float:
    """Coulomb friction that differs from stroke to stroke."""
    size = 0.1 * np.random.default_rng(5).standard_normal(int(data.cycle.max()) + 1)
    return np.asarray(size[data.cycle] * data.direction)


def relaxing(data: JointData) -> Float:
    """A hose whose pull relaxes within 0.4 s."""
    pole = np.exp(-data.step_s / 0.4)
    return np.asarray(0.15 * lfilter([1.0 - pole], [1.0, -pole], data.dq))


@cache
def with_stribeck() -> Any:
    return diagnosed(moved_joint(rising, noise_nm=NOISE_NM))


def test_an_adequate_model_has_no_name_and_the_right_numbers() -> None:
    found = diagnosed(moved_joint(noise_nm=NOISE_NM))
    assert (found.joint, found.name, found.verdict) == (3, "elbow", "adequate")
    assert (found.effects, found.negligible, found.checks) == ((), (), ())
    for name, truth in TRUTH.items():
        assert found.nominal[name].low <= truth <= found.nominal[name].high
    assert found.gap.before == pytest.approx(NOISE_NM, rel=0.1)
    assert found.omnibus_p == found.remaining_p > 0.05
    assert 0.05 * NOISE_NM < found.detection_limit_nm < 0.5 * NOISE_NM


def test_a_smoothed_sign_is_no_effect() -> None:
    data = moved_joint(lambda data: 0.3 * (np.tanh(data.dq / 0.004) - data.direction), noise_nm=0.01)
    assert diagnosed(data).verdict == "adequate"


def test_an_effect_is_named_with_its_numbers_and_the_gap_closes() -> None:
    found = with_stribeck()
    assert (found.verdict, names(found), found.checks) == ("named", ["stribeck"], ())
    (effect,) = found.effects
    for name in ("stribeck_excess_nm", "stribeck_speed_rad_s"):
        number = effect.parameters[name]
        assert number.low <= 0.1 <= number.high
        assert number.high - number.low < 0.1
    assert (effect.chosen_in, effect.folds, effect.grade) == (10, 10, "minor")
    torque = rising(moved_joint())
    assert 0.3 * np.sqrt(np.mean(torque**2)) < effect.size_nm < np.sqrt(np.mean(torque**2))
    assert effect.p_value < 0.01
    assert found.gap.shrink > 0.95
    assert found.omnibus_p < 0.01 < found.remaining_p
    assert found.share_explained == pytest.approx(found.gap.shrink)


def test_ladder_traces_and_gap_are_one_account() -> None:
    found = with_stribeck()
    assert [label for label, _ in found.ladder] == ["nominal model", "+ stribeck", "noise floor"]
    assert [size for _, size in found.ladder] == pytest.approx([found.gap.before, found.gap.after, found.gap.floor])
    for simulated, gap in ((found.traces.before, found.gap.before), (found.traces.after, found.gap.after)):
        assert np.sqrt(np.mean((found.traces.measured - simulated) ** 2)) == pytest.approx(gap)
    assert found.effects[0].gap_before_nm == pytest.approx(found.gap.before)
    assert found.traces.along["time"] == pytest.approx(found.traces.t)


def test_another_seed_changes_no_answer() -> None:
    first, other = with_stribeck(), diagnosed(moved_joint(rising, noise_nm=NOISE_NM), asked={"seed": 1})
    assert (other.verdict, names(other), other.ladder) == (first.verdict, names(first), first.ladder)
    assert other.effects[0].parameters == first.effects[0].parameters
    assert other.effects[0].chosen_in == first.effects[0].chosen_in


def test_an_effect_below_the_least_that_is_asked_for_is_negligible() -> None:
    found = diagnosed(moved_joint(rising, noise_nm=NOISE_NM), [effect_of("stribeck")], asked={"min_effect_nm": 0.1})
    assert (found.verdict, found.effects) == ("adequate", ())
    assert [(effect.name, effect.grade) for effect in found.negligible] == [("stribeck", "negligible")]


def test_what_changes_by_more_than_half_without_another_effect_may_be_a_part_of_it() -> None:
    def cancelling(data: JointData) -> Float:
        return np.asarray(0.5 * data.q - 0.868 * data.q**3)

    # Least squares: the line alone is 0.28 of 0.50, the cube alone 0.13 of 0.87.
    found = diagnosed(moved_joint(cancelling, noise_nm=NOISE_NM), [LINE, CUBE, SQUARE])
    assert {effect.name: effect.alternatives for effect in found.effects} == {"line": (), "cube": ("line",)}
    assert found.verdict == "ambiguous"


def test_an_offset_is_named_with_what_cannot_be_separated_from_it() -> None:
    found = diagnosed(moved_joint(lambda data: np.full(len(data.t), 0.03), noise_nm=NOISE_NM, duration_s=40.0))
    (effect,) = found.effects
    assert {"torque_bias", "asymmetric_coulomb"} <= {effect.name, *effect.alternatives}
    assert found.verdict == "ambiguous"


@pytest.mark.parametrize(
    ("hidden", "duration_s", "candidates", "held"),
    [
        (scattered, 60.0, None, ("scatter", "stroke")),
        (relaxing, 40.0, None, ("response", "past motion")),
        (bump, 60.0, [SQUARE], ("curve", "position")),
    ],
)
def test_what_no_effect_explains_is_unexplained_with_its_structure(
    hidden: Torque, duration_s: float, candidates: list[Effect] | None, held: tuple[str, str]
) -> None:
    found = diagnosed(moved_joint(hidden, noise_nm=NOISE_NM, duration_s=duration_s), candidates)
    assert found.verdict == "unexplained"
    assert held in {(check.code, check.along) for check in found.checks}
    assert held[0] != "curve" or found.profiles[0].axis == held[1]


def test_a_small_ripple_is_no_error_of_a_large_gravity_torque() -> None:
    def torque(data: JointData) -> Float:
        return 5.0 * np.cos(data.q) + 0.1 * np.sin(20.0 * data.q)

    data = moved_joint(torque, noise_nm=NOISE_NM, duration_s=40.0)
    assert {"gravity_error", "torque_ripple"} <= set(names(diagnosed(data)))


def test_an_effect_that_holds_in_one_direction_only_changes_between_them() -> None:
    found = diagnosed(moved_joint(lambda data: bump(data) * (1.0 + 0.9 * np.sign(data.dq)), noise_nm=NOISE_NM), [BUMP])
    assert names(found) == ["bump"]
    assert ("change", "bump") in {(check.code, check.along) for check in found.checks}


def waves(data: JointData) -> Float:
    return np.column_stack([np.sin((k // 2 + 1) * data.q * 2.0 + np.pi / 2 * (k % 2)) for k in range(16)])


@pytest.mark.parametrize(("duration_s", "named"), [(16.0, []), (60.0, ["waves"])])
def test_as_many_numbers_as_cycles_are_no_explanation(duration_s: float, named: list[str]) -> None:
    many = altered(SQUARE, name="waves", regressor=lambda data, _nominal, _at: waves(data), units=("nm",) * 16)
    hidden = np.resize([0.1, -0.07, 0.05], 16)
    data = moved_joint(lambda one: np.asarray(waves(one) @ hidden), noise_nm=NOISE_NM, duration_s=duration_s)
    assert names(diagnosed(data, [many])) == named


def test_a_log_that_shows_none_of_the_effects_asked_for_is_not_testable() -> None:
    found = diagnosed(moved_joint(bump, noise_nm=NOISE_NM), [LOCKED_OUT])
    assert (found.verdict, found.reason) == ("not_testable", quoted("move the moon"))
    assert diagnosed(moved_joint(noise_nm=NOISE_NM), TOYS).untestable == {"locked_out": found.reason[0]}


@pytest.mark.parametrize("lacking", ["", "moved too slowly; move it faster"])
def test_few_cycles_are_not_testable(lacking: str) -> None:
    found = diagnosed(moved_joint(duration_s=4.0), TOYS, lacking=quoted(lacking))
    assert found.verdict == "not_testable"
    assert found.reason[0].numbers == {"cycles": 3, "fewest": FEWEST_CYCLES, "lacking": quoted(lacking)}
    assert (found.nominal, found.traces, found.gap) == ({}, None, None)


def test_a_fault_of_the_data_comes_before_every_name() -> None:
    fault = DataFinding(code="dq_scale", value=0.2, unit="", bound=0.05, verdict="fault")
    limit = DataFinding(code="holes", value=1, unit="", bound=0, verdict="limit")
    found = diagnosed(moved_joint(bump), TOYS, findings=(limit, fault))
    assert (found.verdict, found.reason, found.effects) == ("data_fault", (fault,), ())
    assert found.findings == (limit, fault)


def late(late_s: float, sample_s: float) -> Any:
    """A joint whose torque comes late by so much, in a log of samples of so long."""
    exact, noisy = moved_joint(), moved_joint(noise_nm=0.002)
    shift = np.interp(exact.t - late_s, exact.t, exact.torque) - exact.torque
    return diagnosed(replace(noisy, torque=noisy.torque + shift, sample_s=sample_s), [effect_of("time_delay")])


@pytest.mark.parametrize("late_s", [4e-4, *thorough([-4e-4])])
def test_a_recorder_that_is_late_by_less_than_half_a_sample_is_no_effect(late_s: float) -> None:
    found = late(late_s, 1e-3)
    assert (found.verdict, found.effects, found.negligible) == ("adequate", (), ())
    assert [effect.name for effect in late(abs(late_s), 0.0).negligible] == ["time_delay"]


def test_a_delay_of_two_samples_is_named_and_has_one_number() -> None:
    (effect,) = late(2e-3, 1e-3).effects
    delay = effect.parameters["delay_s"]
    assert delay.low < 2e-3 < delay.high < delay.low + 1e-3
    assert (effect.name, effect.not_identifiable) == ("time_delay", ())


def test_a_model_file_that_holds_the_effect_leaves_nothing() -> None:
    model = replace(STATED, terms=(*STATED.terms, FittedTerm("stribeck", (0.3, 0.1, 2.0))))
    found = diagnosed(moved_joint(rising, noise_nm=NOISE_NM), model=model)
    assert (found.verdict, found.effects) == ("adequate", ())
    assert found.nominal["stribeck_excess_nm"].value == pytest.approx(0.1, abs=0.01)
    assert "inertia_kg_m2" not in found.nominal


def test_an_inertia_that_a_model_file_states_wrongly_is_an_effect() -> None:
    found = diagnosed(moved_joint(noise_nm=NOISE_NM, duration_s=40.0), model=replace(STATED, inertia_kg_m2=0.25))
    assert names(found) == ["inertia_error"]
    assert found.effects[0].parameters["extra_inertia_kg_m2"].value == pytest.approx(-0.05, rel=0.05)


SHARE, WIDTH_RAD_S = 0.6, 0.2


def helped(data: JointData) -> Float:
    """What a compensator of a share of both frictions takes off, smooth below a speed."""
    return -SHARE * (COULOMB_NM * np.tanh(data.dq / WIDTH_RAD_S) + VISCOUS_NMS_PER_RAD * data.dq)


COMPENSATED = (effect_of("stribeck"), effect_of("unlogged_compensation"))


def test_a_compensator_that_the_log_lacks_is_named_where_coulomb_friction_is_held() -> None:
    found = diagnosed(moved_joint(helped, noise_nm=NOISE_NM), COMPENSATED, model=HELD)
    assert (found.verdict, names(found)) == ("named", ["unlogged_compensation"])
    numbers = found.effects[0].parameters
    assert numbers["unlogged_nm"].value == pytest.approx(SHARE * COULOMB_NM, rel=0.05)
    assert numbers["unlogged_width_rad_s"].value == pytest.approx(WIDTH_RAD_S, rel=0.1)
    assert found.augmented["viscous_nms_per_rad"].value == pytest.approx((1.0 - SHARE) * VISCOUS_NMS_PER_RAD, abs=0.005)
    assert diagnosed(moved_joint(noise_nm=NOISE_NM), COMPENSATED, model=HELD).verdict == "adequate"


def test_the_edge_of_a_dead_band_is_found_between_the_points_of_the_grid() -> None:
    def torque(data: JointData) -> Float:
        return np.asarray(-SHARE * COULOMB_NM * data.direction * (np.abs(data.dq) > 0.17))

    (effect,) = diagnosed(moved_joint(torque, noise_nm=NOISE_NM), COMPENSATED, model=HELD).effects
    assert effect.parameters["unlogged_form"].value == 1.0
    assert effect.parameters["unlogged_width_rad_s"].value == pytest.approx(0.17, rel=0.02)


def test_a_step_of_friction_is_found_at_its_moment() -> None:
    data = moved_joint(lambda one: 0.1 * one.direction * (one.t >= 31.3), noise_nm=NOISE_NM)
    (effect,) = diagnosed(data, [effect_of("friction_step")]).effects
    assert effect.parameters["step_time_s"].value == pytest.approx(31.3, abs=0.05)
    assert effect.parameters["step_coulomb_nm"].value == pytest.approx(0.1, rel=0.1)


def test_a_transmission_that_has_no_torque_in_the_joint_fit_is_no_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    """As backlash where the inertia of the nominal model becomes zero."""

    def emptied(_dictionary: Any, _training: Any, block: Block, *_: Any) -> Block:
        return block.moved(block.shape, np.zeros(block.columns.shape))

    monkeypatch.setattr("friction_audit.diagnosis.procedure.refine", emptied)
    found = diagnosed(moved_joint(rising, noise_nm=NOISE_NM), [altered(SQUARE, follows=True)])
    assert (names(found), found.negligible) == ([], ())
