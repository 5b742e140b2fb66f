import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from friction_audit.simulation.effects.joint_limit_stop import EXPONENTIAL, JointLimitStop, torque_nm
from friction_audit.simulation.mechanics.records import pack

FORMS = range(len(JointLimitStop.forms))


def wall(form: int, stiffness: float = 20.0) -> np.void:
    group = JointLimitStop(stiffness_nm_per_rad=stiffness, at_rad=0.8, damping_s=0.02, form=form)
    record: np.void = pack([group])[0]
    return record


@pytest.mark.parametrize(
    ("form", "q", "velocity", "expected"),
    [
        ("spring_damper", 0.7, 1.0, 0.0),
        ("spring_damper", 0.9, 0.0, -2.0),
        ("spring_damper", -0.9, 0.0, 2.0),
        ("spring_damper", 0.9, 1.0, -2.4),
        ("spring_damper", 0.9, -1.0, -1.6),
        ("spring_damper", 0.81, -1.0, 0.0),
        ("quadratic", 0.7, 1.0, 0.0),
        ("quadratic", 0.9, 0.0, -2.0),
        ("quadratic", 0.85, 0.0, -0.5),
        ("quadratic", -0.85, -1.0, 0.6),
        ("exponential", 0.8, 0.0, -1.0),
        ("exponential", 0.85, 0.0, -math.e),
        ("exponential", -0.8, 1.0, 0.6),
    ],
)
def test_push_of_the_wall(form: str, q: float, velocity: float, expected: float) -> None:
    assert torque_nm(wall(JointLimitStop.forms.index(form)), q, velocity) == pytest.approx(expected, abs=1e-9)


@given(form=st.sampled_from(FORMS), q=st.floats(0.0, 1.2), velocity=st.floats(-3, 3))
def test_walls_are_alike_and_never_pull(form: int, q: float, velocity: float) -> None:
    torque = torque_nm(wall(form), q, velocity)
    assert torque <= 1e-5
    assert torque_nm(wall(form), -q, -velocity) == -torque
    assert torque_nm(wall(form, stiffness=0.0), q, velocity) == 0.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("speed", [0.5, 3.0])
def test_wall_gives_back_less_than_it_took(form: int, speed: float) -> None:
    place = np.linspace(0.3, 1.1, 2001)
    into = np.array([torque_nm(wall(form), q, speed) for q in place])
    out = np.array([torque_nm(wall(form), q, -speed) for q in place])
    assert -np.trapezoid(into, place) > -np.trapezoid(out, place) >= -1e-9  # the wall at the other end, far away


def test_exponential_wall_stays_finite() -> None:
    assert_allclose(torque_nm(wall(EXPONENTIAL), 100.0, 0.0), -math.exp(20.0))
