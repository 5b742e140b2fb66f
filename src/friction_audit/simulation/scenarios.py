"""Scenarios: settings with a name; and the simulation of any settings."""

from dataclasses import dataclass, replace

from friction_audit.compensation.competitors import FixedCompensation
from friction_audit.compensation.law import NO_RIDGE, Coefficients, EnergyCompensator
from friction_audit.errors import UsageError, near_misses
from friction_audit.simulation import settings as shared
from friction_audit.simulation.arm import ArmSettings
from friction_audit.simulation.bench import BenchSettings, HandGuidedPanda, Operator, Progress
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.slow_and_events import FrictionStep
from friction_audit.simulation.effects.structure import JointElasticity
from friction_audit.simulation.periodic import Commanded, Sinusoid
from friction_audit.simulation.sensors import read_log
from friction_audit.simulation.strokes import SlowSweep, StopAndGo

AnySettings = BenchSettings | HandGuidedPanda | ArmSettings


@dataclass(frozen=True, slots=True)
class Scenario:
    """A situation that can be simulated by its name."""

    name: str  # as on the command line
    summary: str  # one line
    settings: AnySettings  # what is simulated; every number of it can be set


# Rotary friction that stands for 1 Ns/mm of the paper, on a lever of sqrt(1e-5) m = 3.2 mm: 10 Ns/mm are then
# 0.10 N m s/rad, about what a joint of a Panda has. Every claim is a ratio and would hold with any other factor.
NMS_PER_RAD_OF_NS_PER_MM = 0.01

_TEN, _TWENTY, _THIRTY = (ns_per_mm * NMS_PER_RAD_OF_NS_PER_MM for ns_per_mm in (10.0, 20.0, 30.0))

# A firm grip: the turning points are then those of the intended sinusoid to within two ticks for any friction.
_FIRM_HAND = Operator(
    stiffness_nm_per_rad=400.0, damping_nms_per_rad=8.0, motion=Sinusoid(amplitude_rad=0.5, period_s=4.0)
)

# Critically damped: what jumps at the turning points of Fig. 9 is friction, and the hand does not ring.
_DAMPED_HAND = replace(_FIRM_HAND, damping_nms_per_rad=30.0)


def _sinusoidal(viscous: float, duration_s: float, coulomb_nm: float = 0.0) -> BenchSettings:
    """Return an ideal joint with a sinusoidal operator; every 2 s an energy cycle ends."""
    joint = shared.JointParameters(coulomb_nm=coulomb_nm, viscous_nms_per_rad=viscous)
    return BenchSettings(joints=(joint,), sensors=(shared.IDEAL_SENSORS,), operator=_FIRM_HAND, duration_s=duration_s)


_VISCOUS_ONLY = EnergyCompensator(model="viscous", zero_crossings=True)
# Applies 30 Ns/mm from the second cycle on, until its passivity controller has acted. The joint is rigid, and nothing
# rings: the deficit is paid within a tick, as (22) has it, and the damping only has to stay below inertia over tick.
_FORCED = Coefficients(viscous_nms_per_rad=_THIRTY)
_OVER_COMPENSATION = replace(_VISCOUS_ONLY, forced=_FORCED, payback_s=0.0, max_damping_nms_per_rad=50.0)

# Coulomb friction and sensors of a Panda's joint 1. Its published viscous friction (0.075 N m s/rad) cannot give the
# 1.5 N m of Fig. 8(c) at any speed the joint reaches, and no compensator that acts on the velocity lowers the torque
# that breaks it away; viscous friction, inertia and strokes are chosen so that the peak is 1.5 N m.
_PERSON = Operator(
    motion=StopAndGo(stroke_s=(1.8, 3.0), speed_rad_s=1.0, speed_limits_rad_s=(0.3, 1.6), range_rad=(-1.5, 1.5))
)

# The paper's experiment ran on a real Panda, whose torque noise was measured to be white; the part that wanders slowly
# is an assumption of the other scenarios.
_AS_MEASURED = replace(shared.PANDA_SENSORS[0], slow_noise_share=0.0)


def _experiment(compensator: EnergyCompensator | None, sensors: shared.Sensors = _AS_MEASURED) -> BenchSettings:
    joint = shared.JointParameters(inertia_kg_m2=0.15, coulomb_nm=0.311, viscous_nms_per_rad=0.6)
    return BenchSettings(
        joints=(joint,), sensors=(sensors,), operator=_PERSON, compensator=compensator, duration_s=40.0
    )


_COMBINED_OF_TWO = EnergyCompensator(model="combined", window=2)
_DOUBLES_AT_6_S = Hidden(friction_step=FrictionStep(change=1.0, at_share=0.6))
_COULOMB_NM = 0.3
_TRUE_VALUES = FixedCompensation(coulomb_nm=_COULOMB_NM, viscous_nms_per_rad=_TEN, dead_band_rad_s=0.0)

# The figures of the paper, in their order.
PAPER_SCENARIOS: tuple[Scenario, ...] = (
    Scenario(
        "fig3", "viscous friction, without compensation: the energy that a person puts in",
        _sinusoidal(_TEN, 8.0),
    ),
    Scenario(
        "fig6", "viscous friction that doubles at 6 s, compensated by its estimate",
        replace(_sinusoidal(_TEN, 10.0), compensator=_VISCOUS_ONLY, hidden=(_DOUBLES_AT_6_S,)),
    ),
    Scenario(
        "fig7-unprotected", "viscous friction compensated by half as much again, without passivity controller",
        replace(_sinusoidal(_TWENTY, 10.0), compensator=replace(_OVER_COMPENSATION, passivity=False)),
    ),
    Scenario(
        "fig7", "viscous friction compensated by half as much again, until the passivity controller acts",
        replace(_sinusoidal(_TWENTY, 10.0), compensator=_OVER_COMPENSATION),
    ),
    Scenario(
        "fig8", "a joint as in the paper's experiment, moved by a person, without compensation",
        _experiment(None),
    ),
    Scenario(
        "fig9-friction", "Coulomb and viscous friction, without compensation: plateaus over the velocity",
        replace(_sinusoidal(_TEN, 8.0, _COULOMB_NM), operator=_DAMPED_HAND),
    ),
    Scenario(
        "fig9-compensated",
        "Coulomb and viscous friction compensated by their true values: an ellipse over the velocity",
        replace(_sinusoidal(_TEN, 8.0, _COULOMB_NM), compensator=_TRUE_VALUES, operator=_DAMPED_HAND),
    ),
    Scenario(
        "fig10", "the same, combined friction compensated from the last two cycles",
        _experiment(_COMBINED_OF_TWO),
    ),
    Scenario(
        "fig10-published", "the same, by (20) as printed instead of a ridge regression towards the coefficients in use",
        _experiment(replace(_COMBINED_OF_TWO, ridge=NO_RIDGE)),
    ),
    Scenario(
        "fig10-slow-noise", "the same, a tenth of the variance of the torque noise wandering over 50 ms",
        _experiment(_COMBINED_OF_TWO, shared.PANDA_SENSORS[0]),
    ),
    Scenario(
        "fig12", "a Panda guided by a hand, all joints compensated from the last two cycles of the hand",
        ArmSettings(compensator=_COMBINED_OF_TWO, duration_s=30.0),
    ),
    Scenario(
        "fig13", "a Panda guided by the same hand, without compensation: what methods are compared with",
        ArmSettings(duration_s=30.0),
    ),
)  # fmt: skip


def with_torque_control(joint: shared.JointParameters) -> shared.JointParameters:
    """Return a joint with torque control and so much friction in its motor that the link feels what it did without."""
    felt = 1.0 + TORQUE_LOOP.gain
    friction = {"coulomb_nm": felt * joint.coulomb_nm, "viscous_nms_per_rad": felt * joint.viscous_nms_per_rad}
    return replace(joint, **friction, torque_loop=TORQUE_LOOP)


# A dead time of half a tick of the outer controller, and four times the damping at which the loop rings without end.
TORQUE_LOOP = shared.TorqueLoop(gain=4.0, damping_s=0.008, dead_time_s=0.0005)
_SERVO = Operator(stiffness_nm_per_rad=2000.0, damping_nms_per_rad=60.0, motion=Commanded())
_SOFT = Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=1e-4, damping_ratio=0.1))

_ONE_JOINT = (
    Scenario("joint", "one joint moved by hand, stop and go; a rig logs the interaction torque", BenchSettings()),
    Scenario(
        "joint-sine", "one joint moved by hand along a sinusoid of varying width",
        BenchSettings(operator=Operator(motion=Sinusoid(spread=0.3)), duration_s=60.0),
    ),
    Scenario(
        "joint-slow", "one joint moved by hand at slow, steady speeds, with small reversals",
        BenchSettings(operator=Operator(motion=SlowSweep(reversals=12)), duration_s=180.0),
    ),
    Scenario(
        "joint-controlled", "one elastic joint moved by hand, whose torque control leaves a fifth of its friction",
        BenchSettings(joints=(with_torque_control(shared.JointParameters()),), hidden=(_SOFT,)),
    ),
    Scenario(
        "joint-loaded", "one joint moved by hand that carries a lever of 10 N m; logs the sensor's torque and gravity",
        BenchSettings(gravity_nm=10.0, logs_sensor=True),
    ),
    Scenario(
        "joint-driven", "one joint moved by its motor along a sum of sines, a lever of 10 N m on it; without contact",
        BenchSettings(operator=_SERVO, driven=True, gravity_nm=10.0, logs_sensor=True),
    ),
)  # fmt: skip

_PANDA = (
    Scenario("panda-joint", "a Panda whose joint 1 is moved by hand while the others stand still", HandGuidedPanda()),
    Scenario("panda", "a Panda guided by the hand at its flange, all joints moving", ArmSettings()),
    Scenario(
        "panda-driven", "a Panda that moves by itself, every joint along a sum of sines; without contact",
        ArmSettings(driven=True),
    ),
)  # fmt: skip

SCENARIOS: tuple[Scenario, ...] = (*_ONE_JOINT, *_PANDA, *PAPER_SCENARIOS)


def find_scenario(name: str | None) -> Scenario:
    """Return the scenario of a name; UsageError names all of them."""
    named = {one.name: one for one in SCENARIOS}
    if name not in named:
        found = "SCENARIO: missing" if name is None else f"{name}: no such scenario"
        raise UsageError(f"{found}; expected one of {', '.join(named)}{near_misses(name or '', named)}")
    return named[name]


def simulate(
    settings: AnySettings, seed: int, *, path: str = "simulation", progress: Progress | None = None
) -> shared.Simulation:
    """Simulate a recording, with a path for its source; the same settings and seed give the same log to the bit."""
    streams = shared.make_streams(seed, len(settings.joints))
    moved = settings.move(streams, path, progress)
    truth = shared.Truth(settings=settings, seed=seed, motion=moved.motion, compensators=moved.compensators)
    return shared.Simulation(log=read_log(settings, moved, streams, path), truth=truth)
