import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from friction_audit.simulation.effects.cable_spring import CableSpring, torque_nm
from friction_audit.simulation.mechanics.records import pack

FORMS = range(len(CableSpring.forms))


@pytest.mark.parametrize(
    ("form", "q", "expected"),
    [
        ("linear", 0.7, -0.2),
        ("linear", -0.3, 0.2),
        ("hardening", 1.2, -0.8),
        ("slack", 0.4, 0.0),
        ("slack", 0.7, -0.08),
        ("slack", -0.3, 0.08),
        ("tether", 0.7, -0.08),
        ("tether", -0.9, 0.0),
    ],
)
def test_pull_towards_the_centre(form: str, q: float, expected: float) -> None:
    group = CableSpring(stiffness_nm_per_rad=0.4, centre_rad=0.2, free_rad=0.3, form=CableSpring.forms.index(form))
    assert torque_nm(pack([group])[0], q) == pytest.approx(expected)


@pytest.mark.parametrize("form", FORMS)
def test_torque_is_continuous_and_never_pushes_away(form: int) -> None:
    record = pack([CableSpring(stiffness_nm_per_rad=0.4, form=form)])[0]
    places = np.linspace(-1.5, 1.5, 3001)
    torque = np.array([torque_nm(record, q) for q in places])
    assert (torque * places <= 0.0).all()
    assert_allclose(np.diff(torque), 0.0, atol=0.4 * (1 + 3 * 1.5**2) * 1.1e-3)


@given(form=st.sampled_from(FORMS), q=st.floats(-7, 7))
def test_nothing_without_stiffness(form: int, q: float) -> None:
    assert torque_nm(pack([CableSpring(form=form)])[0], q) == 0.0
