"""What changes in the course of a recording, and how it is recorded."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation.bench import BenchSettings, Operator, simulate_bench
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.sensors import TorqueBias, TorqueDrift
from friction_audit.simulation.effects.slow_and_events import (
    ABRUPT,
    AMBIENT,
    RAMP,
    SELF_HEATING,
    SETTLING,
    STEP,
    ContactEvent,
    FrictionStep,
    WarmUp,
    draw_events,
)
from friction_audit.simulation.motion import Sinusoid
from friction_audit.simulation.settings import IDEAL_SENSORS, Sensors, make_streams
from friction_audit.simulation.simulation import TrueMotion

SEED = 6
PLAIN = BenchSettings(duration_s=12.0)
IDEAL = replace(PLAIN, sensors=(IDEAL_SENSORS,), operator=Operator(motion=Sinusoid()))


def truth(hidden: Hidden, settings: BenchSettings = IDEAL) -> TrueMotion:
    return simulate_bench(replace(settings, hidden=(hidden,)), SEED).truth.motion


@pytest.mark.parametrize("rate", [1000.0, 500.0, 300.0, 250.0, 100.0])
def test_a_lower_rate_picks_the_ticks_nearest_to_its_own(rate: float) -> None:
    simulation = simulate_bench(replace(IDEAL, rate_hz=rate), SEED)
    log, motion = simulation.log, simulation.truth.motion
    ticks = np.rint(np.arange(int(12.0 * rate) + 1) * 1000.0 / rate).astype(int)
    assert len(motion.t) == 12_001
    assert_array_equal(log.q, motion.q[ticks])
    assert_allclose(log.t, ticks * 1e-3, atol=1e-9)


def test_stale_samples_repeat_the_one_before_and_lost_ones_leave_a_gap() -> None:
    """Every sample is the state of a tick not after its stamp; a lost tick is in no sample."""
    sensors = Sensors(stale=0.1, lost=0.05)
    simulation = simulate_bench(replace(IDEAL, sensors=(sensors,)), SEED)
    log, motion = simulation.log, simulation.truth.motion
    own = np.rint(log.t * 1e3).astype(int)
    assert len(own) == 12_001 - round(0.05 * 12_001)
    moving = np.abs(motion.dq[own, 0]) > 0.01
    fresh = log.q[:, 0] == motion.q[own, 0]
    repeats = np.concatenate([[False], log.q[1:, 0] == log.q[:-1, 0]])
    assert (fresh | repeats)[moving].all()
    assert_allclose(repeats[moving].mean(), 0.1, atol=0.02)
    assert np.diff(own).max() >= sensors.longest_loss + 1
    assert log.tau_interaction is not None
    together = np.diff(log.dq[:, 0]) == 0.0
    assert_array_equal(together[moving[1:]], (np.diff(log.tau_interaction[:, 0]) == 0.0)[moving[1:]])


def test_bias_and_drift_add_up_in_the_torque_and_nowhere_else() -> None:
    plain = simulate_bench(IDEAL, SEED)
    hidden = Hidden(torque_bias=TorqueBias(torque_nm=0.15), torque_drift=TorqueDrift(torque_nm=0.3))
    shifted = simulate_bench(replace(IDEAL, hidden=(hidden,)), SEED)
    assert plain.log.tau_interaction is not None
    assert shifted.log.tau_interaction is not None
    added = (shifted.log.tau_interaction - plain.log.tau_interaction)[:, 0]
    assert_allclose(added, 0.15 + 0.3 * plain.log.t / 12.0, atol=1e-12)
    assert_array_equal(shifted.log.dq, plain.log.dq)


def test_ambient_warmth_has_its_time_constant_and_lowers_friction() -> None:
    """Warmth 1 - exp(-t/T); viscous friction (1 - r)^warmth, Coulomb 1 / (1 + warmth l / (1 - l)) of the cold one."""
    motion = truth(Hidden(warm_up=WarmUp(reduction=0.5, coulomb_ratio=0.5, time_s=4.0, form=AMBIENT)))
    assert_allclose(motion.warmth[1:, 0], -np.expm1(-motion.t[:-1] / 4.0), atol=3e-4)
    moving = motion.dq != 0.0
    coulomb = 0.30 / (1.0 + motion.warmth * 0.25 / 0.75)
    viscous = 0.07 * 0.5**motion.warmth
    assert_allclose(motion.friction_nm[moving], (coulomb * np.sign(motion.dq) + viscous * motion.dq)[moving], atol=3e-5)


def test_self_heating_follows_the_friction_power() -> None:
    """T dw/dt = P / P_warm - w, integrated from the truth's own friction power."""
    motion = truth(Hidden(warm_up=WarmUp(reduction=0.5, time_s=4.0, power_w=0.2, form=SELF_HEATING)))
    power = (motion.friction_nm * motion.dq)[:, 0]
    warmth = np.zeros_like(power)
    for k in range(len(power) - 1):
        warmth[k + 1] = warmth[k] + (power[k] / 0.2 - warmth[k]) * 1e-3 / 4.0
    assert warmth.max() > 0.3
    assert_allclose(motion.warmth[1:, 0], warmth[:-1], atol=2e-3)


@pytest.mark.parametrize("form", [ABRUPT, RAMP, SETTLING])
def test_friction_steps_at_its_moment(form: int) -> None:
    motion = truth(Hidden(friction_step=FrictionStep(change=0.5, at_share=0.4, length_s=2.0, form=form)))
    moving = motion.dq[:, 0] != 0.0
    plain = 0.30 * np.sign(motion.dq[:, 0]) + 0.07 * motion.dq[:, 0]
    ratio = (motion.friction_nm[:, 0] / np.where(moving, plain, 1.0))[moving]
    since = motion.t[moving] - 4.8
    course = {ABRUPT: np.ones_like(since), RAMP: np.minimum(since / 2.0, 1.0), SETTLING: -np.expm1(-since / 2.0)}[form]
    clear = np.abs(since) > 1e-6
    assert_allclose(ratio[clear], (1.0 + 0.5 * np.where(since < 0.0, 0.0, course))[clear], atol=1e-9)


def test_contacts_come_when_they_were_drawn() -> None:
    """A step load behind the sensor is what B ddq - F_m + tau_f leaves over."""
    group = ContactEvent(torque_nm=0.5, per_minute=30.0, form=STEP)
    motion = truth(Hidden(contact_event=group))
    events = draw_events(group, 12.0, make_streams(SEED, 1).events[0])
    expected = np.zeros_like(motion.t)
    for start, length, size in events:
        expected[(motion.t >= start) & (motion.t < start + length)] += size
    left = (0.3 * motion.inner_ddq - motion.interaction_nm + motion.friction_nm)[:, 0]
    assert len(events) >= 3
    assert_allclose(left, expected, atol=1e-9)
