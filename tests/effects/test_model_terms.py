"""Every term keeps the contract, and the five give what a hand calculation gives."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import FittedTerm, JointModel, simple_model
from friction_audit.effects.registry import terms
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from tests.effects.recordings import typical_term

SHAPES = {term.name: typical_term(term).values[len(term.coefficients) :] for term in terms()}


def make_motion(dq: Float) -> Motion:
    t = np.arange(len(dq), dtype=np.float64) * 1e-3
    return Motion(
        t=t,
        q=np.cumsum(dq) * 1e-3,
        dq=dq,
        ddq=np.gradient(dq, 1e-3) if len(dq) > 1 else 0.0 * dq,
        load=2.0 + 0.0 * t,
        temperature=25.0 + t,
        rest=0.3 * np.sign(dq) + 0.1 * dq,
    )


@pytest.fixture
def motion() -> Motion:
    return make_motion(np.sin(np.linspace(0.0, 20.0, 401)))


@pytest.mark.parametrize("term", terms(), ids=lambda term: term.name)
def test_friction_never_pushes(term: Effect, motion: Motion) -> None:
    if term.friction and all(parameter.lower >= 0.0 for parameter in term.coefficients):
        values = tuple(0.3 for _ in term.coefficients) + SHAPES[term.name]
        assert np.all(term.torque(motion, values) * motion.dq >= 0.0)


@pytest.mark.parametrize("term", [term for term in terms() if term.speed_only], ids=lambda term: term.name)
def test_a_term_of_the_velocity_alone_sees_nothing_else(term: Effect, motion: Motion) -> None:
    values = tuple(0.3 for _ in term.coefficients) + SHAPES[term.name]
    elsewhere = Motion(
        t=3.0 * motion.t + 5.0,
        q=2.0 * motion.q - 1.0,
        dq=motion.dq,
        ddq=motion.ddq + 2.0,
        load=0.0 * motion.t - 1.0,
        temperature=30.0 + 9.0 * motion.t,
        rest=2.0 * motion.dq,
    )
    assert np.array_equal(term.torque(motion, values), term.torque(elsewhere, values))


def test_torque_and_friction_of_a_model_by_hand() -> None:
    still = np.zeros(2)
    motion = Motion(t=np.array([0.0, 1.0]), q=still, dq=np.array([2.0, -2.0]), ddq=np.array([1.0, 1.0]))
    model = simple_model(inertia_kg_m2=0.5, coulomb_nm=0.3, viscous_nms_per_rad=0.1)
    model = replace(model, terms=(*model.terms, FittedTerm("offset", (0.05,))))
    assert model.friction(motion) == pytest.approx([0.5, -0.5])
    assert model.torque(motion) == pytest.approx([1.05, 0.05])
    # What is left of the inertia where a model of the links took too much of it.
    assert JointModel(inertia_kg_m2=-0.1).torque(motion) == pytest.approx([-0.1, -0.1])


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("coulom", (1.0,), r"'coulom' is no term \(did you mean coulomb\?\); expected inertia, coulomb"),
        ("coulomb", (-1.0,), "term coulomb: coulomb_nm = -1; expected a number from 0 to inf"),
        ("offset", (np.nan,), "offset_nm = nan"),
        ("stribeck", (1.0,), "1 values; expected 3: stribeck_excess_nm, stribeck_speed_rad_s, stribeck_exponent"),
    ],
)
def test_a_term_that_cannot_be_is_refused(name: str, values: tuple[float, ...], message: str) -> None:
    with pytest.raises(AnalysisError, match=message):
        FittedTerm(name, values)


def test_a_term_twice_and_inertia_among_the_terms_are_refused() -> None:
    with pytest.raises(AnalysisError, match="term offset stands twice"):
        JointModel(inertia_kg_m2=1.0, terms=(FittedTerm("offset", (1.0,)), FittedTerm("offset", (2.0,))))
    with pytest.raises(AnalysisError, match="expected it as inertia_kg_m2"):
        JointModel(inertia_kg_m2=1.0, terms=(FittedTerm("inertia", (1.0,)),))
