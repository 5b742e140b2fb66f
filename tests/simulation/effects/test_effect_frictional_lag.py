import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.simulation.effects.velocity import (
    DELAYED,
    LAG_MEMORY,
    RELAXING,
    FrictionalLag,
    frictional_lag_speed,
)
from friction_audit.simulation.mechanics.records import pack

unhurried = settings(deadline=None)  # the first call compiles
FORMS = range(len(FrictionalLag.forms))
H = 1e-4


def seen(speeds: list[float], steps: list[float], **numbers: float) -> list[float]:
    group = pack([FrictionalLag(**numbers)])[0]  # type: ignore[arg-type]
    memory = np.zeros(LAG_MEMORY)
    return [frictional_lag_speed(group, memory, value, h) for value, h in zip(speeds, steps, strict=True)]


def test_relaxing_has_63_percent_of_a_jump_after_the_lag() -> None:
    assert seen([1.0] * 100, [H] * 100, lag_s=0.01, form=RELAXING)[-1] == pytest.approx(1.0 - math.exp(-1.0))


@pytest.mark.parametrize("lag", [0.0002, 0.0013, 0.02, 0.05])
def test_delayed_shows_a_sinusoid_as_it_was(lag: float) -> None:
    t = H * np.arange(1, 5001)
    late = seen(list(1.0 - np.cos(20.0 * t)), [H] * len(t), lag_s=lag, form=DELAYED)
    np.testing.assert_allclose(late, 1.0 - np.cos(20.0 * np.maximum(0.0, t - lag)), atol=2e-5)


@unhurried
@given(steps=st.lists(st.floats(0.0, 3e-3), min_size=1, max_size=200), lag=st.floats(1e-4, 0.05))
def test_delayed_is_exact_on_a_ramp_whatever_the_steps(steps: list[float], lag: float) -> None:
    t = np.cumsum(steps)
    late = np.array(seen(list(3.0 * t), steps, lag_s=lag, form=DELAYED))
    # the corner of the ramp at t = 0 is a sample, so that only times before the start differ from a line
    np.testing.assert_allclose(late, 3.0 * np.maximum(0.0, t - lag), atol=1e-9)


def test_delayed_shows_a_jump_after_the_lag_to_half_a_millisecond() -> None:
    late = seen([1.0] * 400, [H] * 400, lag_s=0.03, form=DELAYED)
    assert max(late[:294]) == 0.0
    assert min(late[305:]) == 1.0


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(
    speeds=st.lists(st.floats(0.0, 3.0), min_size=1, max_size=100),
    h=st.floats(0.0, 0.01),
    lag=st.floats(1e-4, 0.05),
)
def test_friction_sees_no_speed_that_never_was(form: int, speeds: list[float], h: float, lag: float) -> None:
    late = seen(speeds, [h] * len(speeds), lag_s=lag, form=form)
    assert min(late) >= -1e-12
    assert max(late) <= max(speeds) + 1e-12


@pytest.mark.parametrize("form", FORMS)
def test_a_steady_speed_is_seen_as_it_is(form: int) -> None:
    assert seen([0.7] * 10_000, [H] * 10_000, lag_s=0.03, form=form)[-1] == pytest.approx(0.7)


@pytest.mark.parametrize("form", FORMS)
@unhurried
@given(speeds=st.lists(st.floats(0.0, 3.0)))
def test_nothing_hidden_shows_the_speed_itself(form: int, speeds: list[float]) -> None:
    assert seen(speeds, [H] * len(speeds), form=form) == speeds
