from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.errors import UsageError
from friction_audit.simulation import (
    IDEAL_SENSORS,
    BenchSettings,
    HandGuidedPanda,
    Hidden,
    JointParameters,
    Sensors,
    simulate,
)
from friction_audit.simulation.effects.load_and_place import GravityError, JointLimitStop, PositionDependentFriction
from friction_audit.simulation.effects.sensors import TorqueBias
from friction_audit.simulation.effects.structure import InertialCoupling

JOINT = JointParameters()
SHORT = HandGuidedPanda(joint=4, joints=(JOINT,) * 7, duration_s=5.0)
IDEAL = replace(SHORT, sensors=(IDEAL_SENSORS,) * 7)
OTHERS = (0, 1, 2, 4, 5, 6)


def hide(joint: int, hidden: Hidden) -> tuple[Hidden, ...]:
    return tuple(hidden if number == joint else Hidden() for number in range(1, 8))


def test_sensor_reads_gravity_less_the_interaction_torque() -> None:
    simulation = simulate(IDEAL, 1)
    log, motion = simulation.log, simulation.truth.motion
    interaction = log.channels()["gravity"] - log.channels()["tau_J"]
    # The motor holds the gravity of where the joint would be without acceleration since the middle of the tick.
    assert_allclose(interaction[:, 3], motion.interaction_nm[:, 3], atol=2e-5)
    assert_allclose(interaction[:, OTHERS], 0.0, atol=1e-6)
    assert np.ptp(log.channels()["gravity"][:, 1]) > 0.1


def test_motion_and_noise_are_those_of_the_single_joint() -> None:
    panda = simulate(SHORT, 2)
    bench = simulate(BenchSettings(joints=(JOINT,), sensors=(SHORT.sensors[3],), duration_s=5.0), 2)
    motion, alone = panda.truth.motion, bench.truth.motion
    assert_allclose(motion.dq[:, 3], alone.dq[:, 0], atol=1e-9)
    assert_allclose(motion.q[:, 3] - motion.q[0, 3], alone.q[:, 0], atol=1e-9)
    assert_array_equal(panda.log.t, bench.log.t)
    assert_allclose(panda.log.dq[:, 3], bench.log.dq[:, 0], atol=1.5e-6)
    noise = [simulate(SHORT, seed).log.dq[:500, 0] for seed in (2, 2, 3)]
    assert_array_equal(noise[0], noise[1])
    assert (noise[0] != noise[2]).mean() > 0.9


def test_faults_of_the_sensors_are_those_of_every_joint() -> None:
    clean = simulate(IDEAL, 7).log
    biased = simulate(replace(IDEAL, hidden=hide(6, Hidden(torque_bias=TorqueBias(torque_nm=0.2)))), 7).log
    tilted = simulate(replace(IDEAL, hidden=hide(2, Hidden(gravity_error=GravityError(torque_nm=0.4)))), 7).log
    assert_allclose((biased.channels()["tau_J"] - clean.channels()["tau_J"])[:, 5], -0.2, atol=1e-9)
    assert_allclose(
        (tilted.channels()["gravity"] - clean.channels()["gravity"])[:, 1], 0.4 * np.sin(IDEAL.pose_rad[1]), atol=2e-6
    )
    assert_array_equal(biased.dq, clean.dq)


def test_places_inside_the_joint_are_counted_from_its_zero_and_stops_from_the_start() -> None:
    motion = simulate(replace(IDEAL, hidden=hide(4, ROUGH)), 9).truth.motion
    dq, moving = motion.dq[:, 3], motion.dq[:, 3] != 0
    level = (motion.friction_nm[:, 3] - JOINT.viscous_nms_per_rad * dq)[moving] * np.sign(dq[moving])
    assert_allclose(level, 0.3 * (1 + 0.5 * np.sin(3 * motion.q[moving, 3] + 0.5)), atol=1e-9)
    walled = Hidden(joint_limit_stop=JointLimitStop(stiffness_nm_per_rad=500.0, at_rad=0.1))
    stopped = simulate(replace(IDEAL, hidden=hide(4, walled)), 9).truth.motion
    assert np.abs(stopped.q[:, 3] - IDEAL.pose_rad[3]).max() < 0.3


ROUGH = Hidden(position_dependent_friction=PositionDependentFriction(share=0.5))
COUPLED = Hidden(inertial_coupling=InertialCoupling(ratio=0.3))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"joint": 8}, "expected a joint from 1 to 7 and 7 of each"),
        ({"sensors": (Sensors(),)}, "expected a joint from 1 to 7 and 7 of each"),
        ({"hidden": hide(5, ROUGH)}, "in joint 5: does nothing where only"),
        ({"hidden": hide(4, COUPLED)}, "inertial_coupling in joint 4: does nothing"),
    ],
)
def test_what_a_panda_does_not_have_or_cannot_show_is_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        replace(SHORT, **change)
