"""Effects hidden in the joints of a scenario, from the command line's words."""

import pytest

from friction_audit.errors import UsageError
from friction_audit.simulation.assign import as_nested
from friction_audit.simulation.effects import EFFECTS, HiddenEffect
from friction_audit.simulation.effects.velocity import Stribeck
from friction_audit.simulation.hide import HiddenInJoint, hidden_effects, hide
from friction_audit.simulation.scenarios import SCENARIOS

ONE = next(scenario.settings for scenario in SCENARIOS if len(scenario.settings.hidden) == 1)
SEVEN = next(scenario.settings for scenario in SCENARIOS if len(scenario.settings.moving) == 7)
ONE_OF_SEVEN = next(scenario.settings for scenario in SCENARIOS if scenario.name == "panda-joint")
EACH_EFFECT = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


@EACH_EFFECT
def test_an_effect_alone_means_its_usual_values_in_every_joint(
    effect: type[HiddenEffect],
) -> None:
    found = hidden_effects(hide(SEVEN, [effect.name]))
    assert [(one.joint, one.name) for one in found] == [(joint, effect.name) for joint in range(1, 8)]
    assert found[0].parameters == {parameter.name: parameter.default for parameter in effect.parameters()}
    assert (found[0].form is None) == (not effect.forms)
    assert hidden_effects(hide(SEVEN, [f"{effect.name}:{effect.strength_name()}=0"])) == ()


def test_parameters_form_and_joints() -> None:
    hidden = hide(SEVEN, ["stribeck:excess_nm=0.2,form=lorentzian@2,5-6"])
    parameters = {"excess_nm": 0.2, "speed_rad_s": 0.1, "exponent": 2.0}
    told = [one for one in hidden_effects(hidden) if one.name == "stribeck"]
    assert told == [
        HiddenInJoint(joint=joint, name="stribeck", form="lorentzian", parameters=parameters) for joint in (2, 5, 6)
    ]


def test_without_joints_an_effect_goes_where_there_is_motion() -> None:
    assert [one.joint for one in hidden_effects(hide(ONE_OF_SEVEN, ["stribeck"]))] == [1]


@pytest.mark.parametrize("entry", ["stribeck@2", "inertial_coupling"])
def test_what_a_joint_at_rest_cannot_show_is_refused(entry: str) -> None:
    with pytest.raises(UsageError, match="does nothing where only joint 1 moves"):
        hide(ONE_OF_SEVEN, [entry])


def test_nothing_else_changes() -> None:
    assert hide(ONE, []) == ONE
    hidden = hide(ONE, ["stribeck"])
    assert as_nested(hidden) == as_nested(ONE)
    assert "hidden" not in as_nested(hidden)
    assert hidden.hidden[0].stribeck == Stribeck(excess_nm=0.15)


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        (["stribek"], "--effect stribek: no effect stribek; did you mean stribeck"),
        (["wobble"], "no effect wobble; --list-effects"),
        ([""], "no effect without a name"),
        (["stribeck:"], "expected NAME:PARAMETER=VALUE"),
        (["stribeck:0.2"], "'0.2': expected NAME:PARAMETER=VALUE"),
        (["stribeck:excess_nm=0.2,"], "expected NAME:PARAMETER=VALUE"),
        (["stribeck:excess_nm=1,excess_nm=2"], "excess_nm is given twice"),
        (["stribeck:exces_nm=1"], r"no parameter exces_nm \(did you mean excess_nm\?\); expected"),
        (["stribeck:excess_nm=much"], "expected a number from"),
        (["stribeck:form=square"], "expected one of exponential, lorentzian, piecewise"),
        (["stribeck@8"], "no joint 8; expected joints from 1 to 7"),
        (["stribeck@0"], "'0' is no joint"),
        (["stribeck@1-3", "time_delay@3", "stribeck@2-3"], "stribeck@2-3: joint 2-3 has stribeck already"),
    ],
)
def test_what_cannot_be_is_said(entries: list[str], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        hide(SEVEN, entries)


def test_an_effect_between_joints_takes_several() -> None:
    (first, *_) = [effect.name for effect in EFFECTS if effect.needs_neighbours]
    several = [scenario.name for scenario in SCENARIOS if len(scenario.settings.hidden) > 1]
    with pytest.raises(UsageError, match=f"takes an arm of several joints; .*{', '.join(several)}"):
        hide(ONE, [first])
