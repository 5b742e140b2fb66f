"""A joint that goes back and forth comes by every state once a cycle."""

from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.recurrence import passes_of
from tests.effects.joint_data_by_hand import joint_data

PERIOD_S, STEP_S = 2.0, 0.005
T = np.arange(0.0, 20.0, STEP_S)
W = 2 * np.pi / PERIOD_S
DATA = replace(
    joint_data(np.sin(W * T), W * np.cos(W * T), -(W**2) * np.sin(W * T)), cycle=(T // PERIOD_S).astype(np.int64)
)


def test_every_other_cycle_comes_by_at_the_same_phase() -> None:
    at = 1030
    places = np.unique(passes_of(DATA, 1).like(at))
    assert set(places // 400) == set(range(10)) - {at // 400}
    assert np.all(np.abs(places % 400 - at % 400) < 25)


def test_a_state_that_is_never_reached_again_has_none() -> None:
    far = replace(
        DATA, q=np.where(DATA.cycle == 4, DATA.q + 9.0, DATA.q), ddq=np.where(DATA.cycle == 4, 99.0, DATA.ddq)
    )
    assert passes_of(far, 1).like(1800) == []


def test_the_way_back_is_another_state() -> None:
    passes = passes_of(DATA, 4)
    assert all(DATA.dq[4 * place] > 0.0 for place in passes.like(0))
