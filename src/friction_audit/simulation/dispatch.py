"""Any settings -> Simulation."""

from friction_audit.simulation.arm import ArmSettings, simulate_arm
from friction_audit.simulation.bench import BenchSettings, Progress, simulate_bench
from friction_audit.simulation.panda_joint import HandGuidedPanda, simulate_hand_guided_panda
from friction_audit.simulation.simulation import Simulation

AnySettings = BenchSettings | HandGuidedPanda | ArmSettings
"""What can be simulated."""


def simulate(
    settings: AnySettings, seed: int, *, path: str = "simulation", progress: Progress | None = None
) -> Simulation:
    """Simulate a recording. The same settings and seed give the same log to the bit.

    Args:
        settings: The joints, who moves them, the sensors, what is hidden.
        seed: Seed of everything that is drawn.
        path: Path that the log names as its source.
        progress: Told how far the simulation is.
    """
    match settings:
        case BenchSettings():
            return simulate_bench(settings, seed, path=path, progress=progress)
        case HandGuidedPanda():
            return simulate_hand_guided_panda(settings, seed, path=path, progress=progress)
        case ArmSettings():
            return simulate_arm(settings, seed, path=path, progress=progress)
