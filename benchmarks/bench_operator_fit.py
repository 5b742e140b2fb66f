"""The person's impedance as `replay --assume same-operator` fits it to a log: error, and how often its intervals hold.

    python -m benchmarks.bench_operator_fit [--persons 40] [--duration 120]

Every person has an impedance, a hand and noise of their own; who cannot be fitted is counted, not left out in silence.
"""

import argparse
from dataclasses import replace

import numpy as np

from friction_audit.compensation.plant import fit_operator, recording_of
from friction_audit.compensation.result import FittedOperator
from friction_audit.errors import AnalysisError
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.simulation.bench import BenchSettings, Operator
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import PANDA_SENSORS, JointParameters

BENCH = BenchSettings(
    joints=(JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07),),
    sensors=(PANDA_SENSORS[0],),
)
RANGES = {"inertia": (0.1, 0.6), "damping": (3.0, 15.0), "stiffness": (20.0, 150.0)}
"""An adult's arm at a joint half a metre from the hand."""


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--persons", type=int, default=40)
    parser.add_argument("--duration", type=float, default=120.0)
    arguments = parser.parse_args()
    tried = [_person(seed, arguments.duration) for seed in range(arguments.persons)]
    found = [(true, fit) for true, fit in tried if fit is not None]
    print(f"{len(found)} of {len(tried)} persons fitted")
    print("| number | median error | 90 % of the errors below | interval holds the truth |")
    print("| --- | --- | --- | --- |")
    for column, name in enumerate(RANGES):
        numbers = [getattr(fit, name) for _, fit in found]
        truth = np.array([true[column] for true, _ in found])
        errors = np.abs(np.array([number.value for number in numbers]) / truth - 1.0)
        holds = sum(number.low <= true <= number.high for number, true in zip(numbers, truth, strict=True))
        print(
            f"| {name} | {100 * np.median(errors):.1f} % | {100 * np.quantile(errors, 0.9):.1f} % "
            f"| {holds} of {len(found)} |"
        )


def _person(seed: int, duration_s: float) -> tuple[tuple[float, ...], FittedOperator | None]:
    """Simulate a person; return their impedance and what is fitted, None where nothing is."""
    rng = np.random.default_rng([seed, 1])
    true = tuple(float(np.exp(rng.uniform(*np.log(bounds)))) for bounds in RANGES.values())
    hand = Operator(
        inertia_kg_m2=true[0],
        damping_nms_per_rad=true[1],
        stiffness_nm_per_rad=true[2],
        motion=Sinusoid(spread=0.3),
    )
    log = simulate(replace(BENCH, operator=hand, duration_s=duration_s), seed).log
    interaction = estimate_log(log, AuditSettings()).interaction
    try:
        return true, fit_operator(recording_of(interaction, 0))
    except AnalysisError:
        return true, None


if __name__ == "__main__":
    main()
