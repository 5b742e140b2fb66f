"""Settings assigned by name, effects hidden in joints, from the command line's words; models of joints simulated."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from friction_audit.compensation.law import Coefficients, EnergyCompensator
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel
from friction_audit.effects.registry import term_of, terms
from friction_audit.errors import UsageError
from friction_audit.joint_numbers import parse_joint_numbers, write_joint_numbers
from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.assign import Kind, PerJoint, as_nested, assign_text, assign_texts, paths, write_value
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.effects.effect import HiddenEffect
from friction_audit.simulation.effects.velocity import Stribeck
from friction_audit.simulation.hide import EQUALS, hidden_effects, hide, with_model
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.scenarios import SCENARIOS, Scenario, simulate
from friction_audit.simulation.settings import IDEAL_SENSORS, JointParameters
from tests.effects.joint_data_by_hand import typical_term

FORCED = EnergyCompensator(forced=Coefficients())
ARM, BENCH = ArmSettings(compensator=FORCED), BenchSettings()
COULOMB = tuple(joint.coulomb_nm for joint in ARM.joints)


def test_settings_are_listed_with_their_values_and_kinds() -> None:
    listed = paths(BENCH)
    motion = Kind("stop_and_go", ("sinusoid", "slow_sweep", "commanded", "prescribed"))
    assert listed["operator.motion"] == motion
    assert listed["operator.motion.stroke_s"] == (0.9, 1.8)
    assert listed["joints.coulomb_nm"] == PerJoint((0.3,))
    assert listed["duration_s"] == 120.0
    assert isinstance(listed["compensator"], Kind)
    assert not [path for path in listed if path.startswith("hidden")]


@pytest.mark.parametrize(
    ("entry", "path", "value"),
    [
        ("stiffness_n_per_m = 8e1", "hand.stiffness_n_per_m", 80.0),
        ("path.pause_s=0.1, 0.4", "hand.path.pause_s", (0.1, 0.4)),
        ("braked=1,3", "braked", (1, 3)),
        ("braked=none", "braked", ()),
        ("sines=7", "servo.motion.sines", 7),
        ("hand_cycles=false", "hand_cycles", False),
        ("model=viscous", "compensator.model", "viscous"),
        ("max_torque_nm=inf", "compensator.max_torque_nm", inf),
        ("joints.coulomb_nm=0.4", "joints.coulomb_nm", PerJoint((0.4,) * 7)),
        ("joints.coulomb_nm=0.4@1,3-7", "joints.coulomb_nm", PerJoint((0.4, COULOMB[1], *(0.4,) * 5))),
    ],
)
def test_one_value_changes_and_no_other(entry: str, path: str, value: object) -> None:
    changed = paths(assign_text(ARM, entry))
    assert changed == paths(ARM) | {path: value}
    assert type(changed[path]) is type(value)


def test_settings_that_limit_each_other_are_assigned_in_an_order_that_fits() -> None:
    usual, slow, fast = EnergyCompensator(), "termination_rad_s=0.5", "initiation_rad_s=1"
    assert assign_texts(usual, [slow, fast]) == replace(usual, termination_rad_s=0.5, initiation_rad_s=1.0)
    assert assign_texts(usual, [fast, fast]) == replace(usual, initiation_rad_s=1.0)
    for entries, message in (
        ([slow, slow], f"--set {slow}: compensator: thresholds 0.2, 0.5: expected initiation above termination"),
        ([fast, "terminaton_rad_s=0.5"], "no such setting"),
        ([fast, slow, "initiation_rad_s=2"], f"--set {fast}: is undone by another --set"),
    ):
        with pytest.raises(UsageError, match=message):
            assign_texts(usual, entries)


def test_another_kind_has_settings_of_its_own() -> None:
    sinusoid = replace(BENCH, operator=replace(BENCH.operator, motion=Sinusoid(amplitude_rad=0.7)))
    for entries in (["motion=sinusoid", "amplitude_rad=0.7"], ["amplitude_rad=0.7", "motion=sinusoid"]):
        changed = assign_texts(BENCH, entries)
        assert changed == assign_text(changed, "motion=sinusoid") == sinusoid
    assert assign_text(ARM, "compensator=none").compensator is None
    nested: dict[str, Any] = as_nested(sinusoid)
    assert nested["operator"]["motion"]["kind"] == "sinusoid"
    assert nested["compensator"] is None
    assert nested["joints"][0]["coulomb_nm"] == 0.3


@given(value=st.floats(1.0, 7000.0), joints=st.sets(st.integers(1, 40), min_size=1))
def test_what_is_written_reads_back(value: float, joints: set[int]) -> None:
    assert assign_text(BENCH, f"duration_s={write_value(value)}").duration_s == value
    assert parse_joint_numbers(write_joint_numbers(sorted(joints)), "here") == tuple(sorted(joints))
    assert write_joint_numbers((1, 3, 4, 5, 7)) == "1,3-5,7"


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda scenario: scenario.name)
def test_every_setting_of_a_scenario_can_be_assigned(scenario: Scenario) -> None:
    for path, value in paths(scenario.settings).items():
        again = scenario.settings
        for part in write_value(value).split("  ") if isinstance(value, PerJoint) else [write_value(value)]:
            again = assign_text(again, f"{path}={part}")
        assert again == scenario.settings


# Hidden effects.

SEVEN = next(scenario.settings for scenario in SCENARIOS if len(scenario.settings.moving) == 7)
ONE_OF_SEVEN = next(scenario.settings for scenario in SCENARIOS if scenario.name == "panda-joint")
EACH_EFFECT = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


@EACH_EFFECT
def test_an_effect_alone_means_its_usual_values_in_every_joint(effect: type[HiddenEffect]) -> None:
    found = hidden_effects(hide(SEVEN, [effect.name]))
    assert [(one["joint"], one["name"]) for one in found] == [(joint, effect.name) for joint in range(1, 8)]
    assert found[0]["parameters"] == {parameter.name: parameter.default for parameter in effect.parameters()}
    assert (found[0]["form"] is None) == (not effect.forms)
    assert not hidden_effects(hide(SEVEN, [f"{effect.name}:{effect.strength_name}=0"]))


def test_parameters_form_and_joints() -> None:
    hidden = hide(SEVEN, ["stribeck:excess_nm=0.2,form=lorentzian@2,5-6"])
    parameters = {"excess_nm": 0.2, "speed_rad_s": 0.1, "exponent": 2.0}
    assert [one["joint"] for one in hidden_effects(hide(ONE_OF_SEVEN, ["stribeck"]))] == [1]  # what moves
    assert hidden_effects(hidden) == [
        {"joint": joint, "name": "stribeck", "form": "lorentzian", "parameters": parameters} for joint in (2, 5, 6)
    ]
    with pytest.raises(UsageError, match="no effect without a name"):
        hide(SEVEN, [""])


# A model of joints simulated: what the model says of the simulated motion is the torque that was simulated.

SIMPLE = {"coulomb": (0.4,), "viscous": (0.1,)}
IDEAL = BenchSettings(sensors=(IDEAL_SENSORS,), duration_s=20.0)


def model_of(terms: Mapping[str, Mapping[str, float]], inertia_kg_m2: float = 0.25) -> JointModel:
    """A joint with Coulomb and viscous friction and terms by the names of their parameters; others are zero."""
    fitted = [
        FittedTerm(name, tuple(values.get(parameter.name, parameter.default) for parameter in term_of(name).parameters))
        for name, values in terms.items()
    ]
    simple = tuple(FittedTerm(name, values) for name, values in SIMPLE.items())
    return JointModel(inertia_kg_m2=inertia_kg_m2, terms=(*simple, *fitted))


def arm_of(*joints: JointModel | None) -> ArmModel:
    return ArmModel(names=tuple(f"joint{k}" for k in range(len(joints))), joints=joints)


# Formula by formula the effects are compared in ``tests/effects/test_effect_contract.py``.
STRIBECK = {"stribeck_excess_nm": 0.15, "stribeck_speed_rad_s": 0.1, "stribeck_exponent": 2.0}
STEP = {"step_coulomb_nm": 0.1, "step_viscous_nms_per_rad": 0.02, "step_time_s": 8.0, "step_length_s": 4.0}
MODELS = [
    ("offset", {"offset_nm": 0.1}),
    ("stribeck", STRIBECK),
    ("cable_spring", {"cable_stiffness_nm_per_rad": 0.4, "cable_preload_nm": 0.2, "cable_centre_rad": 0.1}),
    ("gravity_error", {"gravity_cos_nm": 0.2, "gravity_sin_nm": -0.1}),
    ("friction_step", STEP),
    ("presliding", {"bristle_nm": 0.4, "reach_rad": 0.004, "yielding_exponent": 1.0}),
    ("time_delay", {"delay_s": 0.004, "delay_step_s": 0.004}),
    ("joint_elasticity", {"compliance_rad_per_nm": 1e-3, "spring_nm_per_rad": 1000.0}),
]


@pytest.mark.parametrize(("name", "values"), MODELS, ids=lambda part: part if isinstance(part, str) else "")
def test_the_model_says_of_the_motion_the_torque_that_was_simulated(name: str, values: dict[str, float]) -> None:
    model = model_of({name: values})
    simulation = simulate(with_model(IDEAL, arm_of(model)), 3)
    log = simulation.log
    t, q, dq = log.t, log.q[:, 0], log.dq[:, 0]
    motion = Motion(t=t, q=q, dq=dq, ddq=np.gradient(dq, t))
    without = model_of({})
    # Samples with 20 ms of motion in one direction on either side.
    direction = np.sign(np.where(np.abs(dq) > 1e-3, dq, 0.0))
    read, far = log.channels()["tau_interaction"][:, 0], np.abs(np.convolve(direction, np.ones(41), "same")) == 41.0
    left = [np.sqrt(np.mean((read - one.torque(motion))[far] ** 2)) for one in (without, model)]
    assert left[1] < 0.15 * left[0]


def test_inertia_and_friction_are_taken_over_and_joints_without_a_model_stay_as_they_are() -> None:
    taken = JointParameters(inertia_kg_m2=0.25, coulomb_nm=0.4, viscous_nms_per_rad=0.1)
    assert with_model(IDEAL, arm_of(model_of({}))) == replace(IDEAL, joints=(taken,))
    arm = ArmSettings()
    settings = with_model(arm, arm_of(None, model_of({"stribeck": STRIBECK}), *(None,) * 5))
    assert settings.joints == (arm.joints[0], taken, *arm.joints[2:])
    assert settings.hidden[1].stribeck == Stribeck(excess_nm=0.15, speed_rad_s=0.1, exponent=2.0)
    assert [(effect["joint"], effect["name"]) for effect in hidden_effects(settings)] == [(2, "stribeck")]


@pytest.mark.parametrize(
    ("name", "values", "reason"),
    [
        ("torque_drift", {"drift_1_nm": 0.1}, "its own formulas differ"),
        ("torque_ripple", {"ripple_sin_nm": 0.1, "ripple_cos_nm": 0.1, "ripple_order": 20.0}, "phase of a sine or"),
        ("presliding", {"bristle_nm": 0.2, "reach_rad": 0.004, "yielding_exponent": 1.0}, "bear all of the Coulomb"),
        ("gravity_error", {"gravity_error_source": 2.0, "link_mass_kg": 1.0}, "errs in the joint's own angle"),
        ("load_dependent_friction", {"load_exponent": 1.0, "load_static": 1.0}, "not the weight alone"),
        ("backlash", {"backlash_share": 0.5, "gap_rad": 0.002, "contact_hz": 40.0}, "all inertia and friction"),
    ],
)
def test_a_term_without_an_equal_is_refused_by_name(name: str, values: dict[str, float], reason: str) -> None:
    with pytest.raises(UsageError, match=rf"the model's joint 1: {name}: the simulator has no equal of it: .*{reason}"):
        with_model(IDEAL, arm_of(model_of({name: values})))


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ((JointModel(inertia_kg_m2=-0.1),), r"joint 1: inertia_kg_m2 = -0.1: expected more than zero"),
        ((model_of({"time_delay": {"delay_s": 0.5}}),), r"joint 1: time_delay: delay_s=0\.5: expected a number"),
        ((model_of({"offset": {}, "torque_bias": {}}),), "torque_bias: another term is a torque_bias already"),
    ],
)
def test_a_model_that_cannot_be_simulated_is_refused(joints: tuple[JointModel | None, ...], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        with_model(IDEAL, arm_of(*joints))


def test_damping_is_the_same_whichever_side_is_held() -> None:
    """D = 2 r sqrt(K B) of the model, 2 r' sqrt(K B B_o / (B + B_o)) of the simulator."""
    spring = {"compliance_rad_per_nm": 1e-3, "spring_nm_per_rad": 1e3, "damping_ratio": 0.06}
    play = {"backlash_share": 1.0, "gap_rad": 0.002, "contact_hz": 40.0, "flank_damping_ratio": 0.3}
    (hidden,) = with_model(IDEAL, arm_of(model_of({"joint_elasticity": spring, "backlash": play}, 0.25))).hidden
    more = np.sqrt(1.0 + 0.25 / IDEAL.operator.inertia_kg_m2)
    assert hidden.joint_elasticity.damping_ratio == pytest.approx(0.06 * more)
    assert hidden.backlash.contact_damping_ratio == pytest.approx(0.3 * more)


def test_every_term_is_reported_or_refused() -> None:
    """No term breaks on its way to the simulator, whatever its name."""
    assert {term.name for term in terms()} - {"inertia", "coulomb", "viscous"} <= set(EQUALS)
    for term in terms():
        if term.name not in ("inertia", *SIMPLE):
            model = replace(model_of({}), terms=(*model_of({}).terms, typical_term(term)))
            try:
                settings = with_model(IDEAL, arm_of(model))
            except UsageError as error:
                assert str(error).startswith(f"the model's joint 1: {term.name}: ")  # noqa: PT017 - or it is told
            else:
                assert hidden_effects(settings)
