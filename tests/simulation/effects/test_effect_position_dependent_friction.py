import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.simulation.effects.position_dependent_friction import PositionDependentFriction, factor
from friction_audit.simulation.mechanics.records import pack

FORMS = range(len(PositionDependentFriction.forms))


def at(form: str, q: float, share: float = 0.4) -> float:
    group = PositionDependentFriction(
        share=share, cycles_per_rev=2.0, phase_rad=0.0, form=PositionDependentFriction.forms.index(form)
    )
    return factor(pack([group])[0], q)


def test_sinusoid_has_its_crest_a_quarter_of_the_cycle_on() -> None:
    assert at("sinusoid", 0.0) == 1.0
    assert at("sinusoid", math.pi / 4) == pytest.approx(1.4)
    assert at("sinusoid", -math.pi / 4) == pytest.approx(0.6)


def test_harmonics_never_repeat_within_the_range_of_a_joint() -> None:
    places = np.linspace(-3.0, 3.0, 601)
    level = np.array([at("harmonics", q) for q in places])
    assert at("harmonics", math.pi / 4) == pytest.approx(
        1 + 0.4 * (0.5 + 0.3 * math.sin(math.sqrt(3) * math.pi / 2) + 0.2 * math.sin(math.sqrt(7) * math.pi / 2))
    )
    assert np.ptp(level) > 0.5
    assert np.ptp(level[314:] - level[:-314]) > 0.2


def test_patch_is_one_smooth_bump_per_cycle() -> None:
    assert at("patch", 0.0) == pytest.approx(1.4)
    assert at("patch", math.pi) == pytest.approx(1.4)
    assert at("patch", math.pi / 2) == pytest.approx(1.0, abs=1e-6)
    assert at("patch", math.acos(1 - math.log(2) / 8) / 2) == pytest.approx(1.2)


@given(form=st.sampled_from(FORMS), q=st.floats(-7, 7), share=st.floats(-1, 3))
def test_passive_and_nothing_without_a_share(form: int, q: float, share: float) -> None:
    assert factor(pack([PositionDependentFriction(share=share, form=form)])[0], q) >= 0.0
    assert factor(pack([PositionDependentFriction(form=form)])[0], q) == 1.0
