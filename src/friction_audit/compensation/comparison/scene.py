"""Who moves what: the joint, or the arm, that all methods are tried on."""

from dataclasses import dataclass, replace

from friction_audit.compensation.comparison.methods import Joint, Tuning, panda_joint
from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.bench import BenchSettings
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import JointElasticity
from friction_audit.simulation.panda_joint import PANDA_JOINTS
from friction_audit.simulation.settings import JointByJoint

# In a rigid joint nothing but the controller's tick would bound the gains of what feeds torque or motion back.
_ELASTIC = Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=1e-4, damping_ratio=0.1))


@dataclass(frozen=True, kw_only=True, slots=True)
class Plan:
    """How much is tried."""

    tuning_seeds: int  # persons for whom the sweeps are made; none of them is reported
    most_values: int  # of the values of a sweep, at most so many are tried, evenly chosen
    sweeps: int  # so many sweeps of a method are made
    with_others: bool  # whether tunings beside the paper's kind and the best one are reported
    margin_seeds: int  # of the persons who are reported, those whose stability margins are looked for
    margin_share: float  # of the length of a trial, what looking for a stability margin takes


@dataclass(frozen=True, kw_only=True, slots=True)
class Scene:
    """What all methods are tried on."""

    name: str  # as in options and documents
    title: str  # in words
    settings: BenchSettings | ArmSettings  # of the simulation, without compensator
    plan: Plan  # how much is tried
    # whether a simulation keeps the interpreter busy, so that threads would wait for each other
    needs_processes: bool = False

    @property
    def joints(self) -> tuple[Joint, ...]:
        """What methods may be told about the joints."""
        settings = self.settings
        both = zip(settings.joints, settings.hidden, strict=True)
        return tuple(panda_joint(column, one, hidden.joint_elasticity) for column, (one, hidden) in enumerate(both))

    def compensated(self, tuning: Tuning) -> BenchSettings | ArmSettings:
        """Return the settings with a compensator in every joint."""
        made, settings = tuple(map(tuning.make, self.joints)), self.settings
        if isinstance(settings, BenchSettings):
            return replace(settings, compensator=made[0])
        return replace(settings, compensator=JointByJoint(compensators=made))


SCENES: tuple[Scene, ...] = (
    Scene(
        name="joint",
        title="joint 1 of a Panda, elastic, moved by a person",
        settings=BenchSettings(joints=(PANDA_JOINTS[0],), hidden=(_ELASTIC,), duration_s=40.0),
        plan=Plan(tuning_seeds=5, most_values=10, sweeps=5, with_others=True, margin_seeds=20, margin_share=0.5),
    ),
    Scene(
        name="panda",
        title="a Panda, its joints elastic, guided by a hand",
        settings=ArmSettings(hidden=(_ELASTIC,) * len(PANDA_JOINTS), duration_s=30.0),
        plan=Plan(tuning_seeds=5, most_values=5, sweeps=2, with_others=False, margin_seeds=6, margin_share=0.6),
        needs_processes=True,
    ),
)
"""The joint is that of the default."""
