"""The verdict of one joint, on motions by hand and toy candidates."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.library import build_library
from friction_audit.diagnosis.naming import search_library

from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.diagnosis.diagnose_joint import FEWEST_CYCLES, Subject, diagnose_joint
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import INERTIA_KG_M2, TRUTH, moved_joint
from tests.diagnosis.toy_candidates import BUMP, LOCKED_OUT, SQUARE, STEP, TOYS, altered

NOISE_NM = 0.02
ENERGY = {
    "coulomb_nm": Coefficient(value=0.6, low=0.5, high=0.7),
    "viscous_nms_per_rad": Coefficient(value=0.07, low=0.0, high=0.1),
}


def bump(data: JointData) -> Float:
    return 0.1 * np.exp(-(((data.q - 0.2) / 0.2) ** 2))


def subject(missing: Callable[[JointData], Float] | None = None, *, duration_s: float = 60.0) -> Subject:
    data = moved_joint(missing, noise_nm=NOISE_NM, duration_s=duration_s)
    return Subject(data=data, number=3, name="elbow", findings=(), from_energy=ENERGY)


@cache
def humped() -> JointDiagnosis:
    return diagnose_joint(subject(bump), TOYS, DiagnosisSettings())


def test_nothing_hidden_is_none_with_the_size_that_would_have_been_seen() -> None:
    found = diagnose_joint(subject(), TOYS, DiagnosisSettings())
    assert (found.joint, found.name, found.verdict, found.effects) == (3, "elbow", "adequate", ())
    assert found.omnibus_p == found.remaining_p > 0.05
    assert 0.05 * NOISE_NM < found.detection_limit_nm < 0.5 * NOISE_NM
    assert {name: one.value for name, one in found.nominal.items()} == pytest.approx(TRUTH, rel=0.05)
    assert found.untestable == {"locked_out": "move the moon"}


def test_an_effect_is_named_and_the_gap_closes_to_the_floor() -> None:
    found = humped()
    assert found.verdict == "named"
    assert [effect.name for effect in found.effects] == ["bump"]
    assert found.effects[0].parameters["place_rad"].value == pytest.approx(0.2, abs=0.02)
    assert found.gap is not None
    assert found.gap.shrink > 0.95
    assert found.gap.after == pytest.approx(NOISE_NM, rel=0.1)
    assert found.omnibus_p < 0.01 < found.remaining_p
    assert found.profiles[0].axis == "position"
    assert found.vibration is None


def test_the_ladder_leads_from_the_declared_model_to_the_floor() -> None:
    found = humped()
    assert found.gap is not None
    assert [label for label, _ in found.ladder] == ["declared model", "+ bump", "floor of the noise"]
    assert [size for _, size in found.ladder] == pytest.approx([found.gap.before, found.gap.after, found.gap.floor])


def test_traces_hold_measured_and_simulated_torque() -> None:
    found = humped()
    traces = found.traces
    assert traces is not None
    assert found.gap is not None
    for simulated, gap in ((traces.before, found.gap.before), (traces.after, found.gap.after)):
        left = (traces.measured - simulated)[traces.held_out]
        assert np.sqrt(np.mean(left**2)) == pytest.approx(gap)
    assert traces.along["time"] == pytest.approx(traces.t)


def test_energy_that_disagrees_is_told() -> None:
    (said,) = humped().disagreements
    assert said.startswith("Coulomb friction 0.6 N m from energy, ")


def test_what_nobody_can_name_is_unexplained_with_its_place() -> None:
    found = diagnose_joint(subject(bump), [SQUARE], DiagnosisSettings())
    assert found.verdict == "unexplained"
    assert "nothing in the catalogue explains" in found.message
    assert " rad, " in found.message


def test_what_comes_late_is_taken_by_what_the_rows_are_worth_and_noise_is_not() -> None:
    late = subject(lambda data: 0.08 * np.sign(data.dq) * (data.t >= 54.0))
    taken = []
    for data in (late.data, subject().data):
        ground = make_ground(data, None, 0)
        library = build_library([STEP, SQUARE], data, ground.baseline(), ground.rows)
        taken.append(bool(search_library(ground, library)[1].chosen))
    assert taken == [True, False]


def test_a_name_with_a_twin_is_ambiguous() -> None:
    twins = [
        altered(BUMP, name="torque_bias", indistinguishable=("gravity_error",)),
        altered(SQUARE, name="gravity_error"),
    ]
    found = diagnose_joint(subject(bump), twins, DiagnosisSettings())
    assert found.verdict == "ambiguous"
    assert found.effects[0].alternatives == ("gravity_error",)
    assert found.effects[0].decide
    assert "torque_bias cannot be separated from gravity_error in this log" in found.message


def test_a_log_that_shows_none_of_the_effects_asked_for_is_not_testable() -> None:
    found = diagnose_joint(subject(bump), [LOCKED_OUT], DiagnosisSettings())
    assert (found.verdict, found.message) == ("not_testable", "move the moon")


def test_few_cycles_are_not_testable() -> None:
    found = diagnose_joint(subject(bump, duration_s=4.0), TOYS, DiagnosisSettings())
    assert found.verdict == "not_testable"
    assert f"at least {FEWEST_CYCLES} are needed: move the joint back and forth" in found.message
    assert "--thresholds auto" in found.message
    assert (found.nominal, found.traces, found.gap) == ({}, None, None)
    assert found.from_energy is ENERGY


def test_what_the_energy_method_lacks_is_what_a_diagnosis_lacks() -> None:
    slow = replace(subject(bump, duration_s=4.0), lacking="moved too slowly; move it faster")
    found = diagnose_joint(slow, TOYS, DiagnosisSettings())
    assert found.message.endswith(f"at least {FEWEST_CYCLES} are needed: moved too slowly; move it faster")


def test_a_fault_of_the_data_comes_before_every_name() -> None:
    finding = DataFinding(
        code="dq_scale", value=0.2, unit="", bound=0.05, verdict="fault", message="dq is 20% too large"
    )
    limit = DataFinding(code="holes", value=1, unit="", bound=0, verdict="limit", message="a hole")
    spoilt = replace(subject(bump), findings=(limit, finding))
    found = diagnose_joint(spoilt, TOYS, DiagnosisSettings())
    assert (found.verdict, found.message, found.effects) == ("data_fault", "dq is 20% too large", ())
    assert found.findings == (limit, finding)


def test_a_stated_model_that_holds_the_effect_leaves_nothing() -> None:
    wave = FittedTerm("torque_bias", (0.1,))
    terms = (FittedTerm("coulomb", (0.3,)), FittedTerm("viscous", (0.07,)), wave)
    model = JointModel(inertia_kg_m2=INERTIA_KG_M2, terms=terms)
    offset = subject(lambda data: np.full(len(data.t), 0.1))
    found = diagnose_joint(replace(offset, model=model), TOYS, DiagnosisSettings())
    assert found.verdict == "adequate"
    assert "inertia_kg_m2" not in found.nominal
    assert found.nominal["torque_bias_nm"].value == pytest.approx(0.1, rel=0.1)


def test_the_same_seed_gives_the_same_answer() -> None:
    first, again = (diagnose_joint(subject(), [SQUARE], DiagnosisSettings(seed=4)) for _ in range(2))
    assert again.omnibus_p == first.omnibus_p
    assert again.ladder == first.ladder


def waves(data: JointData) -> Float:
    return np.column_stack([np.sin((k // 2 + 1) * data.q * 2.0 + np.pi / 2 * (k % 2)) for k in range(16)])


@pytest.mark.parametrize(("duration_s", "verdict"), [(16.0, "unexplained"), (60.0, "named")])
def test_as_many_numbers_as_cycles_are_no_explanation(duration_s: float, verdict: str) -> None:
    toy = altered(SQUARE, name="waves", regressor=lambda data, _baseline, _shape: waves(data), units=("nm",) * 16)
    one = subject(lambda data: np.asarray(waves(data) @ np.resize([0.1, -0.07, 0.05], 16)), duration_s=duration_s)
    found = diagnose_joint(one, (toy,), DiagnosisSettings())
    assert [effect.name for effect in found.effects] == ["waves"]
    assert found.verdict == verdict
    assert ("16 numbers were fitted to" in found.message) == (verdict == "unexplained")


def test_what_is_larger_on_one_side_is_not_what_it_was_taken_for() -> None:
    """A bump that only resists the motion up is half of what its name says."""
    found = diagnose_joint(
        subject(lambda data: bump(data) * (1.0 + 0.9 * np.sign(data.dq))), (BUMP,), DiagnosisSettings()
    )
    assert [effect.name for effect in found.effects] == ["bump"]
    assert found.verdict == "unexplained"
    assert "bump is larger forwards than backwards" in found.message


@pytest.mark.parametrize(("also", "names"), [(0.0, ["square"]), (0.3, ["square", "bump"])])
def test_what_stood_in_for_the_truth_and_does_not_hold_is_left_out_of_another_search(
    also: float, names: list[str]
) -> None:
    """A stand-in that fits the working cycles as well as all that is there, and turns round in the locked ones."""

    def missing(data: JointData) -> Float:
        return np.asarray(0.05 * data.dq * np.abs(data.dq) + also * bump(data))

    joint = subject(missing)
    ground = make_ground(joint.data, None, 0)
    locked = np.unique(ground.rows.cycle[ground.locked])

    def turned(data: JointData, _baseline: Nominal, _shape: Nonlinear) -> Float:
        return np.asarray(missing(data) * np.where(np.isin(data.cycle, locked), -1.0, 1.0))[:, None]

    stand_in = altered(STEP, name="stand_in", grid=({},), regressor=turned, moment="")
    found = diagnose_joint(joint, (*TOYS, stand_in), DiagnosisSettings())
    assert [effect.name for effect in found.effects] == names
    assert found.verdict == "named"
