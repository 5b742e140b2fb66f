"""Errors of gravity by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.gravity_error import OWN_ANGLE, SEVERAL, TERM, TILT
from tests.effects.arm_motion import N, among_three, rigid_body


def test_of_one_joint_an_amplitude_and_a_phase_of_its_angle() -> None:
    motion = among_three()
    wrong = 0.4 * np.sin(motion.q + 0.7)
    values = (0.4 * np.sin(0.7), 0.4 * np.cos(0.7), *([0.0] * 14), OWN_ANGLE)
    assert TERM.torque(values, motion) == pytest.approx(wrong)


def test_a_link_pulls_by_its_first_moments_and_its_mass() -> None:
    columns = TERM.regressor(among_three(rigid=rigid_body()), (3.0,))
    assert columns == pytest.approx(np.tile([0.0, 0.0, 5.0, 6.0, 7.0, 8.0] + [0.0] * 10, (N, 1)))


def test_several_links_pull_each_by_numbers_of_its_own() -> None:
    columns = TERM.regressor(among_three(rigid=rigid_body()), (SEVERAL,))
    of_link = [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 5.0, 6.0, 7.0, 8.0, 0.0, 0.0, 0.0, 0.0]
    assert columns == pytest.approx(np.tile(of_link, (N, 1)))
    names = [
        parameter.name for parameter, number in zip(TERM.coefficients, of_link, strict=True) if number in {4.0, 8.0}
    ]
    assert names == ["link_mass_kg", "next_link_mass_kg"]


def test_a_tilted_base() -> None:
    columns = TERM.regressor(among_three(rigid=rigid_body()), (TILT,))
    assert columns == pytest.approx(np.tile([0.0] * 6 + [20.0, 21.0] + [0.0] * 8, (N, 1)))


@pytest.mark.parametrize("source", [TILT, SEVERAL, 1, 3])
def test_what_is_not_known_pulls_nothing(source: int) -> None:
    body = rigid_body() if source == 1 else None
    assert not TERM.regressor(among_three(rigid=body), (source,)).any()
