"""Every pair of effects has a motion that decides, those that are often confused one of their own."""

import re
from itertools import combinations
from pathlib import Path

import pytest

from friction_audit.diagnosis.candidate import Candidate
from friction_audit.diagnosis.candidates import CANDIDATES
from friction_audit.diagnosis.decide import MOTIONS, PAIRS, motion_between, motion_to_decide

NAMES = [candidate.name for candidate in CANDIDATES]
PAGES = Path(__file__).parents[2] / "docs" / "effects"

CONFUSED = (
    ("stribeck", "nonlinear_viscous"),
    ("stribeck", "presliding"),
    ("stiction", "stribeck"),
    ("stiction", "contact_event"),
    ("asymmetric_coulomb", "torque_bias"),
    ("asymmetric_viscous", "torque_bias"),
    ("asymmetric_viscous", "gravity_error"),
    ("presliding", "backlash"),
    ("presliding", "frictional_lag"),
    ("frictional_lag", "time_delay"),
    ("load_dependent_friction", "position_dependent_friction"),
    ("load_dependent_friction", "asymmetric_coulomb"),
    ("position_dependent_friction", "torque_ripple"),
    ("torque_ripple", "joint_elasticity"),
    ("gravity_error", "torque_bias"),
    ("gravity_error", "cable_spring"),
    ("gravity_error", "inertia_error"),
    ("joint_limit_stop", "cable_spring"),
    ("torque_drift", "warm_up"),
    ("torque_crosstalk", "inertial_coupling"),
    ("time_delay", "joint_elasticity"),
    ("friction_step", "contact_event"),
    ("friction_step", "gravity_error"),
)
"""The column "confused with" of the catalogue that the candidates were written from."""


def confused_on_the_pages() -> set[frozenset[str]]:
    pairs = set()
    for page in PAGES.glob("*.md"):
        table = page.read_text().partition("## Confused with")[2].partition("\n## ")[0]
        pairs |= {frozenset((page.stem, name)) for name in re.findall(r"^\| \[(\w+)\]", table, re.MULTILINE)}
    return pairs


def test_every_confused_pair_has_an_entry_of_its_own() -> None:
    told = {frozenset(pair[:2]) for pair in PAIRS}
    pages = confused_on_the_pages()
    assert len(pages) > 40
    assert {frozenset(pair) for pair in CONFUSED} | pages <= told


def test_no_pair_stands_twice_or_names_a_stranger() -> None:
    assert len({frozenset(pair[:2]) for pair in PAIRS}) == len(PAIRS)
    assert {name for pair in PAIRS for name in pair[:2]} <= set(NAMES)
    assert set(MOTIONS) == set(NAMES)


@pytest.mark.parametrize("candidate", CANDIDATES, ids=lambda candidate: candidate.name)
def test_what_no_motion_of_a_kind_tells_apart_has_an_entry(candidate: Candidate) -> None:
    told = {frozenset(pair[:2]) for pair in PAIRS}
    assert {frozenset((candidate.name, other)) for other in (*candidate.same_as, *candidate.part_of)} <= told


def test_any_two_effects_have_a_motion_and_order_means_nothing() -> None:
    for one, other in combinations(NAMES, 2):
        motion = motion_between(one, other)
        assert re.match(r"[a-z]", motion)
        assert set(motion.split("; ")) == set(motion_between(other, one).split("; "))


def test_a_pair_that_nobody_confuses_gets_the_motions_of_both() -> None:
    assert motion_between("stribeck", "torque_drift") == f"{MOTIONS['stribeck']}; {MOTIONS['torque_drift']}"
    assert motion_between("joint_elasticity", "gravity_error").startswith(MOTIONS["joint_elasticity"])


def test_without_alternatives_nothing_is_to_be_decided() -> None:
    assert motion_to_decide("stribeck", ()) == ""


def test_one_alternative_gets_its_motion_and_several_their_names() -> None:
    rest = "let the joint rest unloaded for 2 s: a bias is read at rest too, friction is not"
    assert motion_to_decide("torque_bias", ["asymmetric_coulomb"]) == rest
    text = motion_to_decide("torque_bias", ["asymmetric_coulomb", "torque_drift"])
    assert (
        text
        == f"against asymmetric_coulomb: {rest}; against torque_drift: {motion_between('torque_bias', 'torque_drift')}"
    )


def test_alternatives_with_the_same_motion_share_it() -> None:
    assert motion_to_decide("position_dependent_friction", ["torque_ripple", "gravity_error"]) == (
        "pass every place four times in each direction"
    )
