"""Tables of terms: read along a recording they give what the terms give, and say so where they cannot."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.dynamics.along_recording import BETWEEN
from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.torque_tables import certain, read_along, tabulate
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.effects.terms import TERMS
from friction_audit.joint_log import Float
from tests.effects.recordings import make_recording, typical_term

RECORDING = make_recording()


def invent(monkeypatch: pytest.MonkeyPatch, basis: Callable[[Motion], Float], *, speed: bool = False) -> FittedTerm:
    """A term ``invented`` of one parameter, with the value 1."""
    term = Term(
        name="invented",
        label="invented",
        linear=(Parameter(name="invented_nm", unit="N m", meaning="invented"),),
        basis=lambda motion, _shape: basis(motion)[:, None],
        speed_only=speed,
    )
    monkeypatch.setattr("friction_audit.effects.terms.TERMS", (*TERMS, term))
    return FittedTerm("invented", (1.0,))


@pytest.mark.parametrize(
    "term", [term for term in TERMS if term.forward not in BETWEEN and term.name != "inertia"], ids=lambda t: t.name
)
def test_every_term_is_tabulated_or_left_to_the_past(term: Term) -> None:
    fitted = typical_term(term)
    tables, past = tabulate(0.3, (fitted,), RECORDING)
    if past:
        assert past == (fitted,)
        assert np.array_equal(tables.speed, np.zeros_like(tables.speed))
        return
    sure = certain(RECORDING) != 0.0
    expected = (0.3 * RECORDING.ddq + fitted.torque(RECORDING))[sure]
    found = read_along(tables, RECORDING)[sure]
    scale = np.sqrt(np.mean(fitted.torque(RECORDING) ** 2))
    assert np.sqrt(np.mean((found - expected) ** 2)) <= 0.1 * scale


@pytest.mark.parametrize(
    "name",
    ["coulomb", "viscous", "offset", "stribeck", "nonlinear_viscous", "torque_ripple", "torque_drift", "presliding"],
)
def test_these_need_no_past(name: str) -> None:
    term = next(term for term in TERMS if term.name == name)
    assert tabulate(0.3, (typical_term(term),), RECORDING)[1] == ()


def test_a_torque_over_speed_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    term = invent(monkeypatch, lambda motion: np.sign(motion.dq) * np.sqrt(np.abs(motion.dq)), speed=True)
    tables, past = tabulate(0.3, (term,), RECORDING)
    assert past == ()
    fast = len(RECORDING.t) // 2
    assert tables.speed[:, fast] == pytest.approx(np.array([1, -1]) * np.sqrt(fast * tables.speed_step), rel=1e-12)
    assert tables.speed[:, 0] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert not tables.place.any()
    assert not tables.time.any()


def test_a_torque_over_place_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    term = invent(monkeypatch, lambda motion: motion.q**3 + np.sign(motion.dq) * motion.q**2 + 2 * motion.dq * motion.q)
    tables, past = tabulate(0.3, (term,), RECORDING)
    assert past == ()
    place = tables.place_start + tables.place_step * np.arange(len(RECORDING.t))
    assert place[0] < RECORDING.q.min() < RECORDING.q.max() < place[-1]
    assert_allclose(tables.place[0], place**3 + place**2, rtol=0.0, atol=1e-8)
    assert_allclose(tables.place[1], place**3 - place**2, rtol=0.0, atol=1e-8)
    assert_allclose(tables.place_per_speed[0], 2 * place, rtol=0.0, atol=1e-6)
    assert_allclose(tables.place_per_speed[1], -2 * place, rtol=0.0, atol=1e-6)


def test_a_torque_over_time_load_and_neighbours_is_taken_as_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    def basis(motion: Motion) -> Float:
        assert motion.load is not None
        assert motion.others is not None
        return 0.1 * motion.load * np.sign(motion.dq) + 0.2 * motion.others.ddq[:, 0] + 0.01 * motion.t

    term = invent(monkeypatch, basis)
    tables, past = tabulate(0.3, (term,), RECORDING)
    assert past == ()
    assert RECORDING.load is not None
    assert RECORDING.others is not None
    both = 0.2 * RECORDING.others.ddq[:, 0] + 0.01 * RECORDING.t
    assert_allclose(tables.time[0], both + 0.1 * RECORDING.load, rtol=1e-6, atol=1e-12)
    assert_allclose(tables.time[1], both - 0.1 * RECORDING.load, rtol=1e-6, atol=1e-12)


def test_a_share_of_the_acceleration_is_inertia(monkeypatch: pytest.MonkeyPatch) -> None:
    term = invent(monkeypatch, lambda motion: 0.05 * motion.ddq + 0.2)
    tables, past = tabulate(0.3, (term,), RECORDING)
    assert past == ()
    assert tables.inertia_kg_m2 == pytest.approx(0.35)
    assert tables.speed[:, 7] == pytest.approx([0.2, 0.2])


@pytest.mark.parametrize(
    "basis",
    [
        lambda motion: np.cumsum(np.abs(motion.dq)) * np.sign(motion.dq) * 1e-3,
        lambda motion: np.roll(motion.dq, 40),
        lambda motion: motion.t * np.abs(motion.dq) ** 1.5 * np.sign(motion.dq),
    ],
    ids=["sum", "late", "curved and changing"],
)
def test_what_no_table_holds_is_left_to_the_past(
    monkeypatch: pytest.MonkeyPatch, basis: Callable[[Motion], Float]
) -> None:
    term = invent(monkeypatch, basis)
    assert tabulate(0.3, (term,), RECORDING)[1] == (term,)


def test_second_bristles_are_left_to_the_past() -> None:
    term = typical_term(next(term for term in TERMS if term.forward == "bristle"))
    tables, past = tabulate(0.3, (term, term), RECORDING)
    assert past == (term,)
    assert len(tables.bristle_path) > 0


def test_a_direction_is_not_certain_at_rest() -> None:
    motion = replace(RECORDING, dq=np.linspace(-1.0, 1.0, len(RECORDING.t)))
    way = certain(motion)
    assert set(way) == {-1.0, 0.0, 1.0}
    assert np.all(way[np.abs(motion.dq) > 1e-3] != 0.0)
