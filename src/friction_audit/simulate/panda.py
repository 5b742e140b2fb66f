"""A Panda in gravity compensation, one joint moved by hand, the others held by their friction (paper, section V.A)."""

from dataclasses import dataclass, field

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float, JointLog
from friction_audit.robot.arm import load_arm
from friction_audit.simulate.dynamics import Motion, move
from friction_audit.simulate.joint import Truth, make_log
from friction_audit.simulate.sensors import low_pass, quantise, record, sense_torque, sense_velocity
from friction_audit.simulate.settings import PANDA_SENSORS, JointSettings, Sensors

JOINTS = 7
READY_RAD = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)
"""The vendor's ready pose."""

EXTERNAL_CUTOFF_HZ = 100.0
"""Corner of the filter on ``tau_ext_hat_filtered``; the vendor's is not published, this one is an assumption."""

EXTERNAL_STEP_NM = 1e-3
"""Resolution of ``tau_ext_hat_filtered`` as logged."""

GRAVITY_STEP_NM = 1e-6
"""Resolution of ``gravity`` as logged."""


@dataclass(frozen=True, kw_only=True, slots=True)
class HandGuidedPanda:
    """One joint of a Panda moved by hand.

    Attributes:
        joint: Number of the joint, 1..7.
        moved: That joint, the person and the recording; its sensors give way to those below.
        sensors: The sensors of the seven joints; the recorder is that of the joint moved.
        pose_rad: Pose at the start. [rad]

    Raises:
        UsageError: If there is no such joint, or not seven sensors and angles.
    """

    joint: int = 1
    moved: JointSettings = field(default_factory=JointSettings)
    sensors: tuple[Sensors, ...] = PANDA_SENSORS
    pose_rad: tuple[float, ...] = READY_RAD

    def __post_init__(self) -> None:
        """Check the joint and the number of its neighbours."""
        if not 1 <= self.joint <= JOINTS or {len(self.sensors), len(self.pose_rad)} != {JOINTS}:
            raise UsageError(
                f"Panda: joint {self.joint}, {len(self.sensors)} sensors, {len(self.pose_rad)} angles: "
                f"expected a joint from 1 to {JOINTS}, {JOINTS} sensors and {JOINTS} angles"
            )


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class PandaSimulation:
    """A synthetic log of seven joints and the truth about the one that was moved."""

    log: JointLog
    joint: int
    truth: Truth


def simulate_hand_guided_panda(settings: HandGuidedPanda, seed: int, *, path: str = "simulation") -> PandaSimulation:
    """Simulate a Panda whose one joint is moved by hand while gravity is compensated.

    The sensor reads tau_J = gravity(q) - F_m; beyond gravity, only a compensator's torque is desired (tau_J_d). The
    other joints stand still and nobody loads them.

    Args:
        settings: The joint and its motion.
        seed: Seed; the motion is that of ``simulate_joint`` with the same seed.
        path: Path that the log names as its source.
    """
    person, sensing, recorder = (np.random.default_rng(part) for part in np.random.SeedSequence(seed).spawn(3))
    motion = move(settings.moved, person)
    recorded = record(settings.moved.ticks, settings.moved.rate_hz, settings.sensors[settings.joint - 1], recorder)
    channels = _sense_arm(settings, motion, sensing)
    columns = {name: channel[recorded.tick] for name, channel in channels.items()}
    names = tuple(f"panda_joint{number}" for number in range(1, JOINTS + 1))
    log = make_log(recorded.t, columns, names, path, robot="panda")
    truth = Truth(settings=settings.moved, seed=seed, motion=motion)
    return PandaSimulation(log=log, joint=settings.joint, truth=truth)


def _sense_arm(settings: HandGuidedPanda, motion: Motion, rng: np.random.Generator) -> dict[str, Float]:
    """Return the channels of the arm at every tick of its clock, shape (n + 1, 7) each."""
    moved, rate = settings.joint - 1, settings.moved.rate_hz
    q, dq, interaction, compensation = (np.zeros((len(motion.t), JOINTS)) for _ in range(4))
    q += np.asarray(settings.pose_rad)
    q[:, moved] += motion.q
    dq[:, moved] = motion.dq
    compensation[:, moved] = motion.compensation_nm
    hidden = settings.moved.torque_offset_nm + settings.moved.gravity_error_nm * np.sin(q[:, moved])
    interaction[:, moved] = motion.interaction_nm + hidden
    gravity = load_arm().gravity(q)
    sensors, columns = settings.sensors, range(JOINTS)
    tau_J = np.column_stack([sense_torque((gravity - interaction)[:, j], rate, sensors[j], rng) for j in columns])
    external = [low_pass((tau_J - gravity)[:, j], EXTERNAL_CUTOFF_HZ, rate) for j in columns]
    channels = {
        "q": np.column_stack([quantise(q[:, j], sensors[j].position_step_rad) for j in columns]),
        "dq": np.column_stack([sense_velocity(dq[:, j], sensors[j], rng) for j in columns]),
        "tau_J": tau_J,
        "tau_J_d": compensation,
        "tau_ext_hat_filtered": quantise(np.column_stack(external), EXTERNAL_STEP_NM),
        "gravity": quantise(gravity, GRAVITY_STEP_NM),
    }
    return channels if settings.moved.compensation is None else channels | {"tau_compensation": compensation}
