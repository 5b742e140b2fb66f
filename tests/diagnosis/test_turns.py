"""Reversals and rests have their number, and what is usual at them is what nine of ten reach at most."""

import numpy as np

from friction_audit.diagnosis.turns import FEWEST, Turns, nearest_turn


def test_each_sample_has_the_number_of_the_stretch_that_is_nearest() -> None:
    turning = np.array([0, 1, 1, 0, 0, 0, 1, 0, 0], bool)
    assert nearest_turn(turning).tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 1]


def test_without_a_reversal_there_is_one_number_and_nothing_is_usual() -> None:
    number = nearest_turn(np.zeros(5, bool))
    assert number.tolist() == [0] * 5
    turns = Turns(number=number, seen=np.zeros((2, 5), bool))
    assert turns.usual(np.ones((2, 5)), np.zeros(1, bool)).tolist() == [np.inf, np.inf]


def test_usual_is_the_ninth_decile_of_the_largest_of_each() -> None:
    size = np.array([[0.0, -k, 0.5] for k in range(1, 12)]).reshape(1, -1)
    turns = Turns(number=np.repeat(np.arange(11), 3), seen=np.ones((1, 33), bool))
    assert turns.usual(size, np.zeros(11, bool)).tolist() == [10.0]


def test_those_that_a_push_touched_or_no_filter_sees_do_not_count() -> None:
    size, number = np.arange(1.0, 12.0)[None], np.arange(11)
    touched = number >= FEWEST
    turns = Turns(number=number, seen=np.ones((1, 11), bool))
    assert turns.usual(size, touched).tolist() == [np.quantile(np.arange(1.0, FEWEST + 1.0), 0.9)]
    unseen = Turns(number=number, seen=(number > 0)[None])
    assert unseen.usual(size, touched).tolist() == [np.inf]
