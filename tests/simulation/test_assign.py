"""Settings of scenarios assigned by name, and effects hidden in their joints, from the command line's words."""

from dataclasses import replace
from math import inf
from typing import Any

import pytest
from hypothesis import given, strategies as st

from friction_audit.compensation.law import Coefficients, EnergyCompensator
from friction_audit.errors import UsageError
from friction_audit.joint_numbers import parse_joint_numbers, write_joint_numbers
from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.assign import Kind, PerJoint, as_nested, assign_text, assign_texts, paths, write_value
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.effects import EFFECTS, HiddenEffect
from friction_audit.simulation.hide import HiddenInJoint, hidden_effects, hide
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.scenarios import SCENARIOS, Scenario

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


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("motion.ease_s=1@2", "is not set joint by joint; leave out @2"),
        ("hand.stifness_n_per_m=1", r"no such setting; did you mean hand\.stiffness_n_per_m"),
        ("hand.mas=1", r"did you mean hand\.mass_kg\?$"),
        ("hidden.torque_nm=1", "no such setting; --list"),
        ("duration_s", "expected NAME=VALUE"),
        ("duration_s=", "--set duration_s=: expected a number"),
        ("duration_s=inf", "expected a number"),
        ("sines=1.5", "--set servo.motion.sines=1.5: expected a whole number"),
        ("driven=yes", "expected true or false"),
        ("model=jump", "expected one of"),
        ("path.pause_s=1", "expected 2 values separated by commas, found 1"),
        ("path.pause_s=none", "expected 2 values separated by commas, found 1"),
        ("mass_kg=-1", "--set hand.mass_kg=-1: hand: mass_kg -1: expected zero or more"),
        ("joints.coulomb_nm=1@8-9", "no joint 8-9; expected joints from 1 to 7"),
        ("joints.coulomb_nm=1@", "'' is no joint"),
        ("compensator=walk", "--set compensator=walk: expected one of"),
        ("coulomb_nm=1", r"stands for 2 settings; expected one of joints\.coulomb_nm, compensator\.forced\.coulomb_nm"),
        ("compensator=joint_by_joint", "joint_by_joint has no usual values; a scenario must have it"),
    ],
)
def test_what_cannot_be_is_said(entry: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        assign_text(ARM, entry)


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

ONE = next(scenario.settings for scenario in SCENARIOS if len(scenario.settings.hidden) == 1)
SEVEN = next(scenario.settings for scenario in SCENARIOS if len(scenario.settings.moving) == 7)
ONE_OF_SEVEN = next(scenario.settings for scenario in SCENARIOS if scenario.name == "panda-joint")
EACH_EFFECT = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


@EACH_EFFECT
def test_an_effect_alone_means_its_usual_values_in_every_joint(effect: type[HiddenEffect]) -> None:
    found = hidden_effects(hide(SEVEN, [effect.name]))
    assert [(one.joint, one.name) for one in found] == [(joint, effect.name) for joint in range(1, 8)]
    assert found[0].parameters == {parameter.name: parameter.default for parameter in effect.parameters()}
    assert (found[0].form is None) == (not effect.forms)
    assert hidden_effects(hide(SEVEN, [f"{effect.name}:{effect.strength_name}=0"])) == ()


def test_parameters_form_and_joints() -> None:
    hidden = hide(SEVEN, ["stribeck:excess_nm=0.2,form=lorentzian@2,5-6"])
    parameters = {"excess_nm": 0.2, "speed_rad_s": 0.1, "exponent": 2.0}
    told = [one for one in hidden_effects(hidden) if one.name == "stribeck"]
    assert [one.joint for one in hidden_effects(hide(ONE_OF_SEVEN, ["stribeck"]))] == [1]  # what moves
    assert told == [
        HiddenInJoint(joint=joint, name="stribeck", form="lorentzian", parameters=parameters) for joint in (2, 5, 6)
    ]


@pytest.mark.parametrize(
    ("settings", "entries", "message"),
    [
        (ONE_OF_SEVEN, ["stribeck@2"], "does nothing where only joint 1 moves"),
        (ONE_OF_SEVEN, ["inertial_coupling"], "does nothing where only joint 1 moves"),
        (ONE, ["torque_crosstalk"], "takes an arm of several joints; .*panda-joint, panda, panda-driven"),
        (SEVEN, ["stribek"], r"--effect stribek: no effect stribek \(did you mean stribeck\?\)"),
        (SEVEN, ["wobble"], "no effect wobble; --list-effects"),
        (SEVEN, [""], "no effect without a name"),
        (SEVEN, ["stribeck:0.2"], "'0.2': expected NAME:PARAMETER=VALUE"),
        (SEVEN, ["stribeck:excess_nm=0.2,"], "expected NAME:PARAMETER=VALUE"),
        (SEVEN, ["stribeck:excess_nm=1,excess_nm=2"], "excess_nm is given twice"),
        (SEVEN, ["stribeck:exces_nm=1"], r"no parameter exces_nm \(did you mean excess_nm\?\); expected"),
        (SEVEN, ["stribeck:excess_nm=much"], "expected a number from"),
        (SEVEN, ["stribeck:form=square"], "expected one of exponential, lorentzian, piecewise"),
        (SEVEN, ["stribeck@8"], "no joint 8; expected joints from 1 to 7"),
        (SEVEN, ["stribeck@0"], "'0' is no joint"),
        (SEVEN, ["stribeck@1-3", "time_delay@3", "stribeck@2-3"], "stribeck@2-3: joint 2-3 has stribeck already"),
    ],
)
def test_what_cannot_be_hidden_is_said(settings: Any, entries: list[str], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        hide(settings, entries)
