"""Two joints that stop at one instant, the second having gone a rounding error too far."""

import numpy as np

from friction_audit.simulation.mechanics.records import make_body
from friction_audit.simulation.mechanics.step import _first_stop


def test_a_joint_past_zero_stops_at_once_even_at_the_end_of_a_step() -> None:
    body = make_body(np.zeros(2, dtype=bool), np.zeros(2, dtype=bool), np.zeros(2))
    body.mode[:2], body.v[:2] = (1.0, 1.0), (0.5, -1e-18)
    assert _first_stop(body, 0.0) == (1, 0.0)
    body.a[:2] = (-10.0, 0.0)
    assert _first_stop(body, 0.1) == (1, 0.0)


def test_the_share_is_that_of_a_straight_line() -> None:
    body = make_body(np.zeros(2, dtype=bool), np.zeros(2, dtype=bool), np.zeros(2))
    body.mode[:2], body.v[:2], body.a[:2] = (1.0, -1.0), (0.5, -0.1), (-10.0, 4.0)
    assert _first_stop(body, 0.1) == (1, 0.25)
