"""Compensation methods with their tunings and sweeps, and the setups (a joint, an arm) on which they are compared."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from typing import Any, NamedTuple

from friction_audit.compensation import competitors
from friction_audit.compensation.law import CompensatorSettings, EnergyCompensator, payback_s
from friction_audit.compensation.settings import limits_of
from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.bench import PANDA_JOINTS, BenchSettings
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import JointElasticity
from friction_audit.simulation.settings import JointParameters

# Roles of a tuning: the one that reproduces the paper's order; the same with an observer that compensates all that it
# observes; the best stable one of the sweeps; another. The order model > disturbance observer > torque regulation >
# proposed requires: error of the model > 1 - share of the observer + its lag > B_theta / B > 0.
PAPER, FULL, BEST, OTHER = "paper", "full", "best", "other"


class Joint(NamedTuple):
    """Parameters of a joint that a tuning may use."""

    column: int  # index of the joint in the arm, from 0
    parameters: JointParameters  # true motor and friction parameters at the link
    limits: dict[str, Any]  # settings of a compensator: limits of torque and torque rate
    payback_s: float  # as in ``law.payback_s``, for the elastic mode of the joint [s]


def panda_joint(column: int, motor: JointParameters, gear: JointElasticity) -> Joint:
    """Return the parameters of a joint at the link, with the limits of that joint of a Panda.

    The elastic mode is that of a fixed link, with torque control and its dead time to first order.
    """
    known, loop, limits = CompensatorSettings.payback_s, motor.torque_loop, limits_of("panda", column + 1)
    if gear.compliance_rad_per_nm > 0.0:
        bare = (gear.compliance_rad_per_nm * motor.inertia_kg_m2) ** -0.5
        damping = gear.damping_ratio + 0.5 * bare * (loop.damping_s - loop.gain * loop.dead_time_s)
        if damping > 0.0:
            faster = (1.0 + loop.gain) ** 0.5
            known = payback_s(faster * bare, damping / faster)
    settings: dict[str, Any] = {"max_torque_nm": limits.torque_nm, "max_torque_rate_nm_s": limits.rate_nm_s}
    return Joint(column, motor.at_link, settings, known)


class Tuning(NamedTuple):
    """One set of parameters of a method."""

    name: str  # short name
    meaning: str  # explanation
    make: Callable[[Joint], Any]  # joint -> compensator
    limited: bool = True  # whether the limits of the joint apply


class Sweep(NamedTuple):
    """A sweep of one parameter of a method."""

    name: str  # name of what its tunings have in common
    axis: str  # name of the parameter with its unit
    values: tuple[float, ...]  # in the order of rising gain
    at: Callable[[float], Tuning]  # value -> tuning


@dataclass(frozen=True, slots=True)
class Method:
    """A compensation method."""

    name: str  # as in options and documents
    label: str  # as in tables and figures
    paper: Tuning  # with role PAPER
    full: Tuning | None = None  # with role FULL where it differs, or None
    others: tuple[Tuning, ...] = ()  # further reported tunings
    sweeps: tuple[Sweep, ...] = ()  # the best stable tuning of all sweeps is reported


NONE = "none"  # the reference method
TOP_SPEED_RAD_S = 1.5  # the sigmoid is fitted to the true friction up to this speed
SCALES = (0.4, 0.6, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4)  # friction of a model, over the true one
WINDOWS = (2.0, 3.0, 4.0, 6.0, 8.0)  # cycles per estimate
OBSERVER_GAINS_PER_S = (2.0, 5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 120.0, 200.0)
# Assumed over true motor inertia; the first one is that of role PAPER, where it is known only roughly.
INERTIA_RATIOS = (0.8, 1.0, 1.2, 0.5, 1.5)
# Desired motor inertia B_theta over the true one.
SHAPED_RATIOS = (0.7, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.07, 0.05, 0.035)
# Role PAPER: a model identified on another arm, an observer that compensates a share of what it observes, as is common
# for stability, and the torque regulation with the least desired inertia that is stable on the arm.
MODELLED_SHARE, OBSERVED_SHARE, SHAPED_RATIO = 0.6, 0.7, 0.2
OBSERVER = (0.8, 20.0)  # assumed over true motor inertia, and gain [1/s]
SHARES = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # share of the observed friction that is compensated


def _bristles(coulomb_nm: float, viscous: float = 0.0) -> CompensatorSettings:
    return competitors.LugreCompensation(coulomb_nm=coulomb_nm, breakaway_nm=coulomb_nm, viscous_nms_per_rad=viscous)


Modelled = Callable[[float, float], CompensatorSettings]  # Coulomb and viscous friction -> compensator


def _model_based(name: str, label: str, law: Modelled, meaning: str, other: Callable[[Joint], Any]) -> Method:
    """Return a method whose tunings have the true Coulomb and viscous friction times a scale, or another arm's."""

    def at(scale: float) -> Tuning:
        words = f"{100 * (scale - 1):+.0f} %", f"friction {scale:g} times the true one"
        return Tuning(
            *(("right", "the true friction") if scale == 1.0 else words),
            lambda joint: law(scale * joint.parameters.coulomb_nm, scale * joint.parameters.viscous_nms_per_rad),
        )

    another = Tuning("another arm", meaning, other)
    sweep = Sweep("scaled", "modelled over true friction", SCALES, at)
    return Method(name, label, at(MODELLED_SHARE), others=(another, at(1.0), at(0.8), at(1.2)), sweeps=(sweep,))


def _observer(inertia_ratio: float, gain_per_s: float, share: float = 1.0) -> Tuning:
    return Tuning(
        f"{inertia_ratio:g} B, {gain_per_s:.3g} 1/s, {100 * share:.0f} %",
        f"motor inertia {inertia_ratio:g} times the true one, observer gain {gain_per_s:.3g} 1/s, {share:g} of "
        "what is observed compensated",
        lambda joint: competitors.DisturbanceObserver(
            inertia_kg_m2=inertia_ratio * joint.parameters.inertia_kg_m2,
            observer_gain_per_s=gain_per_s,
            compensation_gain=share,
        ),
    )


def _regulation(gain: float) -> Tuning:
    """Return a torque regulation by its torque gain B / B_theta - 1."""
    ratio = 1.0 / (1.0 + gain)
    return Tuning(
        f"B_theta = {ratio:.2g} B",
        f"desired motor inertia {ratio:.2g} times the true one",
        lambda joint: competitors.TorqueRegulation(
            inertia_kg_m2=joint.parameters.inertia_kg_m2,
            desired_inertia_kg_m2=joint.parameters.inertia_kg_m2 / (1.0 + gain),
        ),
    )


def _energy(window: float) -> Tuning:
    return Tuning(
        f"k = {window:g}",
        f"estimated from {window:g} cycles",
        lambda joint: EnergyCompensator(window=int(window), payback_s=joint.payback_s),
    )


# A compensator without torque, which detects the cycles.
IDLE = competitors.FixedCompensation(coulomb_nm=0.0, viscous_nms_per_rad=0.0)
NO_COMPENSATION = Tuning("none", "no compensation", lambda _: IDLE, limited=False)
OBSERVER_SWEEPS = (
    Sweep("share", "share of the observed friction", SHARES, partial(_observer, *OBSERVER)),
    *(
        Sweep(f"{ratio:g} B", "observer gain [1/s]", OBSERVER_GAINS_PER_S, partial(_observer, ratio))
        for ratio in INERTIA_RATIOS
    ),
)
GAINS = tuple(1.0 / ratio - 1.0 for ratio in SHAPED_RATIOS)
# In the order of the paper's figures, the oracle last.
METHODS: tuple[Method, ...] = (
    Method(NONE, "none", NO_COMPENSATION),
    _model_based(
        "sigmoid", "model-based",
        lambda coulomb, viscous: competitors.fit_sigmoid(coulomb, viscous, TOP_SPEED_RAD_S),
        "as published for another Panda", lambda joint: competitors.PANDA_SIGMOIDS[joint.column],
    ),
    _model_based(
        "lugre", "LuGre", _bristles, "plateaus as published for another Panda",
        lambda joint: _bristles(sum(competitors.PANDA_SIGMOIDS[joint.column].plateaus_nm) / 2),
    ),
    Method(
        "disturbance_observer", "disturbance observer", _observer(*OBSERVER, OBSERVED_SHARE),
        full=_observer(*OBSERVER), sweeps=OBSERVER_SWEEPS,
    ),
    Method(
        "torque_regulation", "torque regulation", _regulation(1.0 / SHAPED_RATIO - 1.0),
        sweeps=(Sweep("B_theta", "torque gain $B / B_\\theta - 1$", GAINS, _regulation),),
    ),
    Method(
        "energy", "proposed (energy)", _energy(2.0),
        others=(_energy(4.0),), sweeps=(Sweep("k", "cycles per estimate $k$", WINDOWS, _energy),),
    ),
    Method(
        "oracle", "oracle",
        Tuning(
            "true friction", "given the true Coulomb and viscous friction",
            lambda joint: competitors.FixedCompensation(
                coulomb_nm=joint.parameters.coulomb_nm, viscous_nms_per_rad=joint.parameters.viscous_nms_per_rad
            ),
            limited=False,
        ),
    ),
)  # fmt: skip

# In a rigid joint only the controller's tick would limit the gains of torque and motion feedback.
_ELASTIC = Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=1e-4, damping_ratio=0.1))


@dataclass(frozen=True, kw_only=True, slots=True)
class Setup:
    """Simulated joint or arm on which methods are compared, and the extent of the comparison."""

    name: str  # as in options and documents
    settings: BenchSettings | ArmSettings  # settings of the simulation, without a compensator
    tuning_seeds: int  # number of persons in the sweeps; none of them is reported
    most_values: int  # largest number of values of a sweep, evenly chosen
    sweeps: int  # number of sweeps of a method
    with_others: bool  # whether tunings of role OTHER are reported
    margin_seeds: int  # number of reported persons with stability margins
    margin_share: float  # duration of a trial for the stability margin, over that of a reported trial

    def compensated(self, tuning: Tuning, factor: float | None = None) -> BenchSettings | ArmSettings:
        """Return the settings with a compensator in every joint, its gains times a factor if given."""
        gears = (hidden.joint_elasticity for hidden in self.settings.hidden)
        joints = list(map(panda_joint, count(), self.settings.joints, gears))
        made = tuple(replace(tuning.make(joint), **(joint.limits if tuning.limited else {})) for joint in joints)
        made = made if factor is None else tuple(one.scaled(factor) for one in made)
        if isinstance(self.settings, BenchSettings):
            return replace(self.settings, compensator=made[0])
        return replace(self.settings, compensator=made)


SETUPS: tuple[Setup, ...] = (
    Setup(
        name="joint",  # joint 1 of a Panda, elastic, moved by a person
        settings=BenchSettings(joints=(PANDA_JOINTS[0],), hidden=(_ELASTIC,), duration_s=40.0),
        tuning_seeds=5, most_values=10, sweeps=5, with_others=True, margin_seeds=20, margin_share=0.5,
    ),
    Setup(
        name="panda",  # its joints elastic, guided by a hand
        settings=ArmSettings(hidden=(_ELASTIC,) * len(PANDA_JOINTS), duration_s=30.0),
        tuning_seeds=5, most_values=5, sweeps=2, with_others=False, margin_seeds=6, margin_share=0.6,
    ),
)  # fmt: skip
