"""The scenarios that have a name."""

from friction_audit.simulate.arm import ArmSettings
from friction_audit.simulate.bench import BenchSettings
from friction_audit.simulate.motion import Commanded, Sinusoid, SlowSweep
from friction_audit.simulate.operator import Operator
from friction_audit.simulate.panda_joint import HandGuidedPanda
from friction_audit.simulate.paper_scenarios import PAPER_SCENARIOS
from friction_audit.simulate.scenario import Scenario

_SERVO = Operator(stiffness_nm_per_rad=2000.0, damping_nms_per_rad=60.0, motion=Commanded())

_ONE_JOINT = (
    Scenario(
        name="joint",
        summary="one joint moved by hand, stop and go; a rig logs the interaction torque",
        settings=BenchSettings(),
    ),
    Scenario(
        name="joint-sine",
        summary="one joint moved by hand along a sinusoid of varying width",
        settings=BenchSettings(operator=Operator(motion=Sinusoid(spread=0.3)), duration_s=60.0),
    ),
    Scenario(
        name="joint-slow",
        summary="one joint moved by hand at slow, steady speeds, with small reversals",
        settings=BenchSettings(operator=Operator(motion=SlowSweep(reversals=12)), duration_s=180.0),
    ),
    Scenario(
        name="joint-loaded",
        summary="one joint moved by hand that carries a lever of 10 N m; logs the sensor's torque and gravity",
        settings=BenchSettings(gravity_nm=10.0, logs_sensor=True),
    ),
    Scenario(
        name="joint-driven",
        summary="one joint moved by its motor along a sum of sines, a lever of 10 N m on it; nobody touches it",
        settings=BenchSettings(operator=_SERVO, driven=True, gravity_nm=10.0, logs_sensor=True),
    ),
)

_PANDA = (
    Scenario(
        name="panda-joint",
        summary="a Panda whose joint 1 is moved by hand while the others stand still",
        settings=HandGuidedPanda(),
    ),
    Scenario(
        name="panda", summary="a Panda guided by the hand at its flange, all joints moving", settings=ArmSettings()
    ),
    Scenario(
        name="panda-driven",
        summary="a Panda that moves by itself, every joint along a sum of sines; nobody touches it",
        settings=ArmSettings(driven=True),
    ),
)

SCENARIOS: tuple[Scenario, ...] = (*_ONE_JOINT, *_PANDA, *PAPER_SCENARIOS)
"""All scenarios, in the order of the help text."""
