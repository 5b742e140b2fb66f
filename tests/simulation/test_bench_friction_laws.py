"""Friction in the truth is the law as written in a textbook, at the motion that there was."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.signal import lfilter

from friction_audit.joint_log import Float
from friction_audit.simulation import bench
from friction_audit.simulation.bench import BenchSettings, Operator, simulate_bench
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.load_and_place import (
    LoadDependentFriction,
    PositionDependentFriction,
    TorqueRipple,
)
from friction_audit.simulation.effects.velocity import (
    CUBIC,
    DELAYED,
    LORENTZIAN,
    RELAXING,
    FrictionalLag,
    NonlinearViscous,
    Stribeck,
)
from friction_audit.simulation.motion import Sinusoid
from friction_audit.simulation.settings import IDEAL_SENSORS
from friction_audit.simulation.simulation import TrueMotion

SEED = 2
IDEAL = BenchSettings(duration_s=8.0, sensors=(IDEAL_SENSORS,), operator=Operator(motion=Sinusoid(period_s=2.0)))


def truth(hidden: Hidden) -> TrueMotion:
    return simulate_bench(replace(IDEAL, hidden=(hidden,)), SEED).truth.motion


def law(hidden: Hidden, motion: TrueMotion) -> Float:
    """Return the magnitude of friction by hand, shape (n + 1, 1)."""
    speed, level = np.abs(motion.dq), np.full_like(motion.dq, 0.30)
    if hidden.stribeck.excess_nm:
        level = level + 0.15 / (1.0 + (speed / 0.1) ** 2)
    if hidden.position_dependent_friction.share:
        level = level * (1.0 + 0.4 * np.sin(3.0 * motion.q + 0.5))
    if hidden.nonlinear_viscous.torque_nm:
        level = level + 0.15 * speed**3
    if hidden.load_dependent_friction.share:
        before = np.concatenate([motion.port_nm[:1], motion.port_nm[:-1]])
        level = level + 0.06 * np.abs(before)
    return np.asarray(level + 0.07 * speed)


LAWS = {
    "none": Hidden(),
    "stribeck": Hidden(stribeck=Stribeck(excess_nm=0.15, form=LORENTZIAN)),
    "position": Hidden(position_dependent_friction=PositionDependentFriction(share=0.4)),
    "cubic": Hidden(nonlinear_viscous=NonlinearViscous(torque_nm=0.15, form=CUBIC)),
    "load": Hidden(load_dependent_friction=LoadDependentFriction(share=0.06)),
}
LAWS["all"] = Hidden(
    stribeck=LAWS["stribeck"].stribeck,
    position_dependent_friction=LAWS["position"].position_dependent_friction,
    nonlinear_viscous=LAWS["cubic"].nonlinear_viscous,
    load_dependent_friction=LAWS["load"].load_dependent_friction,
)


@pytest.mark.parametrize("name", LAWS)
def test_sliding_friction_is_the_law_at_the_present_motion(name: str) -> None:
    motion = truth(LAWS[name])
    sliding = motion.dq != 0.0
    expected = np.sign(motion.dq) * law(LAWS[name], motion)
    assert_allclose(motion.friction_nm[sliding], expected[sliding], atol=1e-9)


@pytest.mark.parametrize("form", [RELAXING, DELAYED])
def test_lagging_friction_follows_the_speed_late(form: int) -> None:
    """A first-order low-pass of the speed, or the speed of 30 ms ago."""
    motion = truth(Hidden(frictional_lag=FrictionalLag(lag_s=0.03, form=form)))
    speed = np.abs(motion.dq[:, 0])
    if form == DELAYED:
        seen = np.concatenate([np.zeros(30), speed[:-30]])
    else:
        keep = np.exp(-1e-3 / 0.03)
        seen = lfilter([0.5 * (1.0 - keep), 0.5 * (1.0 - keep)], [1.0, -keep], speed)
    sliding = speed > 0.0
    assert_allclose(np.abs(motion.friction_nm[sliding, 0]), (0.30 + 0.07 * seen)[sliding], atol=1e-4)
    assert np.abs(seen - speed).max() > 0.05


def test_words_about_the_progress_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The loop is left and entered again; nothing of it is lost on the way."""
    whole = truth(LAWS["all"])
    monkeypatch.setattr(bench, "CHUNK_TICKS", 777)
    parts = truth(LAWS["all"])
    assert_array_equal(whole.q, parts.q)
    assert_array_equal(whole.port_nm, parts.port_nm)


def test_a_motor_cogs_on_its_own_side_of_the_sensor() -> None:
    """A hand feels it through friction's side; where the motor drives, it reaches the link through the sensor."""
    hidden = Hidden(torque_ripple=TorqueRipple(torque_nm=0.1, cycles_per_rev=60.0, second_share=0.0))
    for driven in (False, True):
        settings = replace(IDEAL, hidden=(hidden,), logs_sensor=True, driven=driven)
        motion = simulate_bench(settings, SEED).truth.motion
        left = 0.3 * motion.inner_ddq + motion.friction_nm - motion.interaction_nm
        cogging = 0.1 * np.sin(60.0 * motion.q)
        assert_allclose(left, np.zeros_like(left) if driven else cogging, atol=1e-9)
