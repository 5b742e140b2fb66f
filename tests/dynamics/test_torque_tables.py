"""Terms read off by asking them: bristles by hand, and tables that give along a recording what the terms give."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from friction_audit.dynamics.bristles import bristles_of
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.dynamics.torque_tables import certain, read_along, tabulate
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.joint_log import Float
from tests.dynamics.joints import invent, make_recording

# Bristles read off a term: by hand for a stop and for Dahl's exponential, and along the path of any motion.

LEVEL, REACH = 0.3, 0.01
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
    term = invent(lambda motion: stop(motion.q, REACH) - np.sign(motion.dq), LEVEL, "bristle")
    dry, found, springs = bristles_of(term)
    assert dry == pytest.approx(-LEVEL, rel=1e-6)
    curve = np.interp([0.0, REACH, 2 * REACH, 0.3], found.path, found.torque)
    assert curve == pytest.approx([LEVEL, 0.0, -LEVEL, -LEVEL], abs=1e-3)
    assert found.damping_s == pytest.approx(0.0, abs=1e-9)
    for bristles in (found, springs):
        assert bristles.along(WAY) == pytest.approx(LEVEL * stop(WAY, REACH), abs=2e-3)
    assert springs.reach == pytest.approx([REACH], rel=1e-3)
    assert springs.stiffness == pytest.approx([LEVEL / REACH], rel=1e-3)


def test_springs_remember_every_reversal() -> None:
    """Two stops of 2 and 10 mrad: a loop within a loop leaves no trace, which no single curve gives."""

    def two(q: Float) -> Float:
        return 0.5 * (stop(q, 0.002) + stop(q, 0.01))

    _, found, springs = bristles_of(invent(lambda motion: two(motion.q) - np.sign(motion.dq), LEVEL, "bristle"))
    way = np.interp(np.arange(5001), [0, 1000, 2000, 3000, 4000, 5000], [0.0, 0.03, 0.018, 0.022, 0.01, 0.03])
    wrong = [np.sqrt(np.mean((one.along(way) - LEVEL * two(way)) ** 2)) for one in (springs, found)]
    assert wrong[0] < 3e-3
    assert wrong[1] > 5.0 * wrong[0]


@pytest.mark.parametrize("damping", [0.0, 0.02])
def test_an_exponential_and_the_damping_of_its_bending_by_hand(damping: float) -> None:
    def torque(motion: Motion) -> Float:
        z = dahl(motion.q, REACH)
        return z + damping * np.gradient(z, motion.t) - np.sign(motion.dq)

    dry, found, _ = bristles_of(invent(torque, LEVEL, "bristle"))
    assert found.damping_s == pytest.approx(damping, rel=0.02, abs=1e-6)
    assert dry == pytest.approx(-LEVEL, rel=0.01)
    if damping == 0.0:
        assert found.torque == pytest.approx(LEVEL * (2.0 * np.exp(-found.path / REACH) - 1.0), abs=1e-3)
        assert found.along(WAY) == pytest.approx(LEVEL * dahl(WAY, REACH), abs=2e-3)


# Tables of terms: read along a recording they give what the terms give, and say so where they cannot.

RECORDING = make_recording()
BRISTLES = FittedTerm("presliding", (0.3, 0.005, 1.0, 0.005))


def of_load_and_neighbours(m: Motion) -> Float:
    assert m.load is not None
    assert m.others is not None
    return 0.1 * m.load * np.sign(m.dq) + 0.2 * m.others.ddq[:, 0] + 0.01 * m.t


OF_PLACE = invent(lambda m: m.q**3 + np.sign(m.dq) * m.q**2 + 2 * m.dq * m.q)


@pytest.mark.parametrize(
    "term",
    [
        invent(of_load_and_neighbours),
        OF_PLACE,
        invent(lambda m: np.sign(m.dq) * np.sqrt(np.abs(m.dq))),
        FittedTerm("coulomb", (0.3,)),
        FittedTerm("viscous", (0.1,)),
        FittedTerm("offset", (0.1,)),
        FittedTerm("stribeck", (0.3, 0.1, 1.0)),
        FittedTerm("nonlinear_viscous", (0.3, 0.5, 0.1, 0.0)),
        FittedTerm("torque_ripple", (0.3, 0.1, 20.0)),
        FittedTerm("cable_spring", (0.5, 0.1, 0.0, 0.1, 0.0)),
        FittedTerm("torque_drift", (0.1, 0.1, 0.0, 0.0, 2)),
        FittedTerm("inertia_error", (0.05,)),
        FittedTerm("presliding", BRISTLES.values),
    ],
)
def test_terms_without_a_past_are_tabulated(term: Term) -> None:
    tables, past = tabulate(0.3, (term,), RECORDING)
    assert past == ()
    sure = certain(RECORDING) != 0.0
    error = (read_along(tables, RECORDING) - 0.3 * RECORDING.ddq - term.torque(RECORDING))[sure]
    assert np.sqrt(np.mean(error**2)) <= 0.1 * np.sqrt(np.mean(term.torque(RECORDING) ** 2))


@pytest.mark.parametrize(
    "torque",
    [
        lambda motion: np.cumsum(np.abs(motion.dq)) * np.sign(motion.dq) * 1e-3,
        lambda motion: np.roll(motion.dq, 40),
        lambda motion: motion.t * np.abs(motion.dq) ** 1.5 * np.sign(motion.dq),
    ],
    ids=["sum", "late", "curved and changing"],
)
def test_what_no_table_holds_is_left_to_the_past(torque: Callable[[Motion], Float]) -> None:
    term = invent(torque)
    tables, past = tabulate(0.3, (term,), RECORDING)
    assert past == (term,)
    assert not tables.speed.any()


def test_second_bristles_are_left_to_the_past() -> None:
    tables, past = tabulate(0.3, (BRISTLES, BRISTLES), RECORDING)
    assert past == (BRISTLES,)
    assert len(tables.bristles.path) > 0
