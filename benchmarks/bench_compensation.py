"""The compensator of the paper in the simulator: where it rings, how near it keeps the energy, persons lost on the arm.

``python -m benchmarks.bench_compensation [elastic|persons|arm|loop] [--persons N]`` prints one table, or all.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from math import isinf, pi

import numpy as np

from friction_audit.compensation.comparison.experiment import compare
from friction_audit.compensation.comparison.methods import (
    METHODS,
    NO_COMPENSATION,
    OBSERVED_SHARE,
    OBSERVER,
    SETUPS,
    Joint,
    Tuning,
)
from friction_audit.compensation.comparison.result import SECOND, find_reference, measure, vibration_nm
from friction_audit.compensation.competitors import DisturbanceObserver
from friction_audit.compensation.law import NO_RIDGE, RIDGE, Coefficients, EnergyCompensator, payback_s
from friction_audit.parallel import own_process
from friction_audit.reproduce.checks import LOW_PEAK_NM, compensated, peak_nm
from friction_audit.reproduce.claims import make_course
from friction_audit.simulation import PANDA_SENSORS, JointParameters, Operator
from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import JointElasticity
from friction_audit.simulation.scenarios import SCENARIOS, TORQUE_LOOP, simulate, with_torque_control

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
    yield "| ridge | torque noise | within 5 % | within 25 % | worst | peak below 0.5 N m | worst [N m] |"
    assert isinstance(fig10.settings, BenchSettings)
    assert isinstance(fig10.settings.compensator, EnergyCompensator)
    white, slow = fig10.settings.sensors[0], PANDA_SENSORS[0]
    for ridge, sensors in ((NO_RIDGE, white), (0.001, white), (RIDGE, white), (NO_RIDGE, slow), (RIDGE, slow)):
        energy = replace(fig10.settings.compensator, ridge=ridge)
        settings = replace(fig10.settings, compensator=energy, sensors=(sensors,))
        courses = [make_course(simulate(settings, seed)) for seed in range(persons)]
        leaves = np.array([np.abs(one.ends_j[SECOND + 1 :] / one.ends_j[SECOND] - 1.0).max() for one in courses])
        peaks = np.array([peak_nm(compensated(course)) for course in courses])
        inside = f"{np.sum(leaves < 0.05)} | {np.sum(leaves < 0.25)} | {leaves.max():.3f}"
        noise = "white" if sensors is white else "a tenth slow"
        yield f"| {ridge:g} | {noise} | {inside} | {np.sum(peaks < LOW_PEAK_NM)} of {persons} | {peaks.max():.3f} |"


def arm(persons: int) -> Iterator[str]:
    """Yield a row per person and window of the elastic Panda: whether the loop held, and what was left."""
    (panda,) = (setup for setup in SETUPS if setup.name == "panda")
    (energy,) = (method for method in METHODS if method.name == "energy")
    tunings = [energy.sweeps[0].at(window) for window in (2.0, 3.0)]
    yield "| seed | tuning | held | slope [mW] | peak [N m] | Coulomb left |"
    for seed in range(min(persons, 20)):
        reference = find_reference(simulate(panda.compensated(NO_COMPENSATION), seed))
        for tuning in tunings:
            found = measure(simulate(panda.compensated(tuning), seed), reference)
            row = f"{1000 * found.energy_slope_w:.1f} | {found.peak_torque_nm:.2f} | {found.coulomb_left:.3f}"
            yield f"| {seed} | {tuning.name} | {'yes' if isinf(found.lost_s) else 'LOST'} | {row} |"


def torque_loop(persons: int) -> Iterator[str]:
    """Yield a row per method and arm: motors driven directly, and under torque control with as much friction left."""
    (panda,) = (setup for setup in SETUPS if setup.name == "panda")
    panda = replace(panda, tuning_seeds=0, margin_seeds=0)
    assert isinstance(panda.settings, ArmSettings)
    joints = tuple(map(with_torque_control, panda.settings.joints))
    inner = replace(panda, settings=replace(panda.settings, joints=joints))
    motors = Tuning(name="motor B", meaning="the motor's inertia, not what torque control leaves of it", make=_of_motor)
    methods = []
    for method in METHODS:
        if method.name not in ("lugre", "oracle"):
            others: tuple[Tuning, ...] = (motors,) if method.name == "disturbance_observer" else ()
            if method.name == "torque_regulation":
                others = tuple(method.sweeps[0].at(1.0 / ratio - 1.0) for ratio in (0.5, 0.3))
            methods.append(replace(method, sweeps=(), others=others))
    yield "| torque control | method | tuning | lost | slope [mW] | peak [N m] | Coulomb left |"
    for setup, name in ((panda, "none"), (inner, "gain 4, dead time 0.5 ms")):
        with_others = replace(setup, with_others=setup is inner)
        for row in compare(with_others, min(persons, 5), methods).rows:
            slope = row.interval("energy_slope_w").value
            peak = row.interval("drawn_peak_nm").value
            left = row.interval("coulomb_left").value
            found = f"{len(row.lost_s)} | {1000 * slope:.1f} | {peak:.2f} | {left:.3f}"
            yield f"| {name} | {row.label} | {row.tuning.name} | {found} |"


def _of_motor(joint: Joint) -> DisturbanceObserver:
    share, gain = OBSERVER
    inertia = (1.0 + TORQUE_LOOP.gain) * share * joint.parameters.inertia_kg_m2
    return DisturbanceObserver(
        inertia_kg_m2=inertia,
        observer_gain_per_s=gain,
        compensation_gain=OBSERVED_SHARE,
    )


TABLES = {"elastic": elastic, "persons": single_joint, "arm": arm, "loop": torque_loop}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"of {sorted(TABLES)}; default: all")
    parser.add_argument("--persons", type=int, default=100)
    given = parser.parse_args()
    with own_process():
        for name in given.tables or TABLES:
            for line in TABLES[name](given.persons):
                print(line, flush=True)
