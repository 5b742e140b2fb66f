"""Settings assigned by name, on a small tree made for it."""

from dataclasses import dataclass
from math import inf
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.errors import UsageError
from friction_audit.simulation.assign import (
    Kind,
    PerJoint,
    as_nested,
    assign_text,
    assign_texts,
    paths,
    write_value,
)
from friction_audit.simulation.scenarios import SCENARIOS, Scenario

EACH_SCENARIO = pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda scenario: scenario.name)


@dataclass(frozen=True)
class Joint:
    coulomb_nm: float = 0.3
    viscous_nms_per_rad: float = 0.07


@dataclass(frozen=True)
class Hand:
    stiffness_nm_per_rad: float = 60.0
    pause_s: tuple[float, float] = (0.2, 0.7)
    pose_rad: tuple[float, ...] = (0.0, 0.5, 1.0)
    strokes: int = 4
    quiet: bool = False
    motion: Literal["sine", "strokes"] = "sine"
    label: str = "hand"

    def __post_init__(self) -> None:
        if not self.stiffness_nm_per_rad > 0:
            raise UsageError(f"hand: stiffness_nm_per_rad {self.stiffness_nm_per_rad:g}: expected more than zero")


@dataclass(frozen=True)
class SlowSweep:
    speed_rad_s: float = 0.1


@dataclass(frozen=True)
class Sine:
    amplitude_rad: float = 0.5


@dataclass(frozen=True)
class Strokes:
    count: int


@dataclass(frozen=True)
class Compensator:
    coulomb_nm: float = 0.2
    limit_nm: float | None = None
    longest_s: float = inf


@dataclass(frozen=True)
class Range:
    low_rad: float = 0.0
    high_rad: float = 1.0

    def __post_init__(self) -> None:
        if not self.low_rad < self.high_rad:
            raise UsageError(f"range: {self.low_rad:g}, {self.high_rad:g}: expected the smaller number first")


@dataclass(frozen=True)
class Tree:
    joints: tuple[Joint, ...] = (Joint(), Joint(), Joint())
    hidden: tuple[Joint, ...] = (Joint(), Joint(), Joint())
    hand: Hand = Hand()
    compensator: Compensator | None = Compensator()
    path: SlowSweep | Sine | Strokes = SlowSweep()
    table: tuple[tuple[float, float], ...] = ((0.0, 1.0),)
    duration_s: float = 60.0


TREE = Tree()


def test_every_setting_is_listed_with_its_value() -> None:
    assert paths(TREE) == {
        "joints.coulomb_nm": PerJoint((0.3, 0.3, 0.3)),
        "joints.viscous_nms_per_rad": PerJoint((0.07, 0.07, 0.07)),
        "hand.stiffness_nm_per_rad": 60.0,
        "hand.pause_s": (0.2, 0.7),
        "hand.pose_rad": (0.0, 0.5, 1.0),
        "hand.strokes": 4,
        "hand.quiet": False,
        "hand.motion": "sine",
        "hand.label": "hand",
        "compensator": Kind("compensator", ("none",)),
        "compensator.coulomb_nm": 0.2,
        "compensator.limit_nm": None,
        "compensator.longest_s": inf,
        "path": Kind("slow_sweep", ("sine",)),
        "path.speed_rad_s": 0.1,
        "duration_s": 60.0,
    }


@pytest.mark.parametrize(
    ("entry", "path", "value"),
    [
        ("hand.stiffness_nm_per_rad=80", "hand.stiffness_nm_per_rad", 80.0),
        ("stiffness_nm_per_rad = 8e1", "hand.stiffness_nm_per_rad", 80.0),
        ("duration_s=5", "duration_s", 5.0),
        ("pause_s=0.1, 0.4", "hand.pause_s", (0.1, 0.4)),
        ("pose_rad=1,2", "hand.pose_rad", (1.0, 2.0)),
        ("pose_rad=none", "hand.pose_rad", ()),
        ("strokes=7", "hand.strokes", 7),
        ("quiet=true", "hand.quiet", True),
        ("motion=strokes", "hand.motion", "strokes"),
        ("label=a=b", "hand.label", "a=b"),
        ("limit_nm=0.5", "compensator.limit_nm", 0.5),
        ("limit_nm=none", "compensator.limit_nm", None),
        ("longest_s=inf", "compensator.longest_s", inf),
        ("longest_s=3", "compensator.longest_s", 3.0),
        ("joints.coulomb_nm=0.4", "joints.coulomb_nm", PerJoint((0.4, 0.4, 0.4))),
        ("joints.coulomb_nm=0.4@1,3", "joints.coulomb_nm", PerJoint((0.4, 0.3, 0.4))),
        ("viscous_nms_per_rad=0@2-3", "joints.viscous_nms_per_rad", PerJoint((0.07, 0.0, 0.0))),
    ],
)
def test_one_value_changes_and_no_other(entry: str, path: str, value: object) -> None:
    changed = assign_text(TREE, entry)
    assert paths(changed) == paths(TREE) | {path: value}
    assert type(paths(changed)[path]) is type(value)
    assert paths(TREE) == paths(Tree())


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("coulomb_nm=1", "stands for 2 settings; expected one of joints.coulomb_nm, compensator.coulomb_nm"),
        ("hand.stifness_nm_per_rad=1", r"no such setting; did you mean hand\.stiffness_nm_per_rad"),
        ("hand.stifness=1", r"did you mean hand\.stiffness_nm_per_rad\?$"),
        ("pauze_s=1", r"did you mean hand\.pause_s\?$"),
        ("viscous_nms=1", r"no such setting; did you mean joints\.viscous_nms_per_rad"),
        ("colour=1", "no such setting; --list"),
        ("hidden.coulomb_nm=1", "no such setting"),
        ("table=1", "no such setting"),
        ("duration_s", "expected NAME=VALUE"),
        ("=3", "expected NAME=VALUE"),
        ("duration_s=", "--set duration_s=: expected a number"),
        ("duration_s=nan", "expected a number"),
        ("duration_s=inf", "expected a number"),
        ("strokes=1.5", "--set hand.strokes=1.5: expected a whole number"),
        ("quiet=yes", "expected true or false"),
        ("motion=jump", "expected one of sine, strokes"),
        ("pause_s=1", "expected 2 values separated by commas, found 1"),
        ("pause_s=none", "expected 2 values separated by commas, found 1"),
        ("pause_s=1,x", "expected a number"),
        ("stiffness_nm_per_rad=-1", "--set hand.stiffness_nm_per_rad=-1: hand: .* expected more than zero"),
        ("joints.coulomb_nm=1@4", "no joint 4; expected joints from 1 to 3"),
        ("joints.coulomb_nm=1@x", "'x' is no joint"),
        ("path=walk", "--set path=walk: expected one of slow_sweep, sine, strokes"),
        ("path=strokes", "strokes has no usual values"),
        ("path.amplitude_rad=1", "no such setting"),
        ("duration_s=1@2", "is not set joint by joint; leave out @2"),
    ],
)
def test_what_cannot_be_is_said(entry: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        assign_text(TREE, entry)


def test_settings_that_limit_each_other_are_assigned_in_an_order_that_fits() -> None:
    assert assign_texts(Range(), ["low_rad=4", "high_rad=5"]) == Range(4.0, 5.0)
    assert assign_texts(Range(), []) == Range()
    with pytest.raises(UsageError, match="--set low_rad=4: range: 4, 1: expected the smaller number first"):
        assign_texts(Range(), ["low_rad=4", "low_rad=4"])
    with pytest.raises(UsageError, match="no such setting"):
        assign_texts(Range(), ["high_rad=5", "lou_rad=4"])


def test_entries_that_contradict_each_other_are_refused() -> None:
    assert assign_texts(Range(), ["high_rad=5", "high_rad=5"]) == Range(0.0, 5.0)
    with pytest.raises(UsageError, match="--set high_rad=5: is undone by another --set"):
        assign_texts(Range(), ["high_rad=5", "low_rad=4", "high_rad=6"])
    with pytest.raises(UsageError, match=r"--set path.speed_rad_s: no such setting"):
        assign_texts(TREE, ["path.speed_rad_s=0.2", "path=sine"])


def test_another_kind_has_settings_of_its_own() -> None:
    assert assign_text(TREE, "path=slow_sweep") == TREE
    assert assign_text(TREE, "path=sine").path == Sine()
    for entries in (["path=sine", "amplitude_rad=0.7"], ["amplitude_rad=0.7", "path=sine"]):
        assert assign_texts(TREE, entries).path == Sine(0.7)
    assert assign_text(TREE, "compensator=none").compensator is None
    again = assign_text(assign_text(TREE, "compensator=none"), "compensator=compensator")
    assert again == TREE


def test_nested_settings_tell_what_kind_was_chosen() -> None:
    nested = as_nested(assign_text(TREE, "compensator=none"))
    assert nested["path"] == {"kind": "slow_sweep", "speed_rad_s": 0.1}
    assert nested["compensator"] is None
    assert nested["joints"] == ({"coulomb_nm": 0.3, "viscous_nms_per_rad": 0.07},) * 3


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_what_is_written_reads_back(value: float) -> None:
    assert assign_text(TREE, f"duration_s={write_value(value)}").duration_s == value


def test_values_of_the_joints_are_written_as_they_are_set() -> None:
    changed = assign_text(TREE, "joints.coulomb_nm=0.4@1,3")
    assert write_value(paths(changed)["joints.coulomb_nm"]) == "0.4@1,3  0.3@2"
    assert write_value(paths(TREE)["joints.coulomb_nm"]) == "0.3"


@EACH_SCENARIO
def test_every_setting_of_a_scenario_can_be_assigned(scenario: Scenario) -> None:
    listed = paths(scenario.settings)
    for path, value in listed.items():
        if not isinstance(value, PerJoint):
            assert assign_text(scenario.settings, f"{path}={write_value(value)}") == scenario.settings
        else:
            again = scenario.settings
            for part in write_value(value).split("  "):
                again = assign_text(again, f"{path}={part}")
            assert again == scenario.settings
