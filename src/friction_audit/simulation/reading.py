"""What the sensors and the recorder make of the truth."""

from collections.abc import Callable

import numpy as np

from friction_audit.joint_log import Float, JointLog
from friction_audit.simulation.clock import CONTROL_RATE_HZ, Streams, sampled_ticks
from friction_audit.simulation.effects import gravity_error, time_delay, torque_crosstalk, torque_ripple, warm_up
from friction_audit.simulation.effects.time_delay import TORQUE_LATE, VELOCITY_LATE
from friction_audit.simulation.mechanics.records import Loop
from friction_audit.simulation.mechanism import Settings, any_guards
from friction_audit.simulation.sensors import low_pass, quantise, record
from friction_audit.simulation.simulation import Motion, make_log

EXTERNAL_CUTOFF_HZ = 100.0
"""Corner of the filter on ``tau_ext_hat_filtered``; the vendor's is not published, this one is an assumption."""

EXTERNAL_STEP_NM = 1e-3
"""Resolution of ``tau_ext_hat_filtered`` as logged."""

GRAVITY_STEP_NM = 1e-6
"""Resolution of ``gravity`` as logged."""

TEMPERATURE_STEP_C = 0.1
"""Resolution of ``temperature`` as logged."""


def sense(settings: Settings, motion: Motion, loop: Loop, error: Float) -> dict[str, Float]:
    """Return position, velocity and the interaction torque less its support, as read at every tick, shape (n + 1, j).

    The compensator in the loop saw the same numbers, where no effect of the reading itself is hidden.

    Args:
        settings: Sensors and what is hidden.
        motion: The truth.
        loop: The noise.
        error: What else is in the torque before it is rounded, shape (n + 1, j). [N m]
    """
    port = _late(settings, motion.port_nm, TORQUE_LATE)
    port = torque_crosstalk.mixed([inside.torque_crosstalk for inside in settings.hidden], port)
    ripple = _per_joint(settings, lambda j: torque_ripple.reading_nm(settings.hidden[j].torque_ripple, motion.q[:, j]))
    torque = port + ripple + loop.torque_noise + error
    place = _late(settings, motion.q, VELOCITY_LATE)
    velocity = _late(settings, motion.dq, VELOCITY_LATE) + loop.velocity_noise
    sensors = settings.sensors
    return {
        "q": _per_joint(
            settings, lambda j: quantise(place[:, j] + loop.position_noise[:, j], sensors[j].position_step_rad)
        ),
        "dq": _per_joint(settings, lambda j: quantise(velocity[:, j], sensors[j].velocity_step_rad_s)),
        "port": _per_joint(settings, lambda j: quantise(torque[:, j], sensors[j].torque_step_nm)),
    }


def _per_joint(settings: Settings, column: Callable[[int], Float]) -> Float:
    return np.column_stack([column(j) for j in range(len(settings.joints))])


def _late(settings: Settings, signal: Float, form: int) -> Float:
    """Return a signal behind its delay lines."""

    def column(j: int) -> Float:
        hidden = settings.hidden[j].time_delay
        return time_delay.delayed(signal[:, j], hidden.delay_s if hidden.form == form else 0.0, 1.0 / CONTROL_RATE_HZ)

    return _per_joint(settings, column)


def wrong_gravity(settings: Settings, gravity: Float, q: Float) -> Float:
    """Return the gravity torque that is subtracted from the sensor's: not the true one where an error is hidden."""
    error = _per_joint(settings, lambda j: gravity_error.reading_nm(settings.hidden[j].gravity_error, q[:, j]))
    return gravity + error


def bench_channels(settings: Settings, motion: Motion, loop: Loop) -> dict[str, Float]:
    """Return the channels of a rig that logs the interaction torque itself."""
    read = sense(settings, motion, loop, wrong_gravity(settings, np.zeros_like(motion.q), motion.q))
    channels = {"q": read["q"], "dq": read["dq"], "tau_interaction": read["port"]}
    return channels | _compensator_channels(settings, motion)


def arm_channels(settings: Settings, motion: Motion, loop: Loop, gravity: Float, *, driven: bool) -> dict[str, Float]:
    """Return the channels of an arm that logs the torque at its sensors, gravity in it.

    Args:
        settings: Sensors and what is hidden.
        motion: The truth.
        loop: The noise.
        gravity: Gravity torque at every tick, shape (n + 1, j). [N m]
        driven: True if the robot moves by itself: friction is then on the link's side of the sensor.
    """
    read = sense(settings, motion, loop, np.zeros_like(motion.q))
    tau_J = read["port"] if driven else -read["port"]
    logged = wrong_gravity(settings, gravity, motion.q)
    external = _per_joint(settings, lambda j: low_pass((tau_J - logged)[:, j], EXTERNAL_CUTOFF_HZ, CONTROL_RATE_HZ))
    channels = {
        "q": read["q"],
        "dq": read["dq"],
        "tau_J": tau_J,
        "tau_ext_hat_filtered": quantise(external, EXTERNAL_STEP_NM),
        "gravity": quantise(logged, GRAVITY_STEP_NM),
    }
    return channels | _compensator_channels(settings, motion)


def _compensator_channels(settings: Settings, motion: Motion) -> dict[str, Float]:
    """Return what an active compensator logs."""
    if settings.compensator is None:
        return {}
    channels = {"tau_compensation": motion.compensation_nm}
    if any_guards(settings.compensator):
        channels["tau_passivity"] = motion.passivity_nm
    return channels


def temperatures(settings: Settings, motion: Motion) -> Float:
    """Return the temperature of every joint as a thermometer logs it, shape (n + 1, j). [degC]"""

    def column(j: int) -> Float:
        truth = warm_up.temperature_c(settings.hidden[j].warm_up, motion.warmth[:, j])
        return quantise(truth, TEMPERATURE_STEP_C)

    return _per_joint(settings, column)


def write_down(
    settings: Settings, channels: dict[str, Float], names: tuple[str, ...], path: str, streams: Streams, *, robot: str
) -> JointLog:
    """Return the log: the states that were kept, with the stamps of the recorder."""
    first = next(iter(channels.values()))
    ticks = sampled_ticks(len(first) - 1, settings.rate_hz)
    recorded = record(ticks / CONTROL_RATE_HZ, settings.rate_hz, settings.sensors[0], streams.recorder)
    columns = {name: channel[ticks[recorded.tick]] for name, channel in channels.items()}
    return make_log(recorded.t, columns, names, path, robot=robot)
