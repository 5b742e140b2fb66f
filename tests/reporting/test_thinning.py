import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.reporting.figures.style import break_at_gaps, every_nth, thin_extremes


@given(st.integers(1, 10**7), st.integers(1, 30_000))
def test_a_stride_leaves_at_most_what_was_asked(samples: int, most: int) -> None:
    step = every_nth(samples, most).step
    assert len(range(0, samples, step)) <= most


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=400), st.integers(8, 60))
def test_no_extreme_is_lost_and_time_keeps_its_order(values: list[float], most: int) -> None:
    signal = np.array(values)
    t, thinned = thin_extremes(np.arange(len(signal), dtype=np.float64), signal, most)
    width = -(-2 * len(signal) // most)
    whole = len(signal) // width * width if len(signal) > most else len(signal)
    assert thinned.min() <= signal[:whole].min()
    assert thinned.max() >= signal[:whole].max()
    assert (np.diff(t) > 0).all()
    assert len(t) <= max(most, 2) + 1 or len(signal) <= most
    assert (signal[t.astype(int)] == thinned).all()


def test_no_line_is_drawn_over_a_hole() -> None:
    t = np.array([0.0, 1.0, 2.0, 9.0, 10.0])
    assert np.isnan(break_at_gaps(t, np.ones(5), 3.0)).tolist() == [False, False, True, False, False]
