"""What people are told, word by word, and the sizes of effects."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.alternatives import Naming, Rival
from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.library import build_library
from friction_audit.diagnosis.naming import Found, Names
from friction_audit.diagnosis.parameters import parameters_of
from friction_audit.diagnosis.result import Effect, Profile, Vibration
from friction_audit.diagnosis.tell import effects_of, message_of, vibration_of
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.toy_candidates import BUMP, SQUARE, TOYS

SHAKING = Vibration(frequency_hz=13.04, low_hz=12.0, high_hz=14.5, rms_nm=0.0312)
NONE = np.zeros(0)


def place(where: str) -> Profile:
    return Profile(
        axis="speed",
        label="speed [rad/s]",
        edges=NONE,
        centre=NONE,
        forwards=NONE,
        backwards=NONE,
        forwards_se=NONE,
        backwards_se=NONE,
        share=0.0,
        p_value=0.5,
        where=where,
    )


def effect(name: str, alternatives: tuple[str, ...] = ()) -> Effect:
    return Effect(
        name=name,
        label=f"the {name}",
        alternatives=alternatives,
        decide="",
        parameters={},
        p_value=0.01,
        where="below 0.1 rad/s",
        axis="speed",
        gap_before_nm=0.1,
        gap_after_nm=0.05,
        partial_nm=0.08,
        torque=NONE,
        curve=place(""),
        evidence=(),
    )


def told(
    verdict: str,
    *effects: Effect,
    remaining: tuple[Profile, ...] = (),
    also: tuple[str, ...] = (),
    significant: bool = False,
) -> str:
    untestable = {"a": "move faster", "b": "move faster", "c": "rest more"}
    return message_of(verdict, effects, remaining, also, 0.00478, significant, untestable)  # type: ignore[arg-type]


def test_the_message_of_each_verdict() -> None:
    assert told("adequate") == "nothing is missing: an effect of 0.0048 N m rms is detectable"
    assert told("not_testable") == "move faster; rest more"
    assert told("named", effect("x"), effect("y")) == "x (the x) and y (the y): below 0.1 rad/s"
    assert told("ambiguous", effect("x", ("p", "q")), effect("y")) == (
        "x (the x) and y (the y): x cannot be separated from p, q in this log"
    )


def test_two_that_may_be_it_only_together_are_told_so() -> None:
    both = replace(effect("x", ("p", "q", "r")), together=(("q", "r"),))
    assert told("ambiguous", both) == "x (the x): x cannot be separated from p, q with r in this log"


def test_what_nothing_explains_is_told_with_its_place() -> None:
    lost = "is missing that nothing in the catalogue explains: "
    assert told("unexplained") == f"something {lost}spread over the whole motion"
    somewhere = told(
        "unexplained", effect("x"), remaining=(place(""), place("above 2 s")), also=(vibration_of(SHAKING),)
    )
    assert somewhere == f"in addition to x (the x) something {lost}above 2 s; {vibration_of(SHAKING)}"


def test_a_vibration_by_its_frequency() -> None:
    assert vibration_of(SHAKING) == "a vibration at 13 Hz (12 to 14.5 Hz), 0.031 N m rms"


def missing(bump: float, square: float) -> tuple[Effect, ...]:
    """A bump and a square as found, the bump first, sizes as given."""
    data = moved_joint(
        lambda data: bump * np.exp(-(((data.q - 0.3) / 0.2) ** 2)) + square * data.dq * np.abs(data.dq), noise_nm=0.01
    )
    ground = make_ground(data, None, 0)
    baseline = ground.baseline()
    rivals = tuple(Rival(name=f"r{k}", shape=0, unit=k, delta_bic=50.0 - k, correlation=0.1) for k in range(8))
    found = tuple(
        Found(
            candidate=candidate,
            shape=shape,
            columns=ground.rows.of(candidate.regressor(data, baseline, shape)),
            naming=Naming(name=candidate.name, rivals=rivals, alternatives=()),
            p_value=0.01,
        )
        for candidate, shape in ((BUMP, {"place_rad": 0.3, "width_rad": 0.2}), (SQUARE, {}))
    )
    names = Names(found=found, library=build_library(TOYS, data, baseline, ground.rows), baseline=baseline)
    return effects_of(ground, names, ground.curves, parameters_of(ground, found, baseline))


def rms(torque: Float) -> float:
    return float(np.sqrt(np.mean(torque**2)))


def test_effects_have_sizes_and_their_own_curve() -> None:
    hump, square = missing(0.2, 0.03)
    assert (hump.name, square.name) == ("bump", "square")
    assert hump.gap_before_nm > hump.gap_after_nm == square.gap_before_nm > square.gap_after_nm
    assert square.gap_after_nm == pytest.approx(0.01, rel=0.1)
    assert hump.torque.max() == pytest.approx(0.2, rel=0.05)
    for one in (hump, square):
        assert 0 < one.partial_nm < rms(one.torque)
    assert (hump.curve.axis, square.curve.axis) == ("position", "speed")
    highest = hump.curve.centre[int(np.nanargmax(hump.curve.forwards))]
    assert highest == pytest.approx(0.3, abs=0.1)


def test_evidence_is_the_effect_and_its_six_best_rivals() -> None:
    hump, _ = missing(0.2, 0.03)
    assert [one.name for one in hump.evidence] == ["bump", "r7", "r6", "r5", "r4", "r3", "r2"]
    assert hump.evidence[0].delta_bic == 0.0


def test_a_rest_that_is_no_noise_and_too_small_for_a_name_is_told() -> None:
    assert told("adequate").startswith("nothing is missing")
    assert told("adequate", significant=True).startswith("nothing large enough for a name is missing")
