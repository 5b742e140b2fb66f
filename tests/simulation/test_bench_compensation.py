"""A compensator in the loop: what it leaves, what it learns, what it saw."""

from dataclasses import replace

import pytest
from numpy.testing import assert_allclose

from friction_audit.compensation.compensators import Compensator, EnergyCompensator, FixedCompensation
from friction_audit.compensation.replay import run
from friction_audit.simulation.bench import BenchSettings, simulate_bench
from friction_audit.simulation.settings import PANDA_SENSORS
from friction_audit.simulation.simulation import Simulation

TRUE = FixedCompensation(coulomb_nm=0.30, viscous_nms_per_rad=0.07)
NOISY = replace(PANDA_SENSORS[0], clock_jitter_s=0.0, stale=0.0, lost=0.0)


def compensated(settings: BenchSettings, compensator: Compensator, seed: int = 1) -> Simulation:
    return simulate_bench(replace(settings, compensator=compensator), seed)


@pytest.mark.parametrize("seed", range(3))
def test_energy_compensator_learns_the_friction_through_the_noise(seed: int) -> None:
    settings = BenchSettings(duration_s=60.0, sensors=(PANDA_SENSORS[0],))
    knew = compensated(settings, EnergyCompensator(window=8), seed).truth.compensators
    assert_allclose(knew["coulomb_nm"][-1, 0], 0.30, atol=0.02)
    assert_allclose(knew["viscous_nms_per_rad"][-1, 0], 0.07, atol=0.02)
    assert knew["cycle"][-1, 0] > 25


@pytest.mark.parametrize("compensator", [TRUE, EnergyCompensator(window=4)], ids=["fixed", "energy"])
def test_the_log_is_what_the_compensator_saw(compensator: Compensator) -> None:
    """A replay over the log finds every torque and everything it knew, to rounding."""
    settings = BenchSettings(duration_s=20.0, sensors=(NOISY,))
    simulation = compensated(settings, compensator)
    log = simulation.log
    assert log.tau_interaction is not None
    assert log.tau_compensation is not None
    again = run(compensator, log.t, log.dq[:, 0], log.tau_interaction[:, 0])
    assert_allclose(log.tau_compensation[1:, 0], again["compensation_nm"][:-1], atol=1e-9)
    for name, trace in simulation.truth.compensators.items():
        assert_allclose(trace[:, 0], again[name], rtol=1e-6, atol=1e-9, err_msg=name)
