import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.simulation.mechanics.tick import quantised
from friction_audit.simulation.sensors import quantise

VALUES = st.floats(-1e6, 1e6)
STEPS = st.sampled_from([0.0, 1e-6, 0.006, 0.0357, 0.1, 1.0]) | st.floats(1e-7, 10.0)


@given(values=st.lists(VALUES, min_size=1, max_size=9), step=STEPS)
def test_compiled_resolution_is_that_of_the_log_to_the_bit(values: list[float], step: float) -> None:
    one_by_one = np.array([quantised(value, step) for value in values])
    assert one_by_one.tobytes() == quantise(np.array(values), step).tobytes()


@given(steps=st.integers(-1000, 1000))
def test_half_steps_go_to_the_even_multiple(steps: int) -> None:
    assert quantised(steps + 0.5, 1.0) == 2 * round((steps + 0.5) / 2)
