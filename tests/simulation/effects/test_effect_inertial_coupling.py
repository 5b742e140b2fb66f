import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.effects.inertial_coupling import coupled_mass

SEVEN = st.lists(st.floats(0.0, 2.0), min_size=7, max_size=7).map(np.array)
RATIOS = st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7).map(np.array)


def test_two_joints_by_hand() -> None:
    mass = coupled_mass(np.array([0.5, 0.3]), np.array([9.0, 0.2]))
    assert_allclose(mass, [[0.5 + 0.3 * 0.04, 0.06], [0.06, 0.3]])


@given(inertias=SEVEN, ratios=RATIOS, speeds=RATIOS)
def test_kinetic_energy_is_that_of_the_rotors(inertias: np.ndarray, ratios: np.ndarray, speeds: np.ndarray) -> None:
    mass = coupled_mass(inertias, ratios)
    turning = speeds + np.concatenate(([0.0], ratios[1:] * speeds[:-1]))
    assert_array_equal(mass, mass.T)
    assert_allclose(speeds @ mass @ speeds, inertias @ turning**2, atol=1e-12)


@given(inertias=SEVEN)
def test_diagonal_without_coupling(inertias: np.ndarray) -> None:
    assert_array_equal(coupled_mass(inertias, np.zeros(7)), np.diag(inertias))
