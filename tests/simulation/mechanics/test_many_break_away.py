"""Several coupled joints that break away at once: those that slide go the way that friction opposes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.simulation.mechanics.records import Body, make_body
from friction_audit.simulation.mechanics.step import accelerate

JOINTS = 7
LEVEL_NM = np.array([0.3, 0.2, 0.4, 0.3, 0.35, 0.5, 0.3])


def stuck(rng: np.random.Generator) -> Body:
    """Return strongly coupled joints at rest, pulled about as hard as friction holds."""
    body = make_body(np.zeros(JOINTS, dtype=bool), np.zeros(JOINTS, dtype=bool), np.zeros(JOINTS))
    arms = rng.normal(size=(JOINTS, 3))
    body.mass[:JOINTS, :JOINTS] = arms @ arms.T + 0.05 * np.eye(JOINTS)
    body.force[:JOINTS] = LEVEL_NM * rng.normal(0.0, 1.5, JOINTS)
    body.hold[:JOINTS] = body.slip[:JOINTS] = LEVEL_NM[:, None]
    return body


@pytest.mark.parametrize("seed", range(20))
def test_friction_opposes_what_slides_and_bears_what_sticks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(50):
        body = stuck(rng)
        accelerate(body, 0.0)
        mode, ddq = body.mode[:JOINTS], body.a[:JOINTS]
        left = body.force[:JOINTS] - body.mass[:JOINTS, :JOINTS] @ ddq
        assert (mode * ddq >= 0.0).all()
        assert_allclose(left[mode != 0.0], (mode * LEVEL_NM)[mode != 0.0], atol=1e-9)
        assert (np.abs(left) <= LEVEL_NM + 1e-9).all()
        assert (ddq[mode == 0.0] == 0.0).all()
