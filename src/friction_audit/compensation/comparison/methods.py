"""What a compensation method is, what it may be told, and what is varied to find out how much that matters."""

from collections.abc import Callable
from dataclasses import dataclass

from friction_audit.compensation.compensators import (
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    FixedCompensation,
    Guard,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)
from friction_audit.compensation.compensators.law import payback_s
from friction_audit.compensation.compensators.sigmoid import PUBLISHED, fit_sigmoid
from friction_audit.compensation.settings import limits_of
from friction_audit.simulation.effects.joint_elasticity import JointElasticity
from friction_audit.simulation.settings import JointParameters

# Roles of a tuning: the setting in which the paper's order comes out, the same but for an observer that compensates all
# that it observes, the best stable one of the sweeps, or another. The order model > disturbance observer > torque
# regulation > proposed takes: error of the model > 1 - share of the observer + its lag > B_theta / B > 0.
PAPER, FULL, BEST, OTHER = "paper", "full", "best", "other"


@dataclass(frozen=True, kw_only=True, slots=True)
class Joint:
    """What a method may be told about a joint.

    Attributes:
        column: Which joint of the arm, counted from 0.
        parameters: Motor and friction, as the link truly sees them.
        max_torque_nm: What the joint can give. [N m]
        max_torque_rate_nm_s: How fast it can change. [N m/s]
        payback_s: Time over which a passivity controller may pay without driving its elastic mode. [s]
    """

    column: int
    parameters: JointParameters
    max_torque_nm: float
    max_torque_rate_nm_s: float
    payback_s: float


def panda_joint(column: int, motor: JointParameters, gear: JointElasticity) -> Joint:
    """Return a joint with the limits of that joint of a Panda, as it is seen from the link.

    Its mode is that of the link held fast, the lowest; torque control of the motor is in mode and damping, its dead
    time to first order.
    """
    known, parameters, loop = Guard().payback_s, motor.at_link, motor.torque_loop
    if gear.compliance_rad_per_nm > 0.0:
        bare = (gear.compliance_rad_per_nm * motor.inertia_kg_m2) ** -0.5
        damping = gear.damping_ratio + 0.5 * bare * (loop.damping_s - loop.gain * loop.dead_time_s)
        if damping > 0.0:
            faster = (1.0 + loop.gain) ** 0.5
            known = payback_s(faster * bare, damping / faster)
    return Joint(
        column=column,
        parameters=parameters,
        max_torque_nm=limits_of("panda", column + 1).torque_nm,
        max_torque_rate_nm_s=limits_of("panda", column + 1).rate_nm_s,
        payback_s=known,
    )


Make = Callable[[Joint], Compensator]  # joint -> compensator


@dataclass(frozen=True, kw_only=True, slots=True)
class Tuning:
    """One way to set a method up.

    Attributes:
        name: Short name.
        meaning: What it means, in words.
        make: Joint -> compensator.
    """

    name: str
    meaning: str
    make: Make


@dataclass(frozen=True, kw_only=True, slots=True)
class Sweep:
    """One setting of a method, varied.

    Attributes:
        name: What all of its tunings share.
        axis: Name of the setting with its unit.
        values: From careful to bold.
        at: Value -> tuning.
    """

    name: str
    axis: str
    values: tuple[float, ...]
    at: Callable[[float], Tuning]


@dataclass(frozen=True, kw_only=True, slots=True)
class Method:
    """A way to compensate friction.

    Attributes:
        name: As in options and documents.
        label: As in tables and figures.
        paper: That of the setting in which the paper's order comes out.
        full: That of the other named setting where it differs, or None.
        others: Further tunings that are reported.
        sweeps: What is varied; the best stable tuning of all sweeps is reported.
    """

    name: str
    label: str
    paper: Tuning
    full: Tuning | None = None
    others: tuple[Tuning, ...] = ()
    sweeps: tuple[Sweep, ...] = ()


NONE = "none"  # the method that everything is held against
TOP_SPEED_RAD_S = 1.5  # up to this speed the sigmoid is fitted to the true friction
SCALES = (0.4, 0.6, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4)  # friction of a model, over the true one
WINDOWS = (2.0, 3.0, 4.0, 6.0, 8.0)  # cycles per estimate
OBSERVER_GAINS_PER_S = (2.0, 5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 120.0, 200.0)
# Motor inertia as assumed, over the true one; the first is the paper's kind, which knows it only about.
INERTIA_RATIOS = (0.8, 1.0, 1.2, 0.5, 1.5)
# Desired motor inertia B_theta over the true one.
SHAPED_RATIOS = (0.7, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.07, 0.05, 0.035)
# The setting in which the paper's order comes out: a model identified on another specimen, an observer that compensates
# a share of what it observes, as keeps a robot stable, and the lightest torque regulation that holds on the arm.
MODELLED_SHARE, OBSERVED_SHARE, SHAPED_RATIO = 0.6, 0.7, 0.2
OBSERVER = (0.8, 20.0)  # its motor inertia over the true one, and its gain [1/s]
SHARES = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # of the observed friction, compensated


def _guard(joint: Joint) -> Guard:
    return Guard(max_torque_nm=joint.max_torque_nm, max_torque_rate_nm_s=joint.max_torque_rate_nm_s)


def _idle(joint: Joint) -> Compensator:  # noqa: ARG001 - what every tuning takes
    """Return a compensator that does nothing, but counts the cycles."""
    return FixedCompensation(coulomb_nm=0.0, viscous_nms_per_rad=0.0)


def _oracle(joint: Joint) -> Compensator:
    true = joint.parameters
    return FixedCompensation(coulomb_nm=true.coulomb_nm, viscous_nms_per_rad=true.viscous_nms_per_rad)


def _published(joint: Joint) -> SigmoidCompensation:
    law = PUBLISHED[joint.column]
    return SigmoidCompensation(
        height_nm=law.height_nm,
        steepness_s_per_rad=law.steepness_s_per_rad,
        shift_rad_s=law.shift_rad_s,
        guard=_guard(joint),
    )


def _sigmoid(scale: float) -> Tuning:
    def make(joint: Joint) -> Compensator:
        true = joint.parameters
        law = fit_sigmoid(scale * true.coulomb_nm, scale * true.viscous_nms_per_rad, top_speed_rad_s=TOP_SPEED_RAD_S)
        return SigmoidCompensation(
            height_nm=law.height_nm, steepness_s_per_rad=law.steepness_s_per_rad, guard=_guard(joint)
        )

    return _modelled(scale, make)


def _lugre(scale: float) -> Tuning:
    def make(joint: Joint) -> Compensator:
        true = joint.parameters
        return _bristles(joint, scale * true.coulomb_nm, scale * true.viscous_nms_per_rad)

    return _modelled(scale, make)


def _bristles(joint: Joint, coulomb_nm: float, viscous_nms_per_rad: float) -> LugreCompensation:
    return LugreCompensation(
        coulomb_nm=coulomb_nm,
        breakaway_nm=coulomb_nm,
        viscous_nms_per_rad=viscous_nms_per_rad,
        guard=_guard(joint),
    )


def _lugre_of_another_arm(joint: Joint) -> Compensator:
    return _bristles(joint, sum(PUBLISHED[joint.column].plateaus_nm) / 2, 0.0)


def _modelled(scale: float, make: Make) -> Tuning:
    name = "right" if scale == 1.0 else f"{100 * (scale - 1):+.0f} %"
    meaning = "the true friction" if scale == 1.0 else f"friction {scale:g} times the true one"
    return Tuning(name=name, meaning=meaning, make=make)


def _observer(inertia_ratio: float, gain_per_s: float, share: float = 1.0) -> Tuning:
    def make(joint: Joint) -> Compensator:
        return DisturbanceObserver(
            inertia_kg_m2=inertia_ratio * joint.parameters.inertia_kg_m2,
            observer_gain_per_s=gain_per_s,
            compensation_gain=share,
            guard=_guard(joint),
        )

    return Tuning(
        name=f"{inertia_ratio:g} B, {gain_per_s:.3g} 1/s, {100 * share:.0f} %",
        meaning=f"motor inertia {inertia_ratio:g} times the true one, observer gain {gain_per_s:.3g} 1/s, {share:g} of "
        "what is observed compensated",
        make=make,
    )


def _observer_sweep(ratio: float) -> Sweep:
    return Sweep(
        name=f"{ratio:g} B",
        axis="observer gain [1/s]",
        values=OBSERVER_GAINS_PER_S,
        at=lambda gain_per_s: _observer(ratio, gain_per_s),
    )


def _regulation(gain: float) -> Tuning:
    """Return a torque regulation by its torque gain B / B_theta - 1."""

    def make(joint: Joint) -> Compensator:
        inertia = joint.parameters.inertia_kg_m2
        return TorqueRegulation(
            inertia_kg_m2=inertia, desired_inertia_kg_m2=inertia / (1.0 + gain), guard=_guard(joint)
        )

    ratio = 1.0 / (1.0 + gain)
    return Tuning(
        name=f"B_theta = {ratio:.2g} B", meaning=f"desired motor inertia {ratio:.2g} times the true one", make=make
    )


def _energy(window: float) -> Tuning:
    def make(joint: Joint) -> Compensator:
        return EnergyCompensator(
            model="combined",
            window=int(window),
            max_torque_nm=joint.max_torque_nm,
            max_torque_rate_nm_s=joint.max_torque_rate_nm_s,
            payback_s=joint.payback_s,
        )

    return Tuning(name=f"k = {window:g}", meaning=f"estimated from {window:g} cycles", make=make)


NO_COMPENSATION = Tuning(name="none", meaning="no compensation", make=_idle)
METHODS: tuple[Method, ...] = (
    Method(name=NONE, label="none", paper=NO_COMPENSATION),
    Method(
        name="sigmoid",
        label="model-based",
        paper=_sigmoid(MODELLED_SHARE),
        others=(
            Tuning(name="another arm", meaning="as published for another Panda", make=_published),
            *(_sigmoid(1.0), _sigmoid(0.8), _sigmoid(1.2)),
        ),
        sweeps=(Sweep(name="scaled", axis="modelled over true friction", values=SCALES, at=_sigmoid),),
    ),
    Method(
        name="lugre",
        label="LuGre",
        paper=_lugre(MODELLED_SHARE),
        others=(
            Tuning(name="another arm", meaning="plateaus as published for another Panda", make=_lugre_of_another_arm),
            *(_lugre(1.0), _lugre(0.8), _lugre(1.2)),
        ),
        sweeps=(Sweep(name="scaled", axis="modelled over true friction", values=SCALES, at=_lugre),),
    ),
    Method(
        name="disturbance_observer",
        label="disturbance observer",
        paper=_observer(*OBSERVER, OBSERVED_SHARE),
        full=_observer(*OBSERVER),
        sweeps=(
            Sweep(
                name="share",
                axis="share of the observed friction",
                values=SHARES,
                at=lambda share: _observer(*OBSERVER, share),
            ),
            *map(_observer_sweep, INERTIA_RATIOS),
        ),
    ),
    Method(
        name="torque_regulation",
        label="torque regulation",
        paper=_regulation(1.0 / SHAPED_RATIO - 1.0),
        sweeps=(
            Sweep(
                name="B_theta",
                axis="torque gain $B / B_\\theta - 1$",
                values=tuple(1.0 / ratio - 1.0 for ratio in SHAPED_RATIOS),
                at=_regulation,
            ),
        ),
    ),
    Method(
        name="energy",
        label="proposed (energy)",
        paper=_energy(2.0),
        others=(_energy(4.0),),
        sweeps=(Sweep(name="k", axis="cycles per estimate $k$", values=WINDOWS, at=_energy),),
    ),
    Method(
        name="oracle",
        label="oracle",
        paper=Tuning(name="true friction", meaning="given the true Coulomb and viscous friction", make=_oracle),
    ),
)
"""In the order of the paper's figures, the oracle last."""
