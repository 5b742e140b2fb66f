"""A far side drawn along through springs and gap: frequency response, momentum, energy, the width of the gap."""

from dataclasses import astuple, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose

from friction_audit.dynamics import transmission
from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import (
    HIGHEST_HZ,
    FrictionSide,
    Transmission,
    added_torques,
    fit_friction_side,
    hardening,
    spring_torque,
)
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

STEP_S = 0.0025
PLAIN = FrictionSide(inertia_kg_m2=0.2, coulomb_nm=0.0, viscous_nms_per_rad=0.0)
RUBBING = FrictionSide(inertia_kg_m2=0.2, coulomb_nm=0.4, viscous_nms_per_rad=0.1)


def added_torque(motion: Motion, far: FrictionSide, link: Transmission) -> Float:
    """What one transmission adds to the torque of a rigid joint."""
    ((_, added),) = added_torques(motion, [far], [link])
    return np.asarray(added[0])


def transmitted(motion: Motion, far: FrictionSide, link: Transmission) -> Float:
    """All that the measured side feels."""
    followed = max(far.inertia_kg_m2, link.stiffness_nm_per_rad / (2.0 * np.pi * HIGHEST_HZ) ** 2)
    return added_torque(motion, far, link) + rigid(motion, replace(far, inertia_kg_m2=followed))


def sine(amplitude: float, hertz: float, duration_s: float = 20.0) -> Motion:
    t, w = np.arange(0.0, duration_s, STEP_S), 2 * np.pi * hertz
    return Motion(
        t=t, q=amplitude * np.sin(w * t), dq=amplitude * w * np.cos(w * t), ddq=-amplitude * w**2 * np.sin(w * t)
    )


def ramp(*corners: float, speed: float) -> Motion:
    """Positions one after the other at a constant speed."""
    parts = [np.arange(a, b, np.copysign(speed * STEP_S, b - a)) for a, b in pairwise(corners)]
    q = np.concatenate(parts)
    dq = np.concatenate([np.full(len(p), np.copysign(speed, p[-1] - p[0])) for p in parts])
    t: Float = np.arange(len(q), dtype=np.float64) * STEP_S
    return Motion(t=t, q=q, dq=dq, ddq=np.zeros(len(q)))


def rigid(motion: Motion, far: FrictionSide) -> Float:
    friction = far.coulomb_nm * np.sign(motion.dq) + far.viscous_nms_per_rad * motion.dq
    return np.asarray(far.inertia_kg_m2 * motion.ddq + friction)


def amplitude(signal: Float, motion: Motion, hertz: float) -> complex:
    """Of one frequency, over the second half: whole periods."""
    half = len(signal) // 2
    return complex(2.0 * np.mean(signal[half:] * np.exp(-2j * np.pi * hertz * motion.t[half:])))


def test_inertia_and_friction_are_read_off_the_torque() -> None:
    motion = sine(0.5, 0.7)
    found = fit_friction_side(replace(motion, rest=rigid(motion, RUBBING)))
    assert astuple(found) == pytest.approx((0.2, 0.4, 0.1), rel=1e-9)
    with pytest.raises(AnalysisError, match="no torque of inertia and friction"):
        fit_friction_side(motion)


@pytest.mark.parametrize("hertz", [0.5, 3.0, 5.0, 20.0])
def test_frequency_response_of_a_damped_spring(hertz: float) -> None:
    stiffness, ratio, w = 300.0, 0.1, 2 * np.pi * hertz
    motion = sine(0.01, hertz)
    torque = transmitted(motion, PLAIN, Transmission(stiffness_nm_per_rad=stiffness, damping_ratio=ratio))
    link = stiffness + 2j * ratio * np.sqrt(stiffness * PLAIN.inertia_kg_m2) * w
    expected = (
        -PLAIN.inertia_kg_m2 * w**2 * link / (link - PLAIN.inertia_kg_m2 * w**2) * amplitude(motion.q, motion, hertz)
    )
    averaging = np.sinc(hertz * STEP_S)
    assert amplitude(torque, motion, hertz) == pytest.approx(expected * averaging, rel=0.02)


def test_the_torque_is_zero_while_a_slow_motion_crosses_the_gap() -> None:
    gap, speed = 0.02, 0.05
    motion = ramp(0.0, 0.2, 0.0, speed=speed)
    far = replace(RUBBING, inertia_kg_m2=1e-3)
    torque = transmitted(motion, far, Transmission(stiffness_nm_per_rad=1e4, damping_ratio=0.2, gap_rad=gap))
    turned = int(np.argmin(motion.dq))
    free = np.abs(torque[turned:]) < 0.01
    assert free.sum() * STEP_S * speed == pytest.approx(gap, rel=0.03)
    assert torque[turned - 10] == pytest.approx(0.4 + 0.1 * speed, rel=0.01)
    assert torque[-10] == pytest.approx(-0.4 - 0.1 * speed, rel=0.01)


def stopping() -> Motion:
    """0.3 rad/s, to rest from 0.9 s to 1.0 s."""
    t = np.arange(0.0, 4.0, STEP_S)
    dq = 0.3 * np.clip((1.0 - t) / 0.1, 0.0, 1.0)
    return Motion(t=t, q=np.append(0.0, np.cumsum(0.5 * (dq[1:] + dq[:-1])) * STEP_S), dq=dq, ddq=np.gradient(dq, t))


def test_all_momentum_comes_through_the_transmission() -> None:
    torque = transmitted(stopping(), PLAIN, Transmission(stiffness_nm_per_rad=500.0, damping_ratio=0.5))
    assert np.sum(torque) * STEP_S == pytest.approx(-0.3 * 0.2, rel=1e-3)


def test_a_far_side_in_flight_strikes_when_it_has_crossed_half_of_the_gap() -> None:
    # 0.015 rad of the 0.025 while the measured side brakes, the rest at 0.3 rad/s.
    motion = stopping()
    flanks = Transmission(stiffness_nm_per_rad=2e4, damping_ratio=0.2, gap_rad=0.05)
    torque = transmitted(motion, PLAIN, flanks)
    first = int(np.flatnonzero(torque)[0])
    assert motion.t[first] == pytest.approx(1.0 + 0.01 / 0.3, abs=STEP_S)
    assert torque[first] < 0.0
    rebound = 0.3 + np.cumsum(torque)[first + 20] * STEP_S / 0.2
    assert -0.3 < rebound < -0.1


@settings(max_examples=20, deadline=None)
@given(st.floats(0.0, 0.05), st.floats(50.0, 5e3), st.floats(0.3, 2.0), st.floats(0.0, 3.0))
def test_no_transmission_gives_energy(gap: float, stiffness: float, hertz: float, soft: float) -> None:
    motion = sine(0.2, hertz, 10.0)
    link = Transmission(stiffness_nm_per_rad=stiffness, damping_ratio=0.1, gap_rad=gap, soft_nm=soft)
    work = np.sum(transmitted(motion, RUBBING, link) * motion.dq) * STEP_S
    at_the_start = 0.5 * RUBBING.inertia_kg_m2 * motion.dq[0] ** 2
    assert work + at_the_start > 0.0


@pytest.mark.parametrize("inertia", [1e-3, 1e-6, 1e-12])
@pytest.mark.parametrize("soft", [0.0, 1e-3])
def test_a_far_side_of_hardly_any_inertia_does_not_run_away(inertia: float, soft: float) -> None:
    far = FrictionSide(inertia_kg_m2=inertia, coulomb_nm=0.3, viscous_nms_per_rad=0.03)
    spring = Transmission(stiffness_nm_per_rad=1e5, damping_ratio=0.05, soft_nm=soft)
    assert np.abs(added_torque(sine(0.5, 0.7), far, spring)).max() < 2.0 * far.coulomb_nm + 0.01


def seen(torque: Float) -> Float:
    """Low-passed, half of the amplitude at 25 Hz, ends left out."""
    window = np.hanning(17)
    return np.asarray(np.convolve(torque, window / window.sum(), mode="same")[200:-200])


def correlation(one: Float, other: Float) -> float:
    return float(one @ other / np.sqrt((one @ one) * (other @ other)))


@pytest.mark.parametrize("times", [1.0, 2.0])
def test_a_light_far_side_that_rings_faster_than_is_followed_looks_the_same(
    times: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    far, motion = replace(RUBBING, inertia_kg_m2=2e-3), sine(0.5, 0.7)
    stiffness = far.inertia_kg_m2 * (2 * np.pi * times * HIGHEST_HZ) ** 2
    spring = Transmission(stiffness_nm_per_rad=stiffness, damping_ratio=0.05)
    followed = seen(added_torque(motion, far, spring))
    monkeypatch.setattr(transmission, "HIGHEST_HZ", np.inf)
    exact = seen(added_torque(motion, far, spring))
    assert correlation(exact, followed) > 0.97
    assert np.sqrt(np.mean(followed**2)) == pytest.approx(np.sqrt(np.mean(exact**2)), rel=0.2)


@pytest.mark.parametrize("soft", [0.0, 0.5])
def test_a_steady_load_only_twists_a_spring(soft: float) -> None:
    motion = stopping()
    link = Transmission(stiffness_nm_per_rad=500.0, damping_ratio=0.1, soft_nm=soft)
    borne = transmitted(replace(motion, load=np.full(len(motion.t), 5.0)), RUBBING, link)
    # Far from zero torque a spring that is soft at first is as stiff as any.
    straight = transmitted(motion, RUBBING, replace(link, soft_nm=0.0))
    assert_allclose(borne, straight, atol=1e-9)


def test_where_a_load_changes_its_side_the_far_side_crosses_the_gap() -> None:
    motion = ramp(0.0, 0.5, speed=0.05)
    far, gap = replace(RUBBING, inertia_kg_m2=1e-3), 0.02
    flanks = Transmission(stiffness_nm_per_rad=1e4, damping_ratio=0.2, gap_rad=gap)
    load = 5.0 - 20.0 * motion.q
    whole = transmitted(replace(motion, load=load), far, flanks) + load
    crossing = np.abs(whole) < 0.01
    # Friction, 0.405 N m, is borne by one flank until the load is less than that on the other side.
    assert motion.q[np.flatnonzero(crossing)[0]] == pytest.approx((5.0 + 0.405) / 20.0, abs=2e-3)
    assert np.all(whole[-200:] < 0.0)


def test_a_spring_that_stiffens_up_to_3_nm_by_hand() -> None:
    """Half as stiff without torque; at the twist at which a straight spring has 4 N m it has 3, and is whole."""
    spring = hardening(3.0)
    straight = np.array([0.0, 2.0, 4.0, 6.0, -2.0, -6.0])
    assert [spring_torque(one, *spring) for one in straight] == pytest.approx([0.0, 1.25, 3.0, 5.0, -1.25, -5.0])
    slopes = [(spring_torque(at + 1e-6, *spring) - spring_torque(at, *spring)) / 1e-6 for at in (0.0, 2.0, 4.0, 9.0)]
    assert slopes == pytest.approx([0.5, 0.75, 1.0, 1.0], abs=1e-5)
    assert spring_torque(-0.7, *hardening(0.0)) == -0.7
