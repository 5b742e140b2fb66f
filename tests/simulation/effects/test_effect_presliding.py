import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.velocity import (
    BRISTLES,
    DAHL,
    FIRST_YIELD,
    LUGRE,
    MAXWELL_SLIP,
    Presliding,
    dahl_advance,
    lugre_advance,
    passive_damping,
    presliding_advance,
    presliding_force_nm,
    presliding_stiffness,
)
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(Presliding.forms))
COULOMB_NM = 0.3
DISPLACEMENT_RAD = 0.005
SIGMA0 = COULOMB_NM / DISPLACEMENT_RAD
YIELDS = DISPLACEMENT_RAD * FIRST_YIELD * np.arange(1, BRISTLES + 1)


class Bristles:
    """Presliding of one joint that moves along pieces of path."""

    def __init__(self, form: int, damping_s: float = 0.0) -> None:
        self.group = pack([Presliding(displacement_rad=DISPLACEMENT_RAD, damping_s=damping_s, form=form)])[0]
        self.form = form
        self.deflection: Float = np.zeros(BRISTLES)

    def move(self, path: float, *, level: float = COULOMB_NM, velocity: float = 0.1, steps: int = 1) -> float:
        signed = math.copysign(velocity, path)
        for _ in range(steps):
            presliding_advance(self.group, self.deflection, COULOMB_NM, level, signed, path / signed / steps)
        return presliding_force_nm(self.group, self.deflection, COULOMB_NM, level, signed)

    @property
    def stored_j(self) -> float:
        if self.form == MAXWELL_SLIP:
            return float(0.5 * np.sum(COULOMB_NM / (BRISTLES * YIELDS) * self.deflection**2))
        return float(0.5 * SIGMA0 * self.deflection[0] ** 2)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("level", [0.2, 0.3, 0.5])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_in_steady_motion_friction_is_the_level(form: int, level: float, sign: float) -> None:
    friction = Bristles(form, damping_s=0.005).move(100.0 * sign, level=level, steps=100)
    assert friction == pytest.approx(level * sign, rel=1e-4)


@pytest.mark.parametrize("form", FORMS)
def test_a_short_path_meets_a_spring(form: int) -> None:
    assert Bristles(form).move(1e-7) == pytest.approx(SIGMA0 * 1e-7, rel=1e-4)
    assert presliding_stiffness(Bristles(form).group, COULOMB_NM) == pytest.approx(SIGMA0)


def test_lugre_without_damping_and_dahl_of_exponent_one_approach_by_an_exponential() -> None:
    expected = COULOMB_NM * (1.0 - math.exp(-1.0))
    assert Bristles(LUGRE).move(DISPLACEMENT_RAD) == pytest.approx(expected)
    assert SIGMA0 * dahl_advance(0.0, SIGMA0, COULOMB_NM, 0.1, 0.05, 1.0) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("exponent", "share"),
    [(0.5, 0.75), (1.5, 1.0 - 1.5**-2), (2.0, 0.5)],
    ids=["brittle: 1 - (1 - x/2)^2", "1 - (1 + x/2)^-2", "ductile: 1 - 1/(1 + x)"],
)
def test_dahl_after_its_displacement(exponent: float, share: float) -> None:
    z = dahl_advance(0.0, SIGMA0, COULOMB_NM, 0.1, DISPLACEMENT_RAD / 0.1, exponent)
    assert z * SIGMA0 == pytest.approx(COULOMB_NM * share)


def test_a_brittle_dahl_joint_slides_wholly_after_twice_its_displacement() -> None:
    assert SIGMA0 * dahl_advance(0.0, SIGMA0, COULOMB_NM, 0.1, 0.1, 0.5) == pytest.approx(COULOMB_NM)
    assert SIGMA0 * dahl_advance(0.0, SIGMA0, COULOMB_NM, 0.1, 5.0, 0.5) == pytest.approx(COULOMB_NM)


@pytest.mark.parametrize("slipped", [1, 4, 8])
def test_maxwell_slip_after_some_elements_slipped(slipped: int) -> None:
    path = YIELDS[slipped - 1]
    expected = COULOMB_NM / BRISTLES * np.sum(np.minimum(1.0, path / YIELDS))
    assert Bristles(MAXWELL_SLIP).move(path) == pytest.approx(expected)


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(
    path=st.floats(-0.03, 0.03).filter(lambda path: abs(path) > 1e-9),
    start=st.floats(-0.01, 0.01),
    level=st.floats(0.1, 1.0),
)
def test_many_steps_go_where_one_goes(form: int, path: float, start: float, level: float) -> None:
    one, many = Bristles(form), Bristles(form)
    one.deflection[:] = many.deflection[:] = start
    assert many.move(path, level=level, steps=20) == pytest.approx(one.move(path, level=level), abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_without_micro_damping_friction_is_one_of_path_and_not_of_speed(form: int) -> None:
    slow, fast = Bristles(form), Bristles(form)
    for path in (0.02, -0.004, 0.001, -0.03):
        assert slow.move(path, velocity=0.001) == pytest.approx(fast.move(path, velocity=1.0))


@pytest.mark.parametrize("form", FORMS)
def test_a_reversal_starts_at_minus_what_was_and_turns_it_round(form: int) -> None:
    bristles = Bristles(form)
    bristles.move(100.0, steps=100)
    assert bristles.move(-1e-9) == pytest.approx(COULOMB_NM, rel=1e-3)
    assert bristles.move(-0.1) < -0.9 * COULOMB_NM


def test_the_loop_of_maxwell_slip_has_the_area_of_its_slips() -> None:
    amplitude, steps = 0.02, 4000
    bristles = Bristles(MAXWELL_SLIP)
    bristles.move(amplitude)
    work = 0.0
    for path in (-2.0 * amplitude, 2.0 * amplitude):
        piece = path / steps
        before = bristles.move(0.0)
        for _ in range(steps):
            after = bristles.move(piece)
            work += 0.5 * (before + after) * piece
            before = after
    expected = np.sum(4.0 * COULOMB_NM / BRISTLES * (amplitude - YIELDS))
    assert work == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(
    pieces=st.lists(
        st.tuples(
            st.floats(-0.02, 0.02).filter(lambda path: abs(path) > 1e-9), st.floats(0.05, 1.0), st.floats(1e-3, 3.0)
        ),
        min_size=1,
        max_size=20,
    ),
    damping=st.floats(0.0, 0.1),
)
def test_no_path_takes_energy_from_friction(
    form: int, pieces: list[tuple[float, float, float]], damping: float
) -> None:
    # also while the level changes; the force at the end of a step is that which makes the steps passive too
    bristles = Bristles(form, damping_s=damping)
    taken = 0.0
    for path, level, velocity in pieces:
        taken += bristles.move(path, level=level, velocity=velocity) * path
        assert taken >= bristles.stored_j - 1e-12


@unhurried
@given(sigma1=st.floats(0.0, 1e3), level=st.floats(1e-3, 10.0), velocity=st.floats(-10.0, 10.0))
def test_micro_damping_stays_within_what_is_passive(sigma1: float, level: float, velocity: float) -> None:
    assert passive_damping(sigma1, level, velocity) * abs(velocity) <= 4.0 * level * (1.0 + 1e-12)
    assert passive_damping(sigma1, level, 0.0) == sigma1


@unhurried
@given(z=st.floats(-1.0, 1.0), velocity=st.floats(-10.0, 10.0), h=st.floats(0.0, 10.0))
def test_lugre_is_stable_at_any_step(z: float, velocity: float, h: float) -> None:
    assert abs(lugre_advance(z, 1e5, 1.0, velocity, h)) <= max(abs(z), 1e-5) * (1.0 + 1e-9)


def test_an_inner_loop_leaves_maxwell_slip_where_it_was_and_the_others_weaker() -> None:
    change = {}
    for form in FORMS:
        bristles = Bristles(form)
        before = bristles.move(0.004)
        bristles.move(-0.002)
        change[form] = bristles.move(0.002) - before
    assert change[MAXWELL_SLIP] == pytest.approx(0.0, abs=1e-12)
    assert change[LUGRE] < -0.01
    assert change[DAHL] < -0.01


def creep(form: int) -> Float:
    """Return how far a joint creeps in each swing of a load below break-away. [rad]"""
    inertia, viscous, h, swing, swings = 0.2, 1.0, 1e-3, 2000, 12
    bristles = Bristles(form, damping_s=0.005)
    q = np.zeros(swings * swing + 1)
    dq = 0.0
    for step in range(swings * swing):
        load = 0.15 + 0.1 * math.sin(2.0 * math.pi * step / swing)
        presliding_advance(bristles.group, bristles.deflection, COULOMB_NM, COULOMB_NM, dq, h)
        q[step + 1] = q[step] + h * dq
        friction = presliding_force_nm(bristles.group, bristles.deflection, COULOMB_NM, COULOMB_NM, dq)
        dq += h / inertia * (load - friction - viscous * dq)
    return np.diff(q[::swing])


@pytest.mark.parametrize("form", [LUGRE, DAHL])
def test_under_a_swinging_load_lugre_and_dahl_creep_on(form: int) -> None:
    crept = creep(form)
    assert crept[-1] > 1e-4
    assert crept[-1] > 0.5 * crept[4]


def test_under_a_swinging_load_maxwell_slip_comes_to_stay() -> None:
    crept = creep(MAXWELL_SLIP)
    assert abs(crept[-1]) < 1e-6
    assert abs(crept[-1]) < 0.1 * abs(crept[4])


@pytest.mark.parametrize("form", FORMS)
def test_a_joint_at_rest_stays_as_it_is(form: int) -> None:
    bristles = Bristles(form)
    bristles.move(0.002)
    before = bristles.deflection.copy()
    presliding_advance(bristles.group, bristles.deflection, COULOMB_NM, COULOMB_NM, 0.0, 10.0)
    np.testing.assert_array_equal(bristles.deflection, before)


@pytest.mark.parametrize("form", FORMS)
def test_without_coulomb_friction_nothing_holds(form: int) -> None:
    group: Any = pack([Presliding(displacement_rad=0.005, form=form)])[0]
    deflection: Float = np.zeros(BRISTLES)
    presliding_advance(group, deflection, 0.0, 0.0, 1.0, 0.01)
    assert not deflection.any()
    assert presliding_force_nm(group, deflection, 0.0, 0.0, 1.0) == 0.0


@pytest.mark.parametrize("form", FORMS)
def test_a_level_of_zero_is_a_level(form: int) -> None:
    bristles = Bristles(form)
    assert bristles.move(1.0, level=0.0, steps=10) == pytest.approx(0.0, abs=1e-6)
