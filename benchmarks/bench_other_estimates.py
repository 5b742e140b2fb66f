"""How far the estimates beside the default one can be trusted: the torque regression, and single points of the paper's.

python benchmarks/bench_other_estimates.py [--seeds 150]
"""

import argparse

import numpy as np

from friction_audit.audit import AuditSettings, estimate_log
from friction_audit.friction.settings import FrictionSettings
from friction_audit.simulate import IDEAL_SENSORS, BenchSettings, JointParameters, simulate

COULOMB_NM, VISCOUS_NMS_PER_RAD = JointParameters().coulomb_nm, JointParameters().viscous_nms_per_rad
CLOSE = 0.001


def regression(duration_s: float, seeds: int) -> str:
    """Say how often the intervals of the torque regression hold the truth."""
    held = []
    for seed in range(seeds):
        log = simulate(BenchSettings(duration_s=duration_s), seed).log
        found = estimate_log(log, AuditSettings()).friction.joints[0].regression
        if found is not None:
            pairs = ((found.coulomb, COULOMB_NM), (found.viscous, VISCOUS_NMS_PER_RAD))
            held.append([value.low <= truth <= value.high for value, truth in pairs])
    coulomb, viscous = 100 * np.mean(held, axis=0)
    return f"| {duration_s:.0f} s | {len(held)} | {coulomb:.1f} % | {viscous:.1f} % |"


def points_of_the_paper(recordings: int) -> str:
    """Say how near the single points (k = 2) of the paper's estimator are to the truth without any noise."""
    friction = FrictionSettings(estimator="paper", compare=False)
    errors = []
    for seed in range(recordings):
        log = simulate(BenchSettings(sensors=(IDEAL_SENSORS,)), seed).log
        history = estimate_log(log, AuditSettings(friction=friction)).friction.joints[0].history
        pairs = ((history.coulomb_nm, COULOMB_NM), (history.viscous_nms_per_rad, VISCOUS_NMS_PER_RAD))
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
    print("| recording | recordings | Coulomb covered | viscous covered |\n| --- | --- | --- | --- |")
    for duration_s in (20.0, 60.0):
        print(regression(duration_s, arguments.seeds))
    print("\n" + points_of_the_paper(10))


if __name__ == "__main__":
    main()
