"""Late signals, and roundings that tell nothing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.joint_log import Float
from friction_audit.simulation.bench import BenchSettings, Operator, simulate_bench
from friction_audit.simulation.effects import EFFECTS, Hidden, HiddenEffect
from friction_audit.simulation.effects.sensors import TORQUE_LATE, VELOCITY_LATE, TimeDelay
from friction_audit.simulation.sensors import quantise
from friction_audit.simulation.settings import IDEAL_SENSORS
from tests.simulation.mechanics.any_step import STEP_S

PLAIN = BenchSettings(duration_s=6.0)
IDEAL = replace(PLAIN, sensors=(IDEAL_SENSORS,), operator=Operator(stiffness_nm_per_rad=200.0))
STEPS = {
    "q": 1e-6,
    "dq": 1e-6,
    "tau_interaction": 0.0357,
    "tau_J": 0.0357,
    "gravity": 1e-6,
    "tau_ext_hat_filtered": 1e-3,
    "temperature": 0.1,
}


def lag_s(late: Float, prompt: Float) -> float:
    """Return by how much a signal is late: where it differs least from the prompt one, by a parabola."""
    shifts = np.arange(0, 60)
    span = len(prompt) - len(shifts)
    meets = np.array([np.sum((late[shift : shift + span] - prompt[:span]) ** 2) for shift in shifts])
    best = int(np.argmin(meets[1:-1])) + 1
    before, at, after = meets[best - 1 : best + 2]
    return 1e-3 * float(best + 0.5 * (before - after) / (before - 2.0 * at + after))


@pytest.mark.parametrize("delay_s", [4e-3, 12e-3, 7.4e-3])
def test_delay_shifts_torque_or_motion_by_its_length(delay_s: float) -> None:
    prompt = simulate_bench(IDEAL, 1).log.channels()
    for form, names in ((TORQUE_LATE, ["tau_interaction"]), (VELOCITY_LATE, ["q", "dq"])):
        hidden = Hidden(time_delay=TimeDelay(delay_s=delay_s, form=form))
        late = simulate_bench(replace(IDEAL, hidden=(hidden,)), 1).log.channels()
        for name, column in late.items():
            if name in names:
                assert_allclose(lag_s(column[:, 0], prompt[name][:, 0]), delay_s, atol=STEP_S)
            else:
                assert_array_equal(column, prompt[name])


@pytest.mark.parametrize("logs_sensor", [False, True])
@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_roundings_are_those_of_the_sensors_whatever_is_hidden(effect: type[HiddenEffect], logs_sensor: bool) -> None:
    settings = replace(PLAIN, logs_sensor=logs_sensor, logs_temperature=True, gravity_nm=4.0 * logs_sensor)
    for form in effect.forms or (None,):
        hidden = Hidden().holding(effect.make({"form": form} if form else {}))
        channels = simulate_bench(replace(settings, hidden=(hidden,), duration_s=2.0), 2).log.channels()
        for name, column in channels.items():
            assert_array_equal(column, quantise(column, STEPS[name]))
