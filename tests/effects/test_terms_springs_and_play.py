"""Elasticity and backlash as terms: per compliance, per share, and nothing where there is none."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.term import Term
from friction_audit.effects.terms import backlash, joint_elasticity
from friction_audit.joint_log import Float

T = np.arange(0.0, 20.0, 0.0025)


def waves(coulomb_nm: float = 0.3) -> Motion:
    parts = ((0.5, 2.0, 0.4), (0.2, 5.0, 1.0))
    q = sum((a * np.sin(w * T + p) for a, w, p in parts), np.zeros_like(T))
    dq = sum((a * w * np.cos(w * T + p) for a, w, p in parts), np.zeros_like(T))
    ddq = sum((-a * w * w * np.sin(w * T + p) for a, w, p in parts), np.zeros_like(T))
    return Motion(t=T, q=q, dq=dq, ddq=ddq, rest=0.3 * ddq + coulomb_nm * np.sign(dq) + 0.1 * dq)


def rms(signal: Float) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def test_a_stiff_spring_adds_the_second_derivative_of_the_torque() -> None:
    motion = waves(coulomb_nm=0.0)
    assert motion.rest is not None
    bend = np.gradient(np.gradient(motion.rest, T), T)
    column = joint_elasticity.TERM.regressor(motion, (5e3, 0.0, 0.05, 1.0))[:, 0]
    slope = np.gradient(motion.rest, T)
    expected = -0.3 * bend - 0.1 * slope  # theta = q - c F
    inside = slice(2000, -20)  # past the ringing of the start
    assert rms((column - expected)[inside]) < 0.1 * rms(expected[inside])


def test_twice_the_compliance_adds_about_twice_as_much_as_long_as_it_is_stiff() -> None:
    stiff, soft = (
        k**-1 * joint_elasticity.TERM.regressor(waves(0.0), (k, 0.0, 0.05, 1.0))[2000:, 0] for k in (1e4, 5e3)
    )
    assert rms(soft) == pytest.approx(2.0 * rms(stiff), rel=0.2)


def test_backlash_grows_with_the_gap_and_goes_with_the_share() -> None:
    motion = waves()
    small, large = (rms(backlash.TERM.regressor(motion, (gap, 40.0, 0.2, 1.0))) for gap in (1e-4, 2e-3))
    assert 0.0 < small < large
    assert_array_equal(backlash.TERM.torque((0.0, 2e-3, 40.0, 0.2, 1.0), motion), 0.0)
    assert_array_equal(joint_elasticity.TERM.torque((0.0, 1e3, 0.0, 0.05, 1.0), motion), 0.0)


def test_where_the_torque_keeps_its_sign_the_play_stays_closed() -> None:
    steady = Motion(t=T, q=0.2 * T, dq=np.full_like(T, 0.2), ddq=np.zeros_like(T), rest=np.full_like(T, 0.4))
    closed = backlash.TERM.regressor(steady, (1e-3, 40.0, 0.2, 1.0))[1000:]
    assert rms(closed) < 1e-6


@pytest.mark.parametrize("term", [joint_elasticity.TERM, backlash.TERM], ids=lambda term: term.name)
def test_numbers_that_a_file_may_lack_mean_all_inertia_behind_it_the_usual_damping_and_a_straight_spring(
    term: Term,
) -> None:
    defaults = {parameter.name: parameter.default for parameter in term.parameters if parameter.optional}
    own = {
        "joint_elasticity": {"damping_ratio": 0.05, "soft_nm": 0.0},
        "backlash": {"flank_damping_ratio": 0.2},
    }
    assert defaults == {"far_share": 1.0, **own[term.name]}


def test_without_inertia_or_friction_behind_it_a_spring_adds_nothing() -> None:
    motion = waves(coulomb_nm=0.0)
    assert motion.rest is not None
    smooth = Motion(t=motion.t, q=motion.q, dq=motion.dq, ddq=motion.ddq, rest=0.3 * motion.ddq)
    all_of_it, none = (joint_elasticity.TERM.regressor(smooth, (2e3, 0.0, 0.05, share))[400:] for share in (1.0, 0.0))
    assert rms(none) < 0.02 * rms(all_of_it)


@pytest.mark.parametrize("term", [joint_elasticity.TERM, backlash.TERM], ids=lambda term: term.name)
def test_shares_between_are_between(term: Term) -> None:
    """A part of the inertia behind it adds about that part of what all of it adds, for slow motion."""
    first = {"joint_elasticity": (4e3, 0.0, 0.3), "backlash": (1e-3, 60.0, 0.5)}[term.name]
    added = [rms(term.regressor(waves(0.05), (*first, share))[400:]) for share in (0.3, 0.6, 1.0)]
    assert added == sorted(added)
