"""Bristles read off a term: by hand for a stop and for Dahl's exponential, and along the path of any motion."""

import math

import numpy as np
import pytest

from friction_audit.dynamics.bristles import bristles_of
from friction_audit.dynamics.motion import Motion
from friction_audit.joint_log import Float
from tests.dynamics.joints import Invented, Law

LEVEL, REACH = 0.3, 0.01
BRISTLE = Law(forward="bristle", friction=True)
WAY = 0.03 * np.sin(np.linspace(0.0, 12.0, 3001)) * np.linspace(0.1, 1.0, 3001)


def stop(q: Float, reach: float) -> Float:
    z = [0.0]
    for way in (np.diff(q) / reach).tolist():
        z.append(min(max(z[-1] + way, -1.0), 1.0))
    return np.array(z)


def dahl(q: Float, reach: float) -> Float:
    z = [0.0]
    for way in (np.diff(q) / reach).tolist():
        end = math.copysign(1.0, way)
        z.append(end + (z[-1] - end) * math.exp(-abs(way)) if way else z[-1])
    return np.array(z)


def test_a_stop_by_hand() -> None:
    """A spring that slips at 0.3 N m, in the place of 0.3 N m of dry friction: a straight line over twice the reach."""
    term = Invented(lambda motion: stop(motion.q, REACH) - np.sign(motion.dq), LEVEL, BRISTLE)
    dry, found, springs = bristles_of(term)
    assert dry == pytest.approx(-LEVEL, rel=1e-6)
    curve = np.interp([0.0, REACH, 2 * REACH, 0.3], found.path, found.torque)
    assert curve == pytest.approx([LEVEL, 0.0, -LEVEL, -LEVEL], abs=1e-3)
    assert found.damping_s == pytest.approx(0.0, abs=1e-9)
    for bristles in (found, springs):
        assert bristles.along(WAY) == pytest.approx(LEVEL * stop(WAY, REACH), abs=2e-3)
    assert springs.reach == pytest.approx([REACH], rel=1e-3)
    assert springs.stiffness == pytest.approx([LEVEL / REACH], rel=1e-3)


def test_an_exponential_by_hand() -> None:
    term = Invented(lambda motion: dahl(motion.q, REACH) - np.sign(motion.dq), LEVEL, BRISTLE)
    dry, found, _ = bristles_of(term)
    assert dry == pytest.approx(-LEVEL, rel=1e-4)
    assert found.torque == pytest.approx(LEVEL * (2.0 * np.exp(-found.path / REACH) - 1.0), abs=1e-3)
    assert found.along(WAY) == pytest.approx(LEVEL * dahl(WAY, REACH), abs=2e-3)


def test_springs_remember_every_reversal() -> None:
    """Two stops of 2 and 10 mrad: a loop within a loop leaves no trace, which no single curve gives."""

    def two(q: Float) -> Float:
        return 0.5 * (stop(q, 0.002) + stop(q, 0.01))

    _, found, springs = bristles_of(Invented(lambda motion: two(motion.q) - np.sign(motion.dq), LEVEL, BRISTLE))
    way = np.interp(np.arange(5001), [0, 1000, 2000, 3000, 4000, 5000], [0.0, 0.03, 0.018, 0.022, 0.01, 0.03])
    wrong = [np.sqrt(np.mean((one.along(way) - LEVEL * two(way)) ** 2)) for one in (springs, found)]
    assert wrong[0] < 3e-3
    assert wrong[1] > 5.0 * wrong[0]


def test_the_damping_of_their_bending_is_found() -> None:
    damping = 0.02

    def torque(motion: Motion) -> Float:
        z = dahl(motion.q, REACH)
        return z + damping * np.gradient(z, motion.t) - np.sign(motion.dq)

    dry, found, _ = bristles_of(Invented(torque, LEVEL, BRISTLE))
    assert found.damping_s == pytest.approx(damping, rel=0.02)
    assert dry == pytest.approx(-LEVEL, rel=0.01)
