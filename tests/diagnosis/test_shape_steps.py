"""Steps of shapes, of any candidate, also where a number is at the end of what makes sense."""

import numpy as np
import pytest

from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.shape_steps import steps_of
from friction_audit.effects.effect import Effect
from friction_audit.effects.registry import effects
from tests.diagnosis.found_effect import found_effect
from tests.diagnosis.moved_joint import moved_joint

GROUND = make_ground(moved_joint(noise_nm=0.02, duration_s=10.0), None, 0)


def numbers(candidate: Effect) -> list[str]:
    """Names of the numbers of its shapes that are no kinds."""
    shapes = candidate.grid(GROUND.data)
    whole = tuple(p.name for p in candidate.nonlinear if p.whole)
    return [name for name in (shapes[0] if shapes else ()) if name not in whole]


CASES = [
    (candidate, name, end)
    for candidate in effects()
    for name in numbers(candidate)
    for end in candidate.bounds(name)
    if np.isfinite(end)
]


@pytest.mark.parametrize(("candidate", "name", "end"), CASES, ids=[f"{c.name}-{n}-{e:g}" for c, n, e in CASES])
def test_steps_are_numbers_at_the_end_of_what_makes_sense(candidate: Effect, name: str, end: float) -> None:
    shape = {**candidate.grid(GROUND.data)[0], name: end}
    steps = steps_of(GROUND, [found_effect(GROUND, candidate, shape)], GROUND.baseline())
    assert np.isfinite([step.value for step in (*steps.linear, *steps.shapes[0].values())]).all()
