import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.simulation.effects.load_dependent_friction import LoadDependentFriction, extra_nm
from friction_audit.simulation.mechanics.records import pack

FORMS = range(len(LoadDependentFriction.forms))


@pytest.mark.parametrize(
    ("form", "load_nm", "power_w", "expected"),
    [
        ("linear", -5.0, 1.0, 0.5),
        ("linear", 5.0, -1.0, 0.5),
        ("quadratic", -5.0, 1.0, 0.25),
        ("quadratic", 10.0, 1.0, 1.0),
        ("backdrive", -5.0, 1.0, 0.75),
        ("backdrive", -5.0, -1.0, 0.25),
        ("backdrive", -5.0, 0.0, 0.5),
    ],
)
def test_friction_of_a_load(form: str, load_nm: float, power_w: float, expected: float) -> None:
    group = LoadDependentFriction(share=0.1, form=LoadDependentFriction.forms.index(form))
    assert extra_nm(pack([group])[0], load_nm, power_w) == pytest.approx(expected, rel=1e-12)


@given(form=st.sampled_from(FORMS), load=st.floats(-200, 200), power=st.floats(-50, 50))
def test_passive_and_nothing_without_a_share(form: int, load: float, power: float) -> None:
    assert extra_nm(pack([LoadDependentFriction(share=0.06, form=form)])[0], load, power) >= 0.0
    assert extra_nm(pack([LoadDependentFriction(form=form)])[0], load, power) == 0.0
