"""Warm-up, a step of friction and drift are three things."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.effects import friction_step, torque_drift, warm_up
from friction_audit.effects.effect import Effect
from friction_audit.joint_log import Float
from tests.effects.explained import share_explained
from tests.effects.joint_data_by_hand import baseline, two_sines

DATA = replace(two_sines(), temperature=None)
T, V = DATA.t, DATA.dq
ALL = (warm_up.EFFECT, friction_step.EFFECT, torque_drift.EFFECT)


def best(torque: Float) -> tuple[Effect, float, float]:
    """The candidate that explains most, what it explains, and what the next one does."""
    shares = {candidate.name: share_explained(candidate, DATA, torque) for candidate in ALL}
    order = sorted(ALL, key=lambda c: -shares[c.name])
    return order[0], shares[order[0].name], shares[order[1].name]


@pytest.mark.parametrize("time_constant", [6.0, 15.0, 40.0, 120.0])
@pytest.mark.parametrize("viscous", [0.0, 0.5])
def test_warm_up_of_any_pace(time_constant: float, viscous: float) -> None:
    name, own, other = best((np.sign(V) + viscous * V) * np.exp(-T / time_constant))
    assert name is warm_up.EFFECT
    assert own > 0.98
    assert other < 0.97


@pytest.mark.parametrize("moment", [9.3, 30.0, 41.7])
@pytest.mark.parametrize("length", [0.0, 5.0])
def test_a_step_at_any_moment(moment: float, length: float) -> None:
    later = np.clip((T - moment) / max(length, 1e-6), 0.0, 1.0)
    name, own, other = best((0.2 * np.sign(V) + 0.1 * V) * later)
    assert name is friction_step.EFFECT
    assert own > 0.95
    assert other < 0.9


@pytest.mark.parametrize("drift", [T / T[-1], 1.0 - np.exp(-T / 10.0), np.sin(T / 12.0)])
def test_drift_is_the_same_in_both_directions(drift: Float) -> None:
    name, own, other = best(drift)
    assert name is torque_drift.EFFECT
    assert own > 0.95
    assert other < 0.1


def test_a_temperature_is_used_where_it_changes() -> None:
    heated = replace(DATA, temperature=25.0 + 10.0 * np.sin(T / 9.0))
    torque = np.sign(V) * np.exp(-0.05 * 10.0 * np.sin(T / 9.0))
    assert share_explained(warm_up.EFFECT, heated, torque) > 0.95
    assert share_explained(warm_up.EFFECT, DATA, torque) < 0.5
    flat = replace(DATA, temperature=np.full(len(T), 30.0))
    assert warm_up.EFFECT.grid(flat) == warm_up.EFFECT.grid(DATA)


def test_a_short_log_shows_no_warm_up() -> None:
    short = two_sines(20.0)
    assert "record at least 30 s" in str(warm_up.EFFECT.not_identifiable(short, baseline(short)))
