"""Contacts are found where they are, in noise of any autocorrelation time, and nothing else is taken for one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.api import diagnose_log
from friction_audit.diagnosis.contact_events import Contact, detect, touched, without_impulses
from friction_audit.diagnosis.noise import NoiseModel
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.samples import least_squares
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.simulation import BenchSettings, simulate
from friction_audit.simulation.effects.slow_and_events import draw_events
from friction_audit.simulation.hide import hide
from friction_audit.simulation.settings import make_streams
from tests.effects.joint_data_by_hand import baseline, joint_data, two_sines

MOTION = two_sines()


def noise(memory_s: float, seed: int = 3) -> Float:
    """AR(1) noise of standard deviation 0.02 N m."""
    kept = np.exp(-MOTION.step_s / memory_s)
    white = np.random.default_rng(seed).normal(size=len(MOTION.t))
    return np.asarray(0.02 * np.sqrt(1.0 - kept**2) * lfilter([1.0], [1.0, -kept], white))


def box(start_s: float, length_s: float, size_nm: float) -> Float:
    return np.where((MOTION.t >= start_s) & (MOTION.t < start_s + length_s), size_nm, 0.0)


def found(torque: Float, data: JointData = MOTION) -> tuple[Contact, ...]:
    problem = RegressionProblem.build(replace(data, torque=baseline(data).torque + torque), None)
    factors = least_squares(problem.X, problem.y)
    residual = problem.y - factors @ problem.X
    model_error = problem.model_error(problem.nominal.baseline(factors))
    return detect(problem, residual, NoiseModel.fit(problem.age, [residual], model_error))


@pytest.mark.parametrize("memory_s", [0.002, 0.02, 0.1])
@pytest.mark.parametrize("seed", [3, 4])
def test_noise_holds_none(memory_s: float, seed: int) -> None:
    assert found(noise(memory_s, seed)) == ()


@pytest.mark.parametrize(("length_s", "size_nm"), [(0.1, 0.2), (0.3, -0.1), (0.8, 0.1), (1.5, 0.3)])
def test_a_contact_is_found_where_it_is(length_s: float, size_nm: float) -> None:
    contacts = found(noise(0.01) + box(20.0, length_s, size_nm))
    assert contacts
    assert all(19.7 < one.start_s < one.stop_s < 20.3 + length_s for one in contacts)


def test_a_push_is_found_by_its_flanks_where_slow_noise_is_as_large_as_its_mean() -> None:
    slow, size_nm = noise(0.1), 0.1
    means = np.convolve(slow, np.ones(40) / 40.0, mode="valid")
    assert size_nm < 7.0 * np.std(means)
    (one,) = found(slow + box(30.0, 0.2, size_nm))
    assert one.start_s < 30.1 < one.stop_s


def test_an_impulse_of_a_sample_is_separated_from_a_push() -> None:
    problem, spike = RegressionProblem.build(MOTION, None), box(30.0, MOTION.step_s, 1.0)
    rest = noise(0.01) + box(20.0, 0.1, 0.2)
    seen = problem.samples.of(spike)
    for torque in (rest, rest + spike):
        left = problem.samples.of(torque)
        without = without_impulses(problem, left, torque)
        assert np.all(np.abs(without) <= np.abs(left))
        np.testing.assert_allclose(without, problem.samples.of(rest), atol=0.1 * np.max(seen))


def test_what_every_stroke_repeats_is_none() -> None:
    here = (np.abs(MOTION.q - 0.4) < 0.05) & (MOTION.dq > 0.0)
    assert found(noise(0.01) + 0.15 * here) == ()
    once = here & (np.abs(MOTION.t - 30.0) < 1.5)
    assert once.any()
    assert found(noise(0.01) + 0.15 * once) != ()


def test_a_smaller_push_during_similar_motion_is_not_its_repetition() -> None:
    w = 2.0 * np.pi / 20.0
    q, dq, ddq = np.sin(w * MOTION.t), w * np.cos(w * MOTION.t), -(w**2) * np.sin(w * MOTION.t)
    slow = joint_data(q, dq, ddq)
    contacts = found(noise(0.02) + box(20.0, 0.2, 0.3) + box(40.0, 0.2, 0.2), slow)
    assert [round(one.start_s) for one in contacts] == [20, 40]


def test_what_is_far_smaller_than_the_modelled_torque_may_be_its_error() -> None:
    brisk = np.where(np.abs(MOTION.t - 30.0) < 0.1, 1.0, 0.0)
    problem = RegressionProblem.build(replace(MOTION, torque=noise(0.01) + 0.2 * brisk), None)
    quiet = NoiseModel.fit(problem.age, [problem.y], np.zeros(len(problem.y)))
    assert detect(problem, problem.y, quiet)
    sudden = replace(problem, nominal=replace(problem.nominal, y=problem.y + problem.columns(20.0 * brisk[:, None])[0]))
    assert detect(sudden, problem.y, quiet) == ()


@pytest.mark.parametrize("start_s", [0.3, 59.5])
def test_nothing_is_looked_for_at_the_ends_of_the_log(start_s: float) -> None:
    assert found(noise(0.01) + box(start_s, 0.2, 0.5)) == ()


def test_what_comes_in_most_cycles_is_no_event() -> None:
    rng = np.random.default_rng(0)
    often = np.sum([box(float(s), 0.3, 0.3 * rng.choice([-1.0, 1.0])) for s in np.arange(2.0, 58.0, 1.3)], axis=0)
    assert found(noise(0.01) + often) == ()


def test_samples_that_the_filter_mixes_with_a_contact_are_touched() -> None:
    problem = RegressionProblem.build(replace(MOTION, torque=noise(0.01)), None)
    contact = Contact(start_s=20.0, stop_s=20.3)
    inside = touched(problem, (contact,))
    pushed = problem.columns(box(20.0, 0.3, 1.0)[:, None])[0]
    assert np.all(inside[np.abs(pushed) > 1e-9])
    assert not np.any(inside & (np.abs(problem.samples.t - 20.15) > 1.0))
    assert not touched(problem, ()).any()


# Contacts that the simulator hides in a stop-and-go motion are told, wherever they come, and only noise is left.

SEED = 3
BENCH = BenchSettings()
TOUCHED = hide(BENCH, ("contact_event",))
EVENTS = draw_events(TOUCHED.hidden[0].contact_event, BENCH.duration_s, make_streams(SEED, 1).events[0])
"""All of them stand out by 30 and more standard deviations; half turn the joint, stop it or set it in motion."""


def diagnosed(settings: BenchSettings) -> Any:
    asked = ("contact_event", "stribeck")
    (joint,) = diagnose_log(simulate(settings, SEED).log, candidates=asked).joints
    return joint


def test_every_event_is_left_out_and_what_is_left_is_that_of_an_untouched_joint() -> None:
    joint, clean = diagnosed(TOUCHED), diagnosed(BENCH)
    assert (joint.verdict, clean.verdict) == ("named", "adequate")
    assert joint.gap.after < 1.2 * clean.gap.after
    (effect,), trace, t = joint.effects, joint.contacts, joint.traces.t
    assert effect.parameters["contacts"].value <= len(EVENTS)
    assert effect.parameters["longest_contact_s"].value < 1.2
    # The sensor reads what holds against the push.
    largest = max((size for *_, size in EVENTS), key=abs)
    assert effect.parameters["largest_contact_nm"].value == pytest.approx(-largest, rel=0.3)
    assert all(any(low < start + 0.5 * length < high for start, length, _ in EVENTS) for low, high in trace.spans_s)
    away = np.ones(len(trace.t), bool)
    for start, length, _ in EVENTS:
        assert not np.any((t > start) & (t < start + length))
        away &= (trace.t < start - 0.5) | (trace.t > start + length + 0.5)
    assert float(np.nanstd(trace.residual_nm[away])) < 1.5 * joint.gap.floor
