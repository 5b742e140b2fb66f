"""Motor current -> joint torque, by the constants that the user gives; scale and sign of the torque."""

from dataclasses import replace

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.io.readers.channel_names import torque_unit
from friction_audit.io.readers.reader import ReadOptions
from friction_audit.io.recording import Recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding
from friction_audit.joint_numbers import require_joints, write_joint_numbers
from friction_audit.presets import CURRENT, ESTIMATE, PRESETS, candidates

_PARTS = {"torque_constant": "torque constant {} N m/A", "gear_ratio": "gear ratio {}", "torque_scale": "scale {}"}


def convert_torque(recording: Recording, options: ReadOptions, path: str) -> Recording:
    """Multiply the measured torque, tau_J where there is one, by constant, ratio and scale of each joint; in place.

    Raises:
        UsageError: If the numbers are not one or one per joint.
    """
    factors = {name: values for name in _PARTS if (values := getattr(options, name))}
    if not factors and not options.flip:
        return recording
    joints = len(recording.joint_names)
    require_joints(options.flip, joints, f"{path}: --flip")
    for name, values in factors.items():
        if len(values) not in (1, joints):
            option = name.replace("_", "-")
            raise UsageError(
                f"{path}: --{option}: {len(values)} numbers; expected one, or one for each of {joints} joints"
            )
    channel = next(c for c in ("tau_J", *TORQUE_CHANNELS) if c in recording.channels)
    name = recording.mapping.get(channel, channel)
    unit = torque_unit(name)
    is_current = bool(options.torque_constant)
    total = np.where(np.isin(np.arange(1, joints + 1), options.flip), -1.0, 1.0)
    for values in factors.values():
        total = total * np.asarray(values)
    recording = recording.scaled(channel, total * (1e-3 if is_current and unit == "mA" else 1.0))
    parts = [_PARTS[one].format(", ".join(f"{value:g}" for value in values)) for one, values in factors.items()]
    parts += [f"-1 in joint {write_joint_numbers(options.flip)}"] if options.flip else []
    message = f"{channel} is {name} times {' times '.join(parts)}"
    if is_current:
        message += "; a torque from a motor current: its friction is that of motor, gear and joint"
    recording = recording.with_findings(Finding(code="torque_converted", message=message))
    return replace(recording, torque_unit="N m" if is_current else unit)


def doubt_current(recording: Recording) -> Recording:
    """Note where the arm by its name has no torque sensor: its effort is a current, or a torque made from one."""
    names = (recording.robot,) if recording.robot in PRESETS else candidates(recording.joint_names)
    kinds = {PRESETS[name].torque for name in names}
    name = recording.mapping.get("tau_J", "")
    if "tau_J" not in recording.channels or (recording.torque_unit or torque_unit(name)) != "N m":
        return recording
    arm = PRESETS[names[0]].label if len(names) == 1 else "these arms"
    if kinds == {CURRENT} and "effort" in name.lower() and not recording.torque_unit:
        message = (
            f"{name}: the ROS driver of {arm} gives the motor current [A] as effort, unless it is set to torques; if "
            "these are amperes, put :A after the names in --map tau_J"
        )
        return recording.with_findings(Finding(code="effort_is_current", message=message))
    if kinds == {ESTIMATE}:
        message = f"{arm}: {name} is estimated from the motor current: its friction is that of motor, gear and joint"
        return recording.with_findings(Finding(code="torque_from_current", message=message))
    return recording
