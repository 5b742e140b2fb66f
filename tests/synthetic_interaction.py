"""Interactions whose energies are known by hand."""

import numpy as np

from friction_audit.friction.estimate import JointPass
from friction_audit.joint_log import Float, JointLog, Source
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction, TorqueChoice
from friction_audit.preprocessing.segmentation import of_hand, thresholds_in_blocks
from friction_audit.preprocessing.settings import CycleSettings

DEFAULT = CycleSettings()
RATE_HZ = 1000.0


def choice(*, gravity: str = "removed") -> TorqueChoice:
    return TorqueChoice(
        source="interaction",
        gravity=gravity,
        inertia="none",
        drive="hand",
        sign=1,
        sign_proved=True,
        sign_turned=False,
        robot="none",
        payload=None,
        model_rate_hz=None,
        formula="F_m = tau_interaction",
    )


def log_of(t: Float, q: Float, dq: Float, *, robot: str = "unknown", **channels: Float) -> JointLog:
    """Make a JointLog of one joint (arrays of shape (n,)) or several (shape (n, j))."""
    columns = {name: np.asfortranarray(np.atleast_2d(x.T).T) for name, x in ({"q": q, "dq": dq} | channels).items()}
    names = tuple(f"joint{number}" for number in range(1, columns["q"].shape[1] + 1))
    source = Source(path="made.csv", sha256="", format="csv", robot=robot)
    return JointLog(t=t, joint_names=names, source=source, **columns)


def interaction(
    t: Float, dq: Float, torque: Float, *, q: Float | None = None, u: Float | None = None, gravity: str = "removed"
) -> Interaction:
    """Make an Interaction of one joint (arrays of shape (n,)) or several (shape (n, j))."""
    dq, torque = (np.atleast_2d(x.T).T for x in (dq, torque))
    joints = dq.shape[1]
    if q is None:
        steps = 0.5 * (dq[1:] + dq[:-1]) * np.diff(t)[:, None]
        q = np.vstack([np.zeros((1, joints)), np.cumsum(steps, axis=0)])
    return Interaction(
        t=t,
        q=np.asfortranarray(np.atleast_2d(q.T).T),
        dq=np.asfortranarray(dq),
        torque=np.asfortranarray(torque),
        compensation=None if u is None else np.asfortranarray(np.atleast_2d(u.T).T),
        joint_numbers=tuple(range(1, joints + 1)),
        joint_names=tuple(f"joint{i + 1}" for i in range(joints)),
        choice=choice(gravity=gravity),
    )


def passed(seen: Interaction, settings: CycleSettings = DEFAULT, hand_speed: Float | None = None) -> list[JointPass]:
    """Return the joints after their pass through an interaction; the hand defines the cycles where it has a speed."""
    log = log_of(seen.t - seen.t[0], seen.q, seen.dq, tau_interaction=seen.torque)
    hand = None if hand_speed is None else of_hand(hand_speed, log.rate_hz, settings)
    thresholds = enumerate(thresholds_in_blocks(log, [*range(len(seen.joint_names))], settings))
    joints = [JointPass(log, column, settings, own, hand) for column, own in thresholds]
    for joint in joints:
        joint.take(seen, seen, seen, more=False)
    return joints


def cycles_of(seen: Interaction, settings: CycleSettings = DEFAULT) -> list[EnergyCycles]:
    return [joint.search.cycles() for joint in passed(seen, settings)]


def strokes(lengths_rad: list[float], durations_s: list[float], pause_s: float = 0.3) -> tuple[Float, Float, Float]:
    """Minimum-jerk strokes with pauses: time, velocity and acceleration, shape (n,) each."""
    velocity, acceleration = [np.zeros(int(pause_s * RATE_HZ))], [np.zeros(int(pause_s * RATE_HZ))]
    for length, duration in zip(lengths_rad, durations_s, strict=True):
        x = np.arange(int(duration * RATE_HZ)) / (duration * RATE_HZ)
        velocity += [length / duration * 30 * x**2 * (1 - x) ** 2, np.zeros(int(pause_s * RATE_HZ))]
        acceleration += [length / duration**2 * (60 * x - 180 * x**2 + 120 * x**3), np.zeros(int(pause_s * RATE_HZ))]
    v, a = np.concatenate(velocity), np.concatenate(acceleration)
    return np.arange(len(v)) / RATE_HZ, v, a
