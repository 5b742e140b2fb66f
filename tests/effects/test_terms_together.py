"""Terms that build many shapes together build what they build one at a time."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.term import Term
from friction_audit.effects.terms import TERMS

T = np.arange(4000) / 400.0
Q = 0.8 * np.sin(1.3 * T) + 0.3 * np.sin(3.1 * T)
DQ, DDQ = np.gradient(Q, T), np.gradient(np.gradient(Q, T), T)
MOTION = Motion(t=T, q=Q, dq=DQ, ddq=DDQ, rest=0.1 * DDQ + 0.3 * np.sign(DQ) + 0.2 * DQ)
SHAPES: dict[str, list[tuple[float, ...]]] = {
    "torque_ripple": [(3.0 + 0.7 * k,) for k in range(110)],
    "presliding": [(0.01, 1.0, 1e-4), (0.05, 0.5, 0.0), (0.01, 1.0, 0.01), (0.05, 2.0, 1e-4)],
    "frictional_lag": [(0.01, 0.2, 0.1), (0.1, 1e-3, 0.3), (0.01, 1.0, 0.3)],
    "joint_elasticity": [(1e3, 0.1, 0.05, 1.0), (2e2, 1e-3, 0.1, 0.7)],
    "backlash": [(1e-3, 22.0, 0.2, 1.0), (1e-4, 50.0, 0.1, 0.7)],
}
TOGETHER = [term for term in TERMS if term.bases is not None]


def test_all_such_terms_are_looked_at() -> None:
    assert {term.name for term in TOGETHER} == set(SHAPES)


@pytest.mark.parametrize("term", TOGETHER, ids=lambda term: term.name)
def test_together_is_one_at_a_time(term: Term) -> None:
    shapes = SHAPES[term.name]
    found = dict(term.regressors(MOTION, shapes))
    assert sorted(found) == list(range(len(shapes)))
    for place, shape in enumerate(shapes):
        assert_allclose(found[place], term.regressor(MOTION, shape), atol=1e-12)


def test_orders_at_any_distance_are_no_recurrence() -> None:
    (ripple,) = (term for term in TERMS if term.name == "torque_ripple")
    for place, column in ripple.regressors(MOTION, [(2.0,), (3.0,), (7.0,)]):
        assert_allclose(column[:, 1], np.sin((2.0, 3.0, 7.0)[place] * Q), atol=1e-12)
