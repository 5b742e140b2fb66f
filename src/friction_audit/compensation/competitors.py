"""Compensators other than the paper's: feedforward of a friction model, or feedback of velocity and torque.

C. Gaz, M. Cognetti, A. Oliva, P. Robuffo Giordano, A. De Luca: Dynamic identification of the Franka Emika Panda robot
with retrieval of feasible parameters using penalty-based optimization, IEEE Robotics and Automation Letters 4(4), 2019.
The paper calls its sigmoid LuGre; it has no state and no viscous term of its own: "Gaz sigmoidal (static)".

C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky: A new model for control of systems with friction, IEEE
Transactions on Automatic Control 40(3), 1995. Passivity: N. Barahanov, R. Ortega, Necessary and sufficient conditions
for passivity of the LuGre friction model, IEEE Transactions on Automatic Control 45(4), 2000.

L. Le Tien, A. Albu-Schaeffer, A. De Luca, G. Hirzinger: Friction observer and compensation for control of robots with
joint torque measurement, IEEE/RSJ International Conference on Intelligent Robots and Systems, 2008.

A. Albu-Schaeffer, C. Ott, G. Hirzinger: A unified passivity-based control framework for position, torque and impedance
control of flexible joint robots, International Journal of Robotics Research 26(1), 2007.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, replace
from typing import Any, NamedTuple, Self, get_args

import numpy as np

from friction_audit.compensation.law import FINITE, CompensatorSettings, EnergyCompensator, positive, soft_sign, within
from friction_audit.compiled import Record, compiled
from friction_audit.dynamics.bristles import advance_bristles, bristle_damping, bristle_nm
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.dynamics.torque_tables import Tables, lookup_nm, tabulate
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution


class FixedCompensation(CompensatorSettings):
    """Constant coefficients: u = coulomb sgn(dq) + viscous dq outside the dead-band, else 0."""

    name, gains = "fixed", ("coulomb_nm", "viscous_nms_per_rad")
    summary = "given Coulomb and viscous friction; the true ones make it an oracle"

    coulomb_nm: float = within(MISSING, -FINITE)  # Coulomb friction compensated [N m]
    viscous_nms_per_rad: float = within(MISSING, -FINITE)  # viscous friction compensated [N m s/rad]
    dead_band_rad_s: float = within(0.02)  # speed up to which u = 0 [rad/s]


class SigmoidCompensation(CompensatorSettings):
    """u = phi1 / (1 + exp(-phi2 (dq + phi3))) - phi1 / (1 + exp(-phi2 phi3)).

    It is smooth at standstill, where its slope is at most phi1 phi2 / 4: this slope amplifies velocity noise, while a
    sign function would amplify it to the whole plateau.
    """

    name, gains = "sigmoid", ("height_nm",)
    summary = "model-based, Gaz sigmoidal (static): a sigmoid of the velocity"

    height_nm: float = positive(MISSING)  # phi1, difference of the plateaus [N m]
    steepness_s_per_rad: float = positive(MISSING)  # phi2 [s/rad]
    shift_rad_s: float = within(0.0, -FINITE)  # phi3, makes the plateaus unequal [rad/s]

    @property
    def plateaus_nm(self) -> tuple[float, float]:
        """Friction at high speed in the positive and in the negative direction, both above zero. [N m]"""
        backward = self.height_nm / (1.0 + math.exp(-self.steepness_s_per_rad * self.shift_rad_s))
        return self.height_nm - backward, backward


# Joints 1 to 7 of a Panda, as published.
PANDA_SIGMOIDS = (
    SigmoidCompensation(height_nm=0.54615, steepness_s_per_rad=5.1181, shift_rad_s=0.039533),
    SigmoidCompensation(height_nm=0.87224, steepness_s_per_rad=9.0657, shift_rad_s=0.025882),
    SigmoidCompensation(height_nm=0.64068, steepness_s_per_rad=10.136, shift_rad_s=-0.04607),
    SigmoidCompensation(height_nm=1.2794, steepness_s_per_rad=5.590, shift_rad_s=0.036194),
    SigmoidCompensation(height_nm=0.83904, steepness_s_per_rad=8.3469, shift_rad_s=0.026226),
    SigmoidCompensation(height_nm=0.30301, steepness_s_per_rad=17.133, shift_rad_s=-0.021047),
    SigmoidCompensation(height_nm=0.56489, steepness_s_per_rad=10.336, shift_rad_s=0.0035526),
)

STEEPNESS_S_PER_RAD = 9.0657  # steepness of a fitted sigmoid: median of the published ones


def fit_sigmoid(coulomb_nm: float, viscous_nms_per_rad: float, top_speed_rad_s: float = 1.0) -> SigmoidCompensation:
    """Fit a sigmoid to Coulomb and viscous friction at speeds up to a highest one, by least squares.

    The steepness is not fitted: towards a step it has no bound, and it amplifies velocity noise.
    """
    speed = np.linspace(0.0, top_speed_rad_s, 401)[1:]
    friction, shape = coulomb_nm + viscous_nms_per_rad * speed, np.tanh(STEEPNESS_S_PER_RAD * speed / 2)
    if not (coulomb_nm >= 0 and viscous_nms_per_rad >= 0 and friction[-1] > 0):
        raise UsageError(
            f"sigmoid compensation: Coulomb {coulomb_nm:g}, viscous {viscous_nms_per_rad:g}: expected friction above "
            "zero"
        )
    height = 2 * float(shape @ friction / (shape @ shape))
    return SigmoidCompensation(height_nm=height, steepness_s_per_rad=STEEPNESS_S_PER_RAD)


@compiled(inline=True)
def sigmoid_nm(group: Record, dq: float) -> float:
    """Return the torque that aids the motion. [N m]"""
    at_rest = 1.0 / (1.0 + math.exp(-group.steepness_s_per_rad * group.shift_rad_s))
    moving = 1.0 / (1.0 + math.exp(-group.steepness_s_per_rad * (dq + group.shift_rad_s)))
    return float(group.height_nm * (moving - at_rest))


class LugreCompensation(CompensatorSettings):
    """u = sigma0 z + sigma1 dz/dt + sigma2 dq, with dz/dt = dq - sigma0 |dq| z / g(dq).

    g(dq) = Fc + (Fs - Fc) exp(-(dq/vs)^2). At standstill the bristles hold their torque; per tick it changes by at most
    sigma0 times the displacement, so that velocity noise causes no chatter.
    """

    name, summary = "lugre", "model-based, LuGre: bristles that bend and slip"
    gains = ("coulomb_nm", "breakaway_nm", "viscous_nms_per_rad", "stiffness_nm_per_rad", "damping_nms_per_rad")

    coulomb_nm: float = positive(MISSING)  # Fc [N m]
    breakaway_nm: float = within(MISSING)  # Fs [N m]
    viscous_nms_per_rad: float = within(MISSING)  # sigma2 [N m s/rad]
    stribeck_rad_s: float = positive(0.05)  # vs [rad/s]
    stiffness_nm_per_rad: float = positive(300.0)  # sigma0 [N m/rad]
    damping_nms_per_rad: float = within(0.0)  # sigma1 [N m s/rad]

    def __post_init__(self) -> None:
        CompensatorSettings.__post_init__(self)
        if self.breakaway_nm < self.coulomb_nm:
            found = f"breakaway_nm {self.breakaway_nm:g}"
            raise UsageError(f"lugre_compensation: {found}: expected coulomb_nm {self.coulomb_nm:g} or more")


@compiled(inline=True)
def stribeck_nm(group: Record, dq: float) -> float:
    """Return g(dq), the friction of steady sliding without its viscous part. [N m]"""
    ratio = dq / group.stribeck_rad_s
    return float(group.coulomb_nm + (group.breakaway_nm - group.coulomb_nm) * math.exp(-ratio * ratio))


@compiled(inline=True)
def update_bristles(group: Record, state: Record, dq: float, dt: float) -> None:
    """Integrate the bristle deflection over the interval before this tick, exactly for the mean of both velocities.

    An explicit step is unstable where sigma0 |dq| dt > 2 g, which the speeds of an arm reach.
    """
    mean = 0.5 * (state.dq + dq)
    level = stribeck_nm(group, mean)
    steady = math.copysign(level / group.stiffness_nm_per_rad, mean)
    share = -math.expm1(-group.stiffness_nm_per_rad * abs(mean) * dt / level)
    state.deflection_rad += share * (steady - state.deflection_rad)


@compiled(inline=True)
def lugre_nm(group: Record, state: Record, dq: float) -> float:
    """Return the torque that aids the motion. [N m]"""
    rate = dq - group.stiffness_nm_per_rad * abs(dq) * state.deflection_rad / stribeck_nm(group, dq)
    elastic = group.stiffness_nm_per_rad * state.deflection_rad
    return float(elastic + group.damping_nms_per_rad * rate + group.viscous_nms_per_rad * dq)


class JointModelCompensation(CompensatorSettings):
    """Feedforward of the friction terms of a joint's model, in place of the friction of the log.

    Only a replay runs it, because the replay evaluates the terms at every tick. As in the compensator of the paper, dry
    friction is zero up to ``dead_band_rad_s`` and rises over the next ``ramp_rad_s``. Bristles have no sign function
    and are applied at any speed.
    """

    name, summary = "joint_model", "model-based: the terms of friction of a joint's model"

    terms: tuple[FittedTerm, ...]  # of friction, at least one
    dead_band_rad_s: float = within(0.01)  # speed up to which dry friction is zero [rad/s]
    ramp_rad_s: float = within(0.03)  # range of speed over which it then rises to all of it [rad/s]


class DisturbanceObserver(CompensatorSettings):
    """u = gain times the observed friction, whose rate is L (F_m + u - B ddq - observed friction).

    In the dead-band u = 0 while the observer runs on: it integrates noise and bias, whose torque would release a joint
    that sticks, and the joint would hunt.
    """

    name, gains = "disturbance_observer", ("observer_gain_per_s",)
    summary = "friction observed as what the motor's dynamics do not explain"

    inertia_kg_m2: float = within(MISSING)  # motor inertia B as assumed [kg m^2]
    observer_gain_per_s: float = positive(MISSING)  # L, bandwidth of the observer [1/s]
    compensation_gain: float = positive(1.0, high=1.0)  # share of the observed friction that is compensated
    dead_band_rad_s: float = within(0.01)  # speed up to which u = 0 [rad/s]
    # range of speed over which u then rises to its full value; with dead-band and ramp 0 as published [rad/s]
    ramp_rad_s: float = within(0.03)


@compiled(inline=True)
def update_observer(group: Record, state: Record, dq: float, interaction_nm: float, dt: float) -> None:
    """Integrate the observer over the interval before this tick, exactly for constant friction and F_m of its end."""
    residual = interaction_nm + state.u_nm - group.inertia_kg_m2 * (dq - state.dq) / dt
    state.observed_friction_nm -= math.expm1(-group.observer_gain_per_s * dt) * (residual - state.observed_friction_nm)


@compiled(inline=True)
def observer_nm(group: Record, state: Record, dq: float) -> float:
    """Return the torque that cancels the observed friction. [N m]"""
    share = 1.0
    if group.dead_band_rad_s + group.ramp_rad_s > 0.0:
        share = abs(soft_sign(dq, group.dead_band_rad_s, group.ramp_rad_s))
    return float(share * group.compensation_gain * state.observed_friction_nm)


class TorqueRegulation(CompensatorSettings):
    """u = (B / B_theta - 1) F_m, so that B_theta ddq = F_m - (B_theta / B) tau_f; it does not chatter at standstill."""

    name = "torque_regulation"
    summary = "torque feedback that makes motor inertia and friction smaller"

    inertia_kg_m2: float = positive(MISSING)  # motor inertia B as assumed [kg m^2]
    desired_inertia_kg_m2: float = positive(MISSING)  # B_theta; above B the inertia increases [kg m^2]
    cutoff_hz: float = positive(math.inf, high=math.inf)  # corner of the first-order low-pass on F_m, or infinite [Hz]

    def scaled(self, factor: float) -> Self:
        """Return the compensator with its torque gain B / B_theta - 1 times a factor."""
        gain = factor * (self.inertia_kg_m2 / self.desired_inertia_kg_m2 - 1.0)
        return replace(self, desired_inertia_kg_m2=self.inertia_kg_m2 / (1.0 + gain))


# The compensator of one joint; None where none runs.
Compensator = (
    FixedCompensation
    | EnergyCompensator
    | SigmoidCompensation
    | LugreCompensation
    | DisturbanceObserver
    | TorqueRegulation
    | JointModelCompensation
)

# In the order of the documentation and of the codes in ``law``, from 1 on.
COMPENSATORS: tuple[type[Any], ...] = get_args(Compensator)

# Feedforward of the friction terms of a joint's model, and which terms can run in the loop of a replay.

NOT_RUNNABLE: Mapping[str, str] = {  # terms that need an input which the loop does not have, and the reason's code
    **dict.fromkeys(("stiction", "frictional_lag"), "past"),
    **dict.fromkeys(("joint_elasticity", "backlash"), "two_sides"),
    **dict.fromkeys(("torque_crosstalk", "inertial_coupling"), "neighbours"),
    "load_dependent_friction": "load",
    "time_delay": "late",
}
# Terms that count as friction although a part of their work alone may be returned.
FRICTION_TERMS = (
    *("asymmetric_coulomb", "asymmetric_viscous", "presliding"),
    *("stiction", "frictional_lag", "load_dependent_friction"),
)


class Feedforward(NamedTuple):
    """Friction torque as tables, and the bristles of the controller."""

    tables: Tables
    deflections: Float  # state of the bristles, shape (1 + m,); updated


def extrapolate_speed(tables: Tables, *, damping_nms_per_rad: float = 0.0) -> Tables:
    """Extrapolate tables over speed, because a compensated joint is faster than a recorded one, and add a damper.

    The last slope over speed becomes a torque proportional to the speed; the rest of the table is level at its end.
    """
    speeds = np.asarray(tables.speed_step * np.arange(tables.speed.shape[1]), np.float64)
    slope = (tables.speed[:, -1] - tables.speed[:, -2]) / tables.speed_step
    damped = slope + damping_nms_per_rad * np.array([1.0, -1.0])
    return tables._replace(
        speed=tables.speed - slope[:, None] * speeds, position_per_speed=tables.position_per_speed + damped[:, None]
    )


def make_feedforward(terms: Sequence[FittedTerm], motion: Motion) -> Feedforward:
    """Return the feedforward of friction terms, before the first tick."""
    tables, past = tabulate(0.0, terms, motion)
    check_runnable((), past)
    return Feedforward(extrapolate_speed(tables), np.zeros(1 + len(tables.bristles.yield_rad)))


@compiled()
def update_feedforward(state: Record, feedforward: Feedforward, q: float, v: float, i: int) -> None:
    """Store the friction torque at sample i in the state of a compensator; later samples are not used."""
    bristles, bent = feedforward.tables.bristles, feedforward.deflections
    if state.ticks > 0:
        advance_bristles(bent, q - state.q_rad, bristles)
    state.q_rad = q
    sign = 1.0 if v >= 0.0 else -1.0
    state.modelled_nm = sign * lookup_nm(sign, q, abs(v), float(i), feedforward.tables)
    state.bristle_nm = bristle_nm(bent, 0.0, bristles) + bristle_damping(bent, sign, bristles) * v


def check_runnable(terms: Sequence[FittedTerm], past: Sequence[Term] = ()) -> None:
    """Raise AnalysisError if terms, or terms that depend on the past, cannot run in the loop; it has the reasons."""
    found = [(term.name, NOT_RUNNABLE.get(term.name, "")) for term in terms]
    for place, term in enumerate(terms):
        if term.numbers.get("gravity_error_source", 0.0) != 0.0:
            found[place] = (term.name, "arm")
        if term.numbers.get("warm_up_per_k", 0.0) != 0.0:
            found[place] = (term.name, "temperature")
    found += [(term.name, "past_here") for term in past]
    reasons = tuple(Caution("not_in_loop", numbers={"name": name, "case": case}) for name, case in found if case)
    if reasons:
        raise AnalysisError((Caution("model_not_run", numbers={"terms": reasons}),))
