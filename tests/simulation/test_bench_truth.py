"""What truly happens on the bench is what a textbook says: friction, the torque at the sensor, slow effects."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import cumulative_trapezoid

from friction_audit.joint_log import Float
from friction_audit.simulation import bench
from friction_audit.simulation.bench import BenchSettings, HandGuidedPanda, Operator
from friction_audit.simulation.effects import Hidden, load_and_place, slow_and_events as slow, velocity
from friction_audit.simulation.effects.sensors import TorqueBias
from friction_audit.simulation.effects.structure import Backlash, JointElasticity
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import IDEAL_SENSORS, JointParameters, Sensors, TrueMotion, make_streams

# Friction in the truth is the law as written in a textbook, at the motion that there was.

SEED = 2
IDEAL = BenchSettings(duration_s=8.0, sensors=(IDEAL_SENSORS,), operator=Operator(motion=Sinusoid(period_s=2.0)))


def truth(hidden: Hidden) -> TrueMotion:
    return simulate(replace(IDEAL, hidden=(hidden,)), SEED).truth.motion


def dry(motion: TrueMotion, coulomb: Any = 1.0, viscous: Any = 1.0) -> Float:
    """Return Coulomb and viscous friction of the joint, each times a factor."""
    return np.asarray(coulomb * 0.30 * np.sign(motion.dq) + viscous * 0.07 * motion.dq)


ALL = Hidden(
    stribeck=velocity.Stribeck(excess_nm=0.15, form=velocity.LORENTZIAN),
    position_dependent_friction=load_and_place.PositionDependentFriction(share=0.4),
    nonlinear_viscous=velocity.NonlinearViscous(torque_nm=0.15, form=velocity.CUBIC),
    load_dependent_friction=load_and_place.LoadDependentFriction(share=0.06),
    asymmetric_coulomb=velocity.AsymmetricCoulomb(half_difference_nm=0.05),
    asymmetric_viscous=velocity.AsymmetricViscous(half_difference_nms_per_rad=0.02),
)


def all_at_once(motion: TrueMotion) -> Float:
    speed, sign, before = np.abs(motion.dq), np.sign(motion.dq), np.vstack([motion.port_nm[:1], motion.port_nm[:-1]])
    level = (0.30 + 0.15 / (1.0 + (speed / 0.1) ** 2)) * (1.0 + 0.4 * np.sin(3.0 * motion.q + 0.5))
    level = level + 0.06 * np.abs(before) + 0.15 * speed**3 + sign * (0.05 + 0.02 * speed)
    return np.asarray(sign * (level + 0.07 * speed))


def late(motion: TrueMotion) -> Float:
    speed = np.abs(motion.dq)
    return np.asarray(np.sign(motion.dq) * (0.30 + 0.07 * np.vstack([np.zeros((30, 1)), speed[:-30]])))


def warming(motion: TrueMotion) -> Float:
    """Warmth 1 - exp(-t/T); viscous friction (1 - r)^warmth, Coulomb 1 / (1 + warmth l / (1 - l)) of the cold one."""
    assert_allclose(motion.warmth[1:, 0], -np.expm1(-motion.t[:-1] / 4.0), atol=3e-4)
    return dry(motion, 1.0 / (1.0 + motion.warmth * 0.25 / 0.75), 0.5**motion.warmth)


LAWS: dict[str, tuple[Hidden, Callable[[TrueMotion], Float], float]] = {
    "none": (Hidden(), dry, 1e-9),
    "all": (ALL, all_at_once, 1e-9),
    "late": (Hidden(frictional_lag=velocity.FrictionalLag(lag_s=0.03, form=velocity.DELAYED)), late, 1e-4),
    "warm": (Hidden(warm_up=slow.WarmUp(reduction=0.5, coulomb_ratio=0.5, time_s=4.0)), warming, 3e-5),
}


@pytest.mark.parametrize("name", LAWS)
def test_friction_of_what_slides_is_the_law_at_the_present_motion(name: str) -> None:
    hidden, law, error = LAWS[name]
    motion = truth(hidden)
    sliding = motion.dq != 0.0
    assert_allclose(motion.friction_nm[sliding], law(motion)[sliding], atol=error)


def test_words_about_the_progress_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The loop is left and entered again; nothing of it is lost on the way."""
    whole = truth(ALL)
    monkeypatch.setattr(bench, "CHUNK_TICKS", 777)
    parts = truth(ALL)
    assert_array_equal(whole.q, parts.q)
    assert_array_equal(whole.port_nm, parts.port_nm)


def test_a_motor_cogs_on_its_own_side_of_the_sensor() -> None:
    """A hand feels it through friction's side; where the motor drives, it reaches the link through the sensor."""
    hidden = Hidden(torque_ripple=load_and_place.TorqueRipple(torque_nm=0.1, cycles_per_rev=60.0, second_share=0.0))
    for driven in (False, True):
        settings = replace(IDEAL, hidden=(hidden,), logs_sensor=True, driven=driven)
        motion = simulate(settings, SEED).truth.motion
        left = 0.3 * motion.inner_ddq + motion.friction_nm - motion.interaction_nm
        cogging = 0.1 * np.sin(60.0 * motion.q)
        assert_allclose(left, np.zeros_like(left) if driven else cogging, atol=1e-9)


# The sensor reads what passes through it: computed once more from the hand's side, or from the link's.

PORT_SEED = 3
PORT_IDEAL = BenchSettings(duration_s=12.0, sensors=(IDEAL_SENSORS,))
GRAVITY_NM, PHASE_RAD = 8.0, 0.4
LOADED = replace(PORT_IDEAL, logs_sensor=True, gravity_nm=GRAVITY_NM, gravity_phase_rad=PHASE_RAD)

HIDDEN = {
    "rigid": Hidden(),
    "elastic": Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=1e-3)),
    "backlash": Hidden(backlash=Backlash(gap_rad=5e-3)),
    "presliding": Hidden(presliding=velocity.Presliding(displacement_rad=0.005)),
    "stiction": Hidden(stiction=velocity.Stiction(excess_nm=0.2)),
}


@pytest.mark.parametrize("name", HIDDEN)
def test_interaction_torque_is_what_the_hand_exerts_less_its_own_inertia(name: str) -> None:
    """In impulses: integral F_m dt = integral of the hand's spring and damper - m_hand dq, at every tick."""
    settings = replace(PORT_IDEAL, hidden=(HIDDEN[name],))
    simulation = simulate(settings, PORT_SEED)
    log = simulation.log
    q, dq, hand = log.q[:, 0], log.dq[:, 0], settings.operator
    wanted = hand.motion.reference(len(q) - 1, 1e-3, make_streams(PORT_SEED, 1).person)
    drive = hand.stiffness_nm_per_rad * (wanted.position - q) + hand.damping_nms_per_rad * (wanted.velocity - dq)
    expected = cumulative_trapezoid(drive, log.t, initial=0) - hand.inertia_kg_m2 * dq
    sensor = cumulative_trapezoid(log.channels()["tau_interaction"][:, 0], log.t, initial=0)
    assert np.ptp(sensor) > 0.5
    ringing = name in ("elastic", "backlash")
    assert_allclose(sensor, expected, atol=5e-3 if ringing else 5e-4)


@pytest.mark.parametrize("name", ["rigid", "elastic", "presliding"])
def test_sensor_of_a_driven_joint_carries_inertia_gravity_and_friction_of_the_link(name: str) -> None:
    """tau_J = J ddq + g(q) + tau_f."""
    settings = replace(LOADED, driven=True, hidden=(HIDDEN[name],))
    simulation = simulate(settings, PORT_SEED)
    log, motion = simulation.log, simulation.truth.motion
    link = 0.3 * motion.inner_ddq + GRAVITY_NM * np.sin(log.q + PHASE_RAD) + motion.friction_nm
    assert_allclose(log.channels()["tau_J"], link, atol=2e-3)
    sliding = (motion.inner_dq != 0.0) & (name != "presliding")
    law = 0.30 * np.sign(motion.inner_dq) + 0.07 * motion.inner_dq
    assert_allclose(motion.friction_nm[sliding], law[sliding], atol=1e-12)
    assert_allclose(log.q, motion.inner_q)


# What changes in the course of a recording, and how it is recorded.

SLOW_SEED = 6
SLOW_IDEAL = BenchSettings(duration_s=12.0, sensors=(IDEAL_SENSORS,), operator=Operator(motion=Sinusoid()))


@pytest.mark.parametrize("rate", [1000.0, 500.0, 300.0, 250.0, 100.0])
def test_a_lower_rate_picks_the_ticks_nearest_to_its_own(rate: float) -> None:
    simulation = simulate(replace(SLOW_IDEAL, rate_hz=rate), SLOW_SEED)
    log, motion = simulation.log, simulation.truth.motion
    ticks = np.rint(np.arange(int(12.0 * rate) + 1) * 1000.0 / rate).astype(int)
    assert len(motion.t) == 12_001
    assert_array_equal(log.q, motion.q[ticks])
    assert_allclose(log.t, ticks * 1e-3, atol=1e-9)


def test_stale_samples_repeat_the_one_before_and_lost_ones_leave_a_gap() -> None:
    """Every sample is the state of a tick not after its stamp; a lost tick is in no sample."""
    sensors = Sensors(stale=0.1, lost=0.05)
    simulation = simulate(replace(SLOW_IDEAL, sensors=(sensors,)), SLOW_SEED)
    log, motion = simulation.log, simulation.truth.motion
    own = np.rint(log.t * 1e3).astype(int)
    assert len(own) == 12_001 - round(0.05 * 12_001)
    moving = np.abs(motion.dq[own, 0]) > 0.01
    fresh = log.q[:, 0] == motion.q[own, 0]
    repeats = np.concatenate([[False], log.q[1:, 0] == log.q[:-1, 0]])
    assert (fresh | repeats)[moving].all()
    assert_allclose(repeats[moving].mean(), 0.1, atol=0.02)
    assert np.diff(own).max() >= sensors.longest_loss + 1
    together = np.diff(log.dq[:, 0]) == 0.0
    assert_array_equal(together[moving[1:]], (np.diff(log.channels()["tau_interaction"][:, 0]) == 0.0)[moving[1:]])


def test_contacts_come_when_they_were_drawn() -> None:
    """A step load behind the sensor is what B ddq - F_m + tau_f leaves over."""
    group = slow.ContactEvent(torque_nm=0.5, per_minute=30.0, form=slow.STEP)
    motion = simulate(replace(SLOW_IDEAL, hidden=(Hidden(contact_event=group),)), SLOW_SEED).truth.motion
    events = slow.draw_events(group, 12.0, make_streams(SLOW_SEED, 1).events[0])
    expected = np.zeros_like(motion.t)
    for start, length, size in events:
        expected[(motion.t >= start) & (motion.t < start + length)] += size
    left = (0.3 * motion.inner_ddq - motion.interaction_nm + motion.friction_nm)[:, 0]
    assert len(events) >= 3
    assert_allclose(left, expected, atol=1e-9)


# One joint of a Panda.

JOINT = JointParameters()
PANDA = HandGuidedPanda(joint=4, joints=(JOINT,) * 7, duration_s=5.0)
IDEAL_PANDA = replace(PANDA, sensors=(IDEAL_SENSORS,) * 7)
OTHERS = (0, 1, 2, 4, 5, 6)


def hide(joint: int, hidden: Hidden) -> tuple[Hidden, ...]:
    return tuple(hidden if number == joint else Hidden() for number in range(1, 8))


def test_sensor_reads_gravity_less_the_interaction_torque() -> None:
    simulation = simulate(IDEAL_PANDA, 1)
    log, motion = simulation.log, simulation.truth.motion
    interaction = log.channels()["gravity"] - log.channels()["tau_J"]
    # The motor holds the gravity of where the joint would be without acceleration since the middle of the tick.
    assert_allclose(interaction[:, 3], motion.interaction_nm[:, 3], atol=2e-5)
    assert_allclose(interaction[:, OTHERS], 0.0, atol=1e-6)
    assert np.ptp(log.channels()["gravity"][:, 1]) > 0.1


def test_motion_and_noise_are_those_of_the_single_joint() -> None:
    panda = simulate(PANDA, 2)
    bench = simulate(BenchSettings(joints=(JOINT,), sensors=(PANDA.sensors[3],), duration_s=5.0), 2)
    motion, alone = panda.truth.motion, bench.truth.motion
    assert_allclose(motion.dq[:, 3], alone.dq[:, 0], atol=1e-9)
    assert_allclose(motion.q[:, 3] - motion.q[0, 3], alone.q[:, 0], atol=1e-9)
    assert_array_equal(panda.log.t, bench.log.t)
    assert_allclose(panda.log.dq[:, 3], bench.log.dq[:, 0], atol=1.5e-6)
    noise = [simulate(PANDA, seed).log.dq[:500, 0] for seed in (2, 2, 3)]
    assert_array_equal(noise[0], noise[1])
    assert (noise[0] != noise[2]).mean() > 0.9


def test_faults_of_the_sensors_are_those_of_every_joint() -> None:
    wrong = (
        Hidden(),
        Hidden(torque_bias=TorqueBias(torque_nm=0.2)),
        Hidden(gravity_error=load_and_place.GravityError(torque_nm=0.4)),
    )
    logs = (simulate(replace(IDEAL_PANDA, hidden=hide(2, one)), 7).log for one in wrong)
    clean, biased, tilted = (log.channels() for log in logs)
    assert_allclose((biased["tau_J"] - clean["tau_J"])[:, 1], -0.2, atol=1e-9)
    error = 0.4 * np.sin(IDEAL_PANDA.pose_rad[1])
    assert_allclose((tilted["gravity"] - clean["gravity"])[:, 1], error, atol=2e-6)
    assert_array_equal(biased["dq"], clean["dq"])


def test_places_inside_the_joint_are_counted_from_its_zero_and_stops_from_the_start() -> None:
    rough = Hidden(position_dependent_friction=load_and_place.PositionDependentFriction(share=0.5))
    motion = simulate(replace(IDEAL_PANDA, hidden=hide(4, rough)), 9).truth.motion
    dq, moving = motion.dq[:, 3], motion.dq[:, 3] != 0
    level = (motion.friction_nm[:, 3] - JOINT.viscous_nms_per_rad * dq)[moving] * np.sign(dq[moving])
    assert_allclose(level, 0.3 * (1 + 0.5 * np.sin(3 * motion.q[moving, 3] + 0.5)), atol=1e-9)
    walled = Hidden(joint_limit_stop=load_and_place.JointLimitStop(stiffness_nm_per_rad=500.0, at_rad=0.1))
    stopped = simulate(replace(IDEAL_PANDA, hidden=hide(4, walled)), 9).truth.motion
    assert np.abs(stopped.q[:, 3] - IDEAL_PANDA.pose_rad[3]).max() < 0.3
