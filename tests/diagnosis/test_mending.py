"""What a formula without a direction lacks is no friction; what any other lacks may be anything."""

import pytest

from friction_audit.diagnosis.candidates import CANDIDATES
from friction_audit.diagnosis.mending import DIRECTIONLESS, TURNING, may_mend


def test_only_effects_of_the_catalogue_are_listed_and_none_is_both() -> None:
    names = {candidate.name for candidate in CANDIDATES}
    assert names >= {*DIRECTIONLESS, *TURNING}
    assert not set(DIRECTIONLESS) & set(TURNING)


@pytest.mark.parametrize(
    ("small", "large", "may"),
    [
        ("stribeck", "gravity_error", False),
        ("position_dependent_friction", "gravity_error", False),
        ("warm_up", "torque_drift", False),
        ("cable_spring", "gravity_error", True),
        ("gravity_error", "stribeck", True),
        ("stribeck", "presliding", True),
        ("stribeck", "joint_elasticity", True),
        ("time_delay", "gravity_error", True),
    ],
)
def test_friction_is_not_what_a_torque_of_place_or_time_lacks(small: str, large: str, may: bool) -> None:
    assert may_mend(small, large) == may
