"""One joint on a bench, moved by hand; the log carries the interaction torque itself."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float, JointLog, Source
from friction_audit.simulate.dynamics import Motion, move
from friction_audit.simulate.sensors import quantise, record, sense_torque, sense_velocity
from friction_audit.simulate.settings import JointSettings


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Truth:
    """What the log does not say.

    Attributes:
        settings: Everything that was simulated.
        seed: The seed.
        motion: The motion of the joint, free of noise.
    """

    settings: JointSettings
    seed: int
    motion: Motion


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Simulation:
    """A synthetic log and its truth."""

    log: JointLog
    truth: Truth


def simulate_joint(settings: JointSettings, seed: int, *, path: str = "simulation") -> Simulation:
    """Simulate one joint moved by hand. The same settings and seed give the same log to the bit.

    Args:
        settings: The joint, the person, the sensors, what is hidden.
        seed: Seed; the motion depends on it alone and not on the sensors.
        path: Path that the log names as its source.
    """
    person, sensors, recorder = (np.random.default_rng(part) for part in np.random.SeedSequence(seed).spawn(3))
    motion = move(settings, person)
    recorded = record(settings.ticks, settings.rate_hz, settings.sensors, recorder)
    hidden = settings.torque_offset_nm + settings.gravity_error_nm * np.sin(motion.q)
    channels = {
        "q": quantise(motion.q, settings.sensors.position_step_rad),
        "dq": sense_velocity(motion.dq, settings.sensors, sensors),
        "tau_interaction": sense_torque(motion.interaction_nm + hidden, settings.rate_hz, settings.sensors, sensors),
    }
    if settings.compensation is not None:
        channels["tau_compensation"] = motion.compensation_nm
    columns = {name: column[recorded.tick, np.newaxis] for name, column in channels.items()}
    log = make_log(recorded.t, columns, ("joint1",), path, robot="unknown")
    return Simulation(log=log, truth=Truth(settings=settings, seed=seed, motion=motion))


def make_log(t: Float, channels: Mapping[str, Float], names: tuple[str, ...], path: str, *, robot: str) -> JointLog:
    """Return a log whose source tells nothing about how it was made."""
    columns = {name: np.asfortranarray(channel) for name, channel in channels.items()}
    digest = hashlib.sha256(t.tobytes())
    for column in columns.values():
        digest.update(column.tobytes(order="F"))
    source = Source(path=path, sha256=digest.hexdigest(), format="simulation", robot=robot, clock="robot_time")
    return JointLog(t=t, **columns, joint_names=names, source=source)
