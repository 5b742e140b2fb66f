"""Choices are checked when they are made."""

from typing import Any

import pytest

from friction_audit.errors import UsageError
from friction_audit.preprocessing.settings import TorqueSettings


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({"torque": "tau"}, "--torque tau: expected one of auto, interaction, tau_ext, tau_J"),
        ({"drive": "foot"}, "--drive foot"),
        ({"model_rate_hz": 0.0}, "--model-rate 0"),
        ({"payload": (0.0, 0.0, 0.0, 0.1)}, "--payload 0,0,0,0.1: expected mass,x,y,z"),
        ({"payload": (1.0, float("nan"), 0.0, 0.1)}, "--payload 1,nan,0,0.1"),
        ({"gravity_vector": (0.0, 0.0, float("nan"))}, "--gravity-vector"),
    ],
)
def test_a_wrong_choice_is_refused_with_the_right_ones(choice: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        TorqueSettings(**choice)
