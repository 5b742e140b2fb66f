"""A simulation that diverges says so and gives no log."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.errors import AnalysisError
from friction_audit.simulation.arm import ArmSettings, Servo, simulate_arm
from friction_audit.simulation.bench import BenchSettings, Operator, simulate_bench
from friction_audit.simulation.simulation import require_sane

SHORT = BenchSettings(duration_s=5.0)


@pytest.mark.parametrize("stiffness", [1e9, 1e300])
def test_a_grip_too_stiff_for_the_step_is_told(stiffness: float) -> None:
    settings = replace(SHORT, operator=Operator(stiffness_nm_per_rad=stiffness))
    with pytest.raises(AnalysisError, match=r"stiff\.csv: .* diverged: joint 1 has a speed above 1000 rad/s"):
        simulate_bench(settings, 1, path="stiff.csv")


def test_a_load_that_no_joint_holds_is_told() -> None:
    with pytest.raises(AnalysisError, match="joint 1 has a torque above 1e\\+06 N m"):
        simulate_bench(replace(SHORT, gravity_nm=1e300, logs_sensor=True), 1)


def test_an_arm_whose_servos_are_too_stiff_is_told() -> None:
    settings = ArmSettings(driven=True, servo=Servo(stiffness_nm_per_rad=1e9), duration_s=0.1)
    with pytest.raises(AnalysisError, match="the simulation diverged"):
        simulate_arm(settings, 1)


def test_what_is_no_number_is_found_where_it_begins() -> None:
    motion = simulate_bench(SHORT, 1).truth.motion
    speed = motion.dq.copy()
    speed[700:] = np.nan
    with pytest.raises(AnalysisError, match=r"joint 1 has a speed above 1000 rad/s at 0\.700 s, or none"):
        require_sane(replace(motion, dq=speed), "log.csv")
