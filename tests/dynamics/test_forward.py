"""A joint of any terms under a recorded torque: by hand, against scipy, and against the exact simulation."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from friction_audit.dynamics.bristles import fit_bristles
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.joint_log import Float, Int
from tests.dynamics.joints import invent, joint_with, make_recording, recording_of, simulate, simulate_segments

RATE_HZ = 400.0
COULOMB, VISCOUS, B = 0.3, 0.07, 0.3


def clock(seconds: float) -> Float:
    return np.arange(round(seconds * RATE_HZ) + 1) / RATE_HZ


def whole(t: Float) -> Int:
    return np.array([[0, len(t) - 1]])


def free(model: JointModel, t: Float, drive: Float, *, q: float = 0.0, dq: float = 0.0, span: float = 1.0) -> Float:
    """Velocity from a start, where nothing else was recorded but the span of positions."""
    positions = q + np.where(np.arange(len(t)) % 2, span, -span)
    positions[0] = q
    speeds = np.where(np.arange(len(t)) % 2, 2.0, -2.0)
    speeds[0] = dq
    return np.asarray(simulate_segments(model, recording_of(t, positions, speeds), drive, whole(t)))


@pytest.mark.parametrize("stribeck", [False, True])
def test_it_agrees_with_the_exact_simulation_through_stick_and_slip(stribeck: bool) -> None:
    t = clock(4.0)
    model = joint_with(*([FittedTerm("stribeck", (0.1, 0.1, 2.0))] if stribeck else []), FittedTerm("offset", (0.03,)))
    drive = 0.8 * np.sin(5.0 * t) * np.sin(0.8 * t)
    exact = simulate(model, t, drive)
    assert np.mean(exact.dq == 0.0) > 0.1
    found = free(model, t, drive)
    assert found == pytest.approx(exact.dq, abs=2e-4)
    assert np.mean(found == 0.0) == pytest.approx(np.mean(exact.dq == 0.0), abs=0.01)


def test_bristles_hold_a_joint_as_a_spring_does() -> None:
    """Dahl's bristles of 0.3 N m and 0.01 rad in the place of Coulomb friction: 30 N m/rad for a small push."""
    t = clock(2.0)
    model = JointModel(
        inertia_kg_m2=B,
        terms=(
            FittedTerm("coulomb", (0.3,)),
            FittedTerm("viscous", (4.0,)),
            FittedTerm("presliding", (0.3, 0.01, 1.0, 0.0)),
        ),
    )
    found = free(model, t, np.full(len(t), 0.003), span=0.2)
    path = np.cumsum(found) / RATE_HZ
    assert path[-1] == pytest.approx(0.003 / 30.0, rel=0.02)
    assert abs(found[-1]) < 1e-6


def test_a_delay_shifts_the_drive() -> None:
    t = clock(3.0)
    drive = 0.9 * np.sin(4.0 * t)
    exact = free(joint_with(), t, drive)
    late = np.interp(t - 0.02, t, drive)
    found = free(joint_with(FittedTerm("time_delay", (0.02, 0.01, 0.0))), t, late)
    assert found[:-8] == pytest.approx(exact[:-8], abs=2e-3)
    assert free(joint_with(), t, late) != pytest.approx(exact, abs=1e-2)


def stiffening(torque: Float) -> Float:
    """Compliance 2 mrad per N m above 0.6 N m: at 0.25 N m 0.8 mrad, at 0.9 N m 2.2 mrad."""
    twist = np.linspace(0.0, 2.4e-3, 1001)
    taken = np.where(twist < 1.6e-3, 250.0 * twist * (1.0 + twist / 3.2e-3), 500.0 * twist - 0.2)
    return np.asarray(np.sign(torque) * np.interp(np.abs(torque), taken, twist))


LINEAR = invent(lambda motion: 0.0 * motion.q, 2e-3, "spring", "soft_rad_per_nm")
STIFFENING = FittedTerm("joint_elasticity", (2e-3, 500.0, 0.6, 0.0, 1.0))


@pytest.mark.parametrize(("term", "twist"), [(LINEAR, lambda torque: 2e-3 * torque), (STIFFENING, stiffening)])
def test_a_spring_puts_the_measured_side_ahead(term: Term, twist: Callable[[Float], Float]) -> None:
    t = clock(3.0)
    drive = 0.9 * np.sin(4.0 * t)
    rigid = simulate(joint_with(), t, drive)
    ahead = twist(drive)
    seen = recording_of(t, rigid.q + ahead, rigid.dq + np.gradient(ahead, t))
    found, plain = (simulate_segments(model, seen, drive, whole(t)) for model in (joint_with(term), joint_with()))
    # At the ends the torque is averaged to one side.
    assert found[5:-5] == pytest.approx(seen.dq[5:-5], abs=2e-3)
    assert np.abs(plain - seen.dq).max() > 5e-3


def test_within_a_play_the_measured_side_is_where_it_was_measured() -> None:
    """The measured side goes to and fro; the other one rests while the play of 0.1 rad is crossed."""
    term = invent(lambda motion: 0.0 * motion.q, 0.1, "gap", "loose_rad")
    t = clock(12.0)
    q, inner = 0.3 * np.sin(t), np.zeros(len(t))
    for i in range(1, len(t)):
        inner[i] = np.clip(inner[i - 1], q[i] - 0.05, q[i] + 0.05)
    dq = np.gradient(inner, t)
    drive = joint_with().torque(recording_of(t, inner, dq))
    seen = recording_of(t, q, 0.3 * np.cos(t))
    pieces = np.array([[1000, len(t) - 1]])
    found, plain = (simulate_segments(model, seen, drive, pieces) for model in (joint_with(term), joint_with()))
    wrong = [np.sqrt(np.mean((one - seen.dq)[1000:] ** 2)) for one in (found, plain)]
    assert wrong[0] < 0.2 * wrong[1]


def test_a_term_with_a_past_is_iterated_to_what_scipy_finds() -> None:
    """Friction in proportion to a speed that lags by 0.2 s: B dv/dt = u - a s, T ds/dt = v - s."""
    lag, slope = 0.2, 0.8

    def basis(motion: Motion) -> Float:
        seen = np.zeros(len(motion.t))
        keep = np.exp(-1.0 / RATE_HZ / lag)
        for i in range(1, len(seen)):
            seen[i] = keep * seen[i - 1] + (1.0 - keep) * 0.5 * (motion.dq[i] + motion.dq[i - 1])
        return seen

    term = invent(basis, slope)
    t = clock(3.0)
    drive = 1.0 + 0.3 * np.sin(3.0 * t)
    exact = solve_ivp(
        lambda time, s: [(1.0 + 0.3 * np.sin(3.0 * time) - slope * s[1]) / B, (s[0] - s[1]) / lag],
        (0.0, 3.0),
        [0.0, 0.0],
        t_eval=t,
        rtol=1e-9,
    ).y[0]
    seen = recording_of(t, np.cumsum(exact) / RATE_HZ, exact + 0.1 * np.sin(t))
    found = simulate_segments(JointModel(inertia_kg_m2=0.3, terms=(term,)), seen, drive, whole(t))
    assert found == pytest.approx(exact, abs=0.01)


def of_load_and_neighbours(m: Motion) -> Float:
    assert m.load is not None
    assert m.others is not None
    return 0.1 * m.load * np.sign(m.dq) + 0.2 * m.others.ddq[:, 0] + 0.01 * m.t


CURVES = [FittedTerm("stribeck", (0.1, 0.1, 2.0)), FittedTerm("nonlinear_viscous", (0.1, 2.0, 0.1, 0.0))]


@pytest.mark.parametrize(
    "terms",
    [
        [*CURVES, FittedTerm("offset", (0.05,)), FittedTerm("torque_ripple", (0.05, 0.05, 30.0))],
        [invent(of_load_and_neighbours)],
        [invent(lambda m: m.q**3 + np.sign(m.dq) * m.q**2 + 2 * m.dq * m.q, 0.5)],
        [invent(lambda m: np.sign(m.dq) * np.sqrt(np.abs(m.dq)))],
        [FittedTerm("cable_spring", (0.5, 0.1, 0.0, 0.1, 0.0))],
        [FittedTerm("torque_drift", (0.1, 0.1, 0.0, 0.0, 2))],
        [FittedTerm("inertia_error", (0.05,))],
        [FittedTerm("presliding", (0.3, 0.005, 1.0, 0.005))],
        [invent(lambda m: np.cumsum(np.abs(m.dq)) * np.sign(m.dq) * 1e-3)],
        [invent(lambda m: m.t * np.abs(m.dq) ** 1.5 * np.sign(m.dq))],
    ],
)
def test_pieces_give_the_recording_back_from_their_starts_and_nothing_between_them(terms: list[Any]) -> None:
    """The torque that a model takes along a recording, given as the drive, gives the recorded motion."""
    recording = replace(make_recording(10.0), rest=None)
    pieces = np.array([[100, 700], [900, 3900]])
    model = joint_with(*terms)
    found = simulate_segments(model, recording, model.torque(recording), pieces)
    inside = np.zeros(len(found), bool)
    inside[100:701] = inside[900:3901] = True
    assert np.array_equal(np.isfinite(found), inside)
    assert found[[100, 900]] == pytest.approx(recording.dq[[100, 900]])
    assert found[inside] == pytest.approx(recording.dq[inside], abs=0.02)


# Bristles read off a term.

LEVEL = 0.3


def stop(q: Float, reach: float) -> Float:
    z = [0.0]
    for displacement in (np.diff(q) / reach).tolist():
        z.append(min(max(z[-1] + displacement, -1.0), 1.0))
    return np.array(z)


def test_springs_remember_every_reversal() -> None:
    """Two stops of 2 and 10 mrad: a loop within a loop leaves no trace, which no single curve gives."""

    def two(q: Float) -> Float:
        return 0.5 * (stop(q, 0.002) + stop(q, 0.01))

    _, found, springs = fit_bristles(invent(lambda motion: two(motion.q) - np.sign(motion.dq), LEVEL, "bristle"))
    q = np.interp(np.arange(5001), [0, 1000, 2000, 3000, 4000, 5000], [0.0, 0.03, 0.018, 0.022, 0.01, 0.03])
    wrong = [np.sqrt(np.mean((one.torque_along(q) - LEVEL * two(q)) ** 2)) for one in (springs, found)]
    assert wrong[0] < 3e-3
    assert wrong[1] > 5.0 * wrong[0]
