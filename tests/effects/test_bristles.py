"""Bristles read off a term: by hand for a stop and for Dahl's exponential, and the path of any motion."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from friction_audit.dynamics.bristles import NO_BRISTLES, bristles_of
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.effects.terms import TERMS
from friction_audit.joint_log import Float

LEVEL, REACH = 0.3, 0.01


def invent(monkeypatch: pytest.MonkeyPatch, basis: Callable[[Motion], Float]) -> FittedTerm:
    """A term ``invented``, of one parameter, with bristles."""
    term = Term(
        name="invented",
        label="invented",
        coefficients=(Parameter(name="invented_nm", unit="N m", meaning="invented"),),
        basis=lambda motion, _shape: basis(motion)[:, None],
        friction=True,
        forward="bristle",
    )
    monkeypatch.setattr("friction_audit.effects.terms.TERMS", (*TERMS, term))
    return FittedTerm("invented", (LEVEL,))


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


WAY = 0.03 * np.sin(np.linspace(0.0, 12.0, 3001)) * np.linspace(0.1, 1.0, 3001)


def test_a_stop_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """A spring that slips at 0.3 N m, in the place of 0.3 N m of dry friction: a straight line over twice the reach."""
    term = invent(monkeypatch, lambda motion: stop(motion.q, REACH) - np.sign(motion.dq))
    dry, found, springs = bristles_of(term)
    assert dry == pytest.approx(-LEVEL, rel=1e-6)
    assert np.interp([0.0, REACH, 2 * REACH, 0.3], found.path, found.torque) == pytest.approx(
        [LEVEL, 0.0, -LEVEL, -LEVEL], abs=1e-3
    )
    assert found.damping_s == pytest.approx(0.0, abs=1e-9)
    for bristles in (found, springs):
        assert bristles.along(WAY) == pytest.approx(LEVEL * stop(WAY, REACH), abs=2e-3)
    assert springs.reach == pytest.approx([REACH], rel=1e-3)
    assert springs.stiffness == pytest.approx([LEVEL / REACH], rel=1e-3)


def test_an_exponential_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    term = invent(monkeypatch, lambda motion: dahl(motion.q, REACH) - np.sign(motion.dq))
    dry, found, _ = bristles_of(term)
    assert dry == pytest.approx(-LEVEL, rel=1e-4)
    curve = LEVEL * (2.0 * np.exp(-found.path / REACH) - 1.0)
    assert found.torque == pytest.approx(curve, abs=1e-3)
    assert found.along(WAY) == pytest.approx(LEVEL * dahl(WAY, REACH), abs=2e-3)


def test_springs_remember_every_reversal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two stops of 2 and 10 mrad: a loop within a loop leaves no trace, which no single curve gives."""

    def two(q: Float) -> Float:
        return 0.5 * (stop(q, 0.002) + stop(q, 0.01))

    term = invent(monkeypatch, lambda motion: two(motion.q) - np.sign(motion.dq))
    _, found, springs = bristles_of(term)
    way = np.interp(np.arange(5001), [0, 1000, 2000, 3000, 4000, 5000], [0.0, 0.03, 0.018, 0.022, 0.01, 0.03])
    wrong = [np.sqrt(np.mean((one.along(way) - LEVEL * two(way)) ** 2)) for one in (springs, found)]
    assert wrong[0] < 3e-3
    assert wrong[1] > 5.0 * wrong[0]


def test_bristles_beside_dry_friction_take_nothing_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    dry, found, _ = bristles_of(invent(monkeypatch, lambda motion: stop(motion.q, REACH)))
    assert dry == pytest.approx(0.0, abs=1e-6)
    assert found.torque[0] == pytest.approx(LEVEL)


def test_the_damping_of_their_bending_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    damping = 0.02

    def basis(motion: Motion) -> Float:
        z = dahl(motion.q, REACH)
        return z + damping * np.gradient(z, motion.t) - np.sign(motion.dq)

    dry, found, _ = bristles_of(invent(monkeypatch, basis))
    assert found.damping_s == pytest.approx(damping, rel=0.02)
    assert dry == pytest.approx(-LEVEL, rel=0.01)


def test_no_bristles_take_nothing() -> None:
    assert np.array_equal(NO_BRISTLES.along(WAY), np.zeros(len(WAY)))
