"""How much a better model of friction buys: `replay --compensator model` with the true model next to the energy one's.

    python -m benchmarks.bench_joint_model [--seeds 5] [--duration 60]

A person moves a joint whose friction holds one effect next to 0.3 N m and 0.07 N m s/rad, with the sensors of a Panda;
the numbers are the share of the friction that the compensator took over along the recorded motion.
"""

import argparse
from dataclasses import replace

import numpy as np

from friction_audit.compensation.settings import Competitor, ModelFile, ReplaySettings
from friction_audit.effects.joint_model import ArmModel, FittedTerm, simple_model
from friction_audit.pipeline import AuditSettings, estimate_log, replay_estimate
from friction_audit.simulation.bench import BenchSettings, Operator
from friction_audit.simulation.hide import with_model
from friction_audit.simulation.periodic import Sinusoid
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import PANDA_SENSORS, JointParameters

BENCH = BenchSettings(
    joints=(JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07),),
    sensors=(PANDA_SENSORS[0],),
    operator=Operator(motion=Sinusoid(spread=0.3)),
)
SIMPLE = simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
EFFECTS = (
    None,
    FittedTerm("stribeck", (0.15, 0.1, 1.5)),
    FittedTerm("nonlinear_viscous", (0.15, 0.6, 0.01, 0.0)),
    FittedTerm("asymmetric_coulomb", (0.1,)),
    FittedTerm("presliding", (0.3, 0.004, 1.0, 0.005)),
    FittedTerm("position_dependent_friction", (0.1, 0.05, 6.0, 0.2, 20.0)),
    FittedTerm("friction_step", (0.15, 0.02, 30.0, 0.0)),
)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--duration", type=float, default=60.0)
    arguments = parser.parse_args()
    print("| friction besides Coulomb and viscous | energy | energy, later | fixed | model |")
    print("| --- | --- | --- | --- | --- |")
    for effect in EFFECTS:
        removed = np.array([_removed(effect, seed, arguments.duration) for seed in range(arguments.seeds)])
        cells = " | ".join(f"{100 * share:.1f} %" for share in np.median(removed, axis=0))
        print(f"| {'none' if effect is None else f'`{effect.name}`'} | {cells} |")


def _removed(effect: FittedTerm | None, seed: int, duration_s: float) -> tuple[float, float, float, float]:
    """Return the shares removed by the energy compensator, by it once it has an estimate, by fixed, by the model."""
    terms = SIMPLE.terms if effect is None else (*SIMPLE.terms, effect)
    model = ArmModel(names=("joint1",), joints=(replace(SIMPLE, terms=terms),))
    log = simulate(with_model(replace(BENCH, duration_s=duration_s), model), seed).log
    estimate = estimate_log(log, AuditSettings())
    given = ModelFile(path="model.toml", model=model)
    asked = (
        ReplaySettings(),
        ReplaySettings(competitor=Competitor(name="fixed")),
        ReplaySettings(competitor=Competitor(name="model"), joint_model=given),
    )
    numbers = [replay_estimate(estimate, one).replay.joints[0].numbers for one in asked]
    energy, fixed, better = numbers
    assert energy is not None
    assert fixed is not None
    assert better is not None
    later = energy.dissipation_removed_updated
    return energy.dissipation_removed, later, fixed.dissipation_removed, better.dissipation_removed


if __name__ == "__main__":
    main()
