"""The compensator of the paper in the simulator: where it rings, how near it keeps the energy, persons lost on the arm.

``python -m benchmarks.bench_compensation [elastic|persons|arm] [--persons N]`` prints one table, or all.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from math import pi

import numpy as np

from friction_audit.compensation.comparison import METHODS, SCENES
from friction_audit.compensation.comparison.methods import NO_COMPENSATION
from friction_audit.compensation.comparison.trial import find_reference, measure, vibration_nm
from friction_audit.compensation.compensators import Coefficients, EnergyCompensator
from friction_audit.compensation.compensators.energy import PUBLISHED, RIDGE
from friction_audit.compensation.compensators.law import payback_s
from friction_audit.reproduce.course import make_course
from friction_audit.reproduce.one_joint import LOW_PEAK_NM, compensated, leaves_by, peak_nm
from friction_audit.simulation import PANDA_SENSORS, JointParameters, Operator
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.effects.hidden import Hidden
from friction_audit.simulation.effects.joint_elasticity import JointElasticity
from friction_audit.simulation.scenarios import SCENARIOS, simulate

MOTOR_KG_M2, OUTER_KG_M2, DAMPING_RATIO = 0.3, 1.0, 0.1


def elastic(persons: int) -> Iterator[str]:
    """Yield rows of a joint over-compensated by 2.5 N m s/rad: the median rms torque faster than a person."""
    over = EnergyCompensator(
        forced=Coefficients(viscous_nms_per_rad=2.5),
        forced_from_cycle=1,
        forced_until_acted=False,
        max_torque_rate_nm_s=1000.0,
    )
    yield "| mode [Hz] | payback [s] | vibration [N m rms], median | largest |"
    for hz in (10.0, 18.0, 33.0, 71.0):
        compliance = (1.0 / MOTOR_KG_M2 + 1.0 / OUTER_KG_M2) / (2.0 * pi * hz) ** 2
        gear = JointElasticity(compliance_rad_per_nm=compliance, damping_ratio=DAMPING_RATIO)
        for horizon in (0.0, 0.02, payback_s(2.0 * pi * hz, DAMPING_RATIO)):
            settings = BenchSettings(
                joints=(JointParameters(inertia_kg_m2=MOTOR_KG_M2, coulomb_nm=0.311, viscous_nms_per_rad=0.075),),
                hidden=(Hidden(joint_elasticity=gear),),
                sensors=(PANDA_SENSORS[0],),
                operator=Operator(inertia_kg_m2=OUTER_KG_M2, stiffness_nm_per_rad=375.0, damping_nms_per_rad=62.0),
                compensator=replace(over, payback_s=horizon),
                duration_s=20.0,
            )
            motions = (simulate(settings, seed).truth.motion for seed in range(min(persons, 5)))
            rms = [float(np.sqrt(np.mean(vibration_nm(motion.interaction_nm)[2000:] ** 2))) for motion in motions]
            yield f"| {hz:g} | {horizon:.3f} | {np.median(rms):.3f} | {max(rms):.3f} |"


def single_joint(persons: int) -> Iterator[str]:
    """Yield rows of Figs 10 and 11: how far the energy leaves that of cycle 2, and the largest torque after it."""
    (fig10,) = (one for one in SCENARIOS if one.name == "fig10")
    yield "| ridge | within 5 % | within 25 % | worst | peak below 0.5 N m | worst [N m] |"
    for ridge in (PUBLISHED, RIDGE):
        assert isinstance(fig10.settings, BenchSettings)
        assert isinstance(fig10.settings.compensator, EnergyCompensator)
        settings = replace(fig10.settings, compensator=replace(fig10.settings.compensator, ridge=ridge))
        courses = [make_course(simulate(settings, seed)) for seed in range(persons)]
        leaves = np.array([leaves_by(course) for course in courses])
        peaks = np.array([peak_nm(compensated(course)) for course in courses])
        inside = f"{np.sum(leaves < 0.05)} | {np.sum(leaves < 0.25)} | {leaves.max():.3f}"
        yield f"| {ridge:g} | {inside} | {np.sum(peaks < LOW_PEAK_NM)} of {persons} | {peaks.max():.3f} |"


def arm(persons: int) -> Iterator[str]:
    """Yield a row per person and window of the elastic Panda: whether the loop held, and what was left."""
    (panda,) = (scene for scene in SCENES if scene.name == "panda")
    (energy,) = (method for method in METHODS if method.name == "energy")
    tunings = [energy.sweeps[0].at(window) for window in (2.0, 3.0)]
    yield "| seed | tuning | held | slope [mW] | peak [N m] | Coulomb left |"
    for seed in range(min(persons, 20)):
        reference = find_reference(simulate(panda.compensated(NO_COMPENSATION), seed))
        for tuning in tunings:
            found = measure(simulate(panda.compensated(tuning), seed), reference)
            row = f"{1000 * found.energy_slope_w:.1f} | {found.peak_torque_nm:.2f} | {found.coulomb_left:.3f}"
            yield f"| {seed} | {tuning.name} | {'yes' if found.stable else 'LOST'} | {row} |"


TABLES = {"elastic": elastic, "persons": single_joint, "arm": arm}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"of {sorted(TABLES)}; default: all")
    parser.add_argument("--persons", type=int, default=100)
    given = parser.parse_args()
    for name in given.tables or TABLES:
        for line in TABLES[name](given.persons):
            print(line, flush=True)
