"""How far the estimates beside the default one can be trusted: the torque regression, and single points of the paper's.

python benchmarks/bench_other_estimates.py [--seeds 150]
"""

import argparse
from dataclasses import replace

import numpy as np

from friction_audit.friction.settings import FrictionSettings
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.simulation import IDEAL_SENSORS, PANDA_SENSORS, BenchSettings, JointParameters, simulate
from friction_audit.simulation.settings import Sensors

JOINT = JointParameters()
TRUTH = (JOINT.coulomb_nm, JOINT.viscous_nms_per_rad, JOINT.inertia_kg_m2)
PANDA = replace(PANDA_SENSORS[0], stale=0.0, lost=PANDA_SENSORS[0].lost + PANDA_SENSORS[0].stale)
"""As a log is read: repeated samples are left out."""

RECORDINGS = ((20.0, 1000.0), (60.0, 1000.0), (60.0, 250.0), (60.0, 100.0), (60.0, 30.0))
"""Length [s] and rate [Hz]."""
CLOSE = 0.001


def regression(duration_s: float, rate_hz: float, sensors: Sensors, seeds: int) -> str:
    """Say how often the intervals of the torque regression hold the truth, and what inertia it finds."""
    held, inertia = [], []
    for seed in range(seeds):
        log = simulate(BenchSettings(duration_s=duration_s, rate_hz=rate_hz, sensors=(sensors,)), seed).log
        found = estimate_log(log, AuditSettings()).friction.joints[0].regression
        if found is not None:
            pairs = zip((found.coulomb, found.viscous, found.inertia), TRUTH, strict=True)
            held.append([value.low <= truth <= value.high for value, truth in pairs])
            inertia.append(found.inertia.value)
    covered = " | ".join(f"{share:.1f} %" for share in 100 * np.mean(held, axis=0))
    return f"| {duration_s:.0f} s | {rate_hz:.0f} Hz | {len(held)} | {covered} | {np.mean(inertia):.4f} |"


def points_of_the_paper(recordings: int) -> str:
    """Say how near the single points (k = 2) of the paper's estimator are to the truth without any noise."""
    friction = FrictionSettings(estimator="paper", compare=False)
    errors = []
    for seed in range(recordings):
        log = simulate(BenchSettings(sensors=(IDEAL_SENSORS,)), seed).log
        history = estimate_log(log, AuditSettings(friction=friction)).friction.joints[0].history
        pairs = zip((history.coulomb_nm, history.viscous_nms_per_rad), TRUTH[:2], strict=True)
        errors.append(np.abs([value / truth - 1 for value, truth in pairs]))
    every = np.concatenate(errors, axis=1)
    near, worst = 100 * np.mean(every < CLOSE, axis=1), 100 * every.max(axis=1)
    return (
        f"{every.shape[1]} points: {near[0]:.1f} % (Coulomb) and {near[1]:.1f} % (viscous) are within 0.1 % of the "
        f"truth, the worst are {worst[0]:.1f} % and {worst[1]:.1f} % off."
    )


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=150)
    arguments = parser.parse_args()
    print(f"| length | rate | recordings | Coulomb | viscous | inertia | mean inertia (true: {TRUTH[2]:.4f} kg m²) |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for duration_s, rate_hz in RECORDINGS:
        print(regression(duration_s, rate_hz, PANDA, arguments.seeds))
    print("\n" + points_of_the_paper(10))


if __name__ == "__main__":
    main()
