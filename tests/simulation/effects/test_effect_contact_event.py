import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.slow_and_events import (
    DRAG,
    KNOCK,
    STEP,
    ContactEvent,
    contact_event_nm,
    count_begun,
    draw_events,
)
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(ContactEvent.forms))
EVENTS = np.array([[1.0, 0.2, 2.0], [5.0, 0.4, -3.0], [5.1, 0.1, 1.0]])


def torque(t: float, velocity: float, form: int, events: Float = EVENTS) -> float:
    return contact_event_nm(pack([ContactEvent(torque_nm=1.0, form=form)])[0], events, t, velocity)


def test_a_knock_is_half_a_sine() -> None:
    assert torque(1.0, 0.0, KNOCK) == 0.0
    assert torque(1.05, 0.0, KNOCK) == pytest.approx(2.0 * np.sqrt(0.5))
    assert torque(1.1, 0.0, KNOCK) == pytest.approx(2.0)
    assert torque(1.3, 0.0, KNOCK) == 0.0


def test_a_step_is_there_and_gone_and_steps_add_up() -> None:
    assert [torque(t, 0.0, STEP) for t in (0.99, 1.0, 1.19, 1.21)] == [0.0, 2.0, 2.0, 0.0]
    assert [torque(t, 0.0, STEP) for t in (5.05, 5.15, 5.25, 5.45)] == [-3.0, -2.0, -3.0, 0.0]


@pytest.mark.parametrize("velocity", [-1.0, -0.01, 0.01, 1.0])
def test_a_drag_takes_energy_whatever_its_sign(velocity: float) -> None:
    for t in (1.1, 5.05):
        assert torque(t, velocity, DRAG) * velocity < 0.0
    assert torque(1.1, 0.05, DRAG) == pytest.approx(-1.0)
    assert torque(1.1, 0.0, DRAG) == 0.0


@pytest.mark.parametrize("form", FORMS)
def test_without_events_there_is_no_torque(form: int) -> None:
    assert torque(1.1, 0.5, form, np.zeros((0, 3))) == 0.0
    assert torque(1.1, 0.5, form, np.array([[np.inf, 0.0, 0.0]])) == 0.0


@unhurried
@given(seed=st.integers(0, 2**31), duration=st.floats(1.0, 300.0), per_minute=st.floats(0.1, 60.0))
def test_events_are_ordered_short_and_over_before_the_end(seed: int, duration: float, per_minute: float) -> None:
    group = ContactEvent(torque_nm=0.5, per_minute=per_minute)
    start, length, size = draw_events(group, duration, np.random.default_rng(seed)).T
    assert len(start) >= 1
    assert np.all(np.diff(start) >= 0.0)
    assert np.all(start >= 0.0)
    assert np.all(start + length <= duration + 1e-9)
    assert np.all((length >= 0.05) & (length <= 0.5))
    assert np.all((np.abs(size) > 0.0) & (np.abs(size) <= 5.0 * 0.5))


def test_many_events_have_the_median_told_a_heavy_tail_and_both_signs() -> None:
    group = ContactEvent(torque_nm=0.5, per_minute=60.0, length_s=0.2)
    _, length, size = draw_events(group, 60_000.0, np.random.default_rng(1)).T
    assert len(size) == pytest.approx(60_000, rel=0.02)
    assert np.median(np.abs(size)) == pytest.approx(0.5, rel=0.02)
    assert np.median(length) == pytest.approx(0.2, rel=0.02)
    assert np.mean(np.abs(size) > 1.5) == pytest.approx(1.0 / 18.0, rel=0.1)  # Pareto: 1/2 (1/3)^2
    assert np.mean(size > 0.0) == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("group", [ContactEvent(), ContactEvent(torque_nm=1.0, per_minute=0.0)])
def test_nothing_hidden_draws_nothing(group: ContactEvent) -> None:
    assert draw_events(group, 60.0, np.random.default_rng(0)).shape == (0, 3)


def test_an_event_as_long_as_the_recording_fits() -> None:
    start, length, _ = draw_events(ContactEvent(torque_nm=1.0), 0.04, np.random.default_rng(0))[0]
    assert (start, length) == (0.0, 0.04)


@unhurried
@given(st.lists(st.floats(0.0, 100.0)), st.floats(0.0, 100.0))
def test_bisection_counts_as_a_count_does(starts: list[float], t: float) -> None:
    events = np.zeros((len(starts), 3))
    events[:, 0] = sorted(starts)
    assert count_begun(events, t) == sum(start <= t for start in starts)


@pytest.mark.parametrize("form", FORMS)
def test_overlapping_events_add_up_as_their_sum_does(form: int) -> None:
    group = ContactEvent(torque_nm=1.0, per_minute=600.0, length_s=0.4, form=form)
    events = draw_events(group, 5.0, np.random.default_rng(3))
    for t in np.linspace(0.0, 5.0, 101):
        alone = [torque(t, 0.3, form, event[np.newaxis]) for event in events]
        assert torque(t, 0.3, form, events) == pytest.approx(sum(alone))
