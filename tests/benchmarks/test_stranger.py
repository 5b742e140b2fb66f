"""Physics of the second generator, where it is known by hand."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.stranger.draw import TOLERANCE, draw_case
from benchmarks.stranger.joint import STEP_S, Drive, Joint, integrate
from benchmarks.stranger.motions import MOTIONS, times
from benchmarks.stranger.run import write_log
from benchmarks.stranger.sensors import Sensors, clock_of, coloured, read_torque, record

pytestmark = pytest.mark.thorough  # to compile its loop takes as long as all other benchmarks' tests
FIRM = Drive(3000.0, 60.0, 1.0)


def moved(joint: Joint, wanted: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """A motion under a firm drive."""
    return integrate(joint, FIRM, wanted, np.ones(wanted.size))


@pytest.mark.parametrize("speed", [-0.6, 0.05, 0.8])
def test_steady_sliding_takes_the_curve_of_stribeck(speed: float) -> None:
    joint = Joint(coulomb=0.3, viscous=0.07, stribeck=0.15, stribeck_speed=0.1, stribeck_exponent=2.0)
    _, _, torque, _ = moved(joint, speed * times(1.5))
    expected = np.sign(speed) * (0.3 + 0.15 * np.exp(-((speed / 0.1) ** 2))) + 0.07 * speed
    assert torque[-1] == pytest.approx(expected, abs=1e-3)


def test_a_joint_sticks_below_coulomb_friction_and_leaves_above_it() -> None:
    pull = 0.5 * times(1.0)  # [N m], by a spring so soft that the joint's motion does not count
    theta, omega, _, _ = integrate(Joint(coulomb=0.3), Drive(1e-3, 0.0, 0.0), 1e3 * pull, np.ones(pull.size))
    assert np.abs(theta[pull < 0.29]).max() < 5e-6
    assert abs(omega[pull < 0.29]).max() < 1e-3
    assert omega[-1] > 0.1


def test_slipping_springs_lose_the_area_of_their_loop() -> None:
    joint = Joint(coulomb=0.02, viscous=0.0, soft=0.4, soft_reach_rad=0.01)
    wanted = 0.1 * np.sin(2 * np.pi * 0.5 * times(4.0))
    theta, _, torque, _ = moved(joint, wanted)
    loop = slice(round(2.0 / STEP_S), None)
    work = np.trapezoid(torque[loop], theta[loop])
    amplitude = 0.5 * np.ptp(theta[loop])
    reaches = 0.01 * np.arange(1, 7) / 6
    assert work == pytest.approx(4 * 0.02 * amplitude + np.sum(4 * (0.4 / 6) * (amplitude - reaches)), rel=0.01)


def test_two_masses_ring_at_their_frequency() -> None:
    joint = Joint(inertia=0.2, coulomb=0.02, viscous=0.0, spring_hz=12.0, motor_share=0.25, spring_damping=0.01)
    kick = np.where(times(2.0) < 0.02, 1e4, 0.0)  # 10 N m for 20 ms, then let go
    _, _, _, sprung = integrate(joint, Drive(1e-3, 0.0, 0.0), kick, np.ones(kick.size))
    spectrum = np.abs(np.fft.rfft(sprung - sprung.mean()))
    hertz = np.fft.rfftfreq(sprung.size, STEP_S)[spectrum.argmax()]
    assert hertz == pytest.approx(12.0 * np.sqrt(1 + 1 / 0.25), abs=0.6)


def test_a_gap_gives_no_torque_until_it_is_crossed() -> None:
    joint = Joint(coulomb=0.3, spring_hz=30.0, gap_rad=0.02)
    theta, _, _, sprung = moved(joint, 0.1 * np.sin(2 * np.pi * 0.2 * times(2.5)))
    after = theta.argmax()
    crossed = theta[after] - theta[after:]
    met = np.argmax(sprung[after:] < -0.01)
    assert crossed[met] == pytest.approx(0.02, abs=1e-3)
    assert np.abs(sprung[after : after + met][crossed[:met] > 1e-3]).max() < 0.01


def test_a_late_sensor_gives_what_was() -> None:
    torque = np.sin(2 * np.pi * times(1.0))
    late = read_torque(torque, Sensors(torque_late_s=0.005), np.random.default_rng(0))
    assert late[5000:] == pytest.approx(torque[4950:-50], abs=1e-9)


def test_noise_has_its_size_and_its_memory() -> None:
    sensors = Sensors(torque_noise_nm=0.05, noise_memory_s=0.02)
    noise = coloured(400_000, 1e-3, sensors, np.random.default_rng(1))
    assert noise.std() == pytest.approx(0.05, rel=0.03)
    assert np.corrcoef(noise[:-20], noise[20:])[0, 1] == pytest.approx(np.exp(-1), abs=0.03)


@pytest.mark.parametrize("kind", ["steady", "late_stamps", "late_samples", "batches"])
def test_stamps_go_forward_and_few_samples_are_lost(kind: str) -> None:
    clock = clock_of(Sensors(clock=kind, lost=0.02), 20.0, np.random.default_rng(2))
    assert np.all(np.diff(clock.stamps) > 0.0)
    assert 1 - clock.arrives.mean() == pytest.approx(0.02, abs=0.004)


def test_positions_are_whole_counts() -> None:
    theta = 0.3 * np.sin(times(3.0))
    sensors, rng = Sensors(encoder_bits=14), np.random.default_rng(3)
    made = record(theta, np.gradient(theta, STEP_S), theta, sensors, clock_of(sensors, 3.0, rng), rng)
    counts = made.q / (2 * np.pi / 2**14)
    assert counts == pytest.approx(np.round(counts), abs=1e-6)


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_begin_at_rest_and_stay_within_what_an_arm_does(name: str) -> None:
    wanted, grip = MOTIONS[name](np.random.default_rng(4), 20.0)
    speed = np.gradient(wanted, STEP_S)
    assert wanted.shape == grip.shape == (200_000,)
    assert abs(speed[0]) < 0.01
    assert 0.5 < np.abs(speed).max() < 4.0
    assert 0.0 <= grip.min() <= grip.max() <= 1.0 + 1e-9


def test_a_hidden_effect_has_the_size_that_was_asked_for_and_is_written(tmp_path: Path) -> None:
    case = draw_case(2, ("inertia_error",), 1.0, duration_s=10.0)
    assert case is not None
    assert case.reached[0] == pytest.approx(1.0, rel=TOLERANCE)
    model = write_log(case, tmp_path / "log.csv")
    assert model is not None
    assert f"inertia_kg_m2 = {case.setup.declared_inertia}" in model.read_text()
    assert (tmp_path / "log.csv").read_text().startswith("time,q_1,dq_1,tau_interaction_1\n")


def test_friction_grows_with_what_the_gear_transmits() -> None:
    joint = Joint(coulomb=0.3, viscous=0.0, pendulum=5.0, load_share=0.05)
    theta, _, torque, _ = moved(joint, 0.3 * times(1.0))
    weight = 5.0 * np.sin(theta[-1] + 0.4)
    assert torque[-1] == pytest.approx((0.3 + 0.05 * weight) / (1 - 0.05), abs=2e-3)
