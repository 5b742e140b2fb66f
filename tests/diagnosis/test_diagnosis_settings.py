"""Settings that make no sense are refused."""

import pytest

from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.registry import effects
from friction_audit.errors import UsageError


def test_every_effect_may_be_asked_for() -> None:
    names = tuple(candidate.name for candidate in effects())
    assert DiagnosisSettings(candidates=names).candidates == names


def test_an_effect_that_is_not_known_is_refused_with_those_that_are() -> None:
    with pytest.raises(UsageError, match=r"candidates: friktion: expected some of stribeck, "):
        DiagnosisSettings(candidates=("stribeck", "friktion"))


@pytest.mark.parametrize("torque", [-0.1, float("inf"), float("nan")])
def test_least_effect_is_a_torque(torque: float) -> None:
    with pytest.raises(UsageError, match="expected a torque of zero or more"):
        DiagnosisSettings(min_effect_nm=torque)
