"""Options -> settings of the chain and of the readers."""

from typing import TYPE_CHECKING, Any

from friction_audit.cli.options import AuditOptions, CycleOptions, ReadingOptions, SelectionOptions, TorqueOptions
from friction_audit.cli.values import parse_joints, parse_mapping, parse_numbers

if TYPE_CHECKING:
    from friction_audit.audit import AuditSettings
    from friction_audit.cycles.settings import CycleSettings
    from friction_audit.ingest import ReadOptions
    from friction_audit.interaction.settings import TorqueSettings


def read_options(reading: ReadingOptions, selection: SelectionOptions) -> "ReadOptions":
    """Return how the log is read, and which part of it."""
    from friction_audit.ingest import ReadOptions

    return ReadOptions(
        topic=reading.topic,
        mapping=parse_mapping(reading.mapping),
        robot=None if reading.robot in ("auto", "none") else reading.robot,
        time_scale=reading.time_scale,
        allow_short=reading.allow_short,
        t_start_s=selection.t_start,
        t_end_s=selection.t_end,
    )


def torque_settings(torque: TorqueOptions, robot: str) -> "TorqueSettings":
    """Return how the interaction torque is made."""
    from friction_audit.interaction.settings import TorqueSettings

    payload, gravity = torque.payload, ("x", "y", "z")
    numbers: Any = None if payload is None else parse_numbers("--payload", payload, ("mass", "x", "y", "z"))
    vector: Any = parse_numbers("--gravity-vector", torque.gravity_vector, gravity)
    return TorqueSettings(
        torque=torque.torque,
        gravity=torque.gravity,
        inertia=torque.inertia,
        drive=torque.drive,
        robot=robot,
        urdf=torque.urdf,
        payload=numbers,
        gravity_vector=vector,
        model_rate_hz=torque.model_rate,
    )


def cycle_settings(cycles: CycleOptions) -> "CycleSettings":
    """Return how cycles are found."""
    from friction_audit.cycles.settings import CycleSettings

    names = ("INIT", "TERM")
    speeds: dict[str, Any] = {"thresholds": "auto"}
    if cycles.thresholds != "auto":
        begin, end = parse_numbers("--thresholds", cycles.thresholds, names)
        speeds = {"initiation_rad_s": begin, "termination_rad_s": end}
    hand_begin, hand_end = parse_numbers("--hand-thresholds", cycles.hand_thresholds, names)
    return CycleSettings(
        cycles_from=cycles.cycles_from,
        hand_initiation_m_s=hand_begin,
        hand_termination_m_s=hand_end,
        minimum_path_rad=cycles.min_path,
        **speeds,
    )


def audit_settings(options: AuditOptions) -> "AuditSettings":
    """Return the settings of the whole chain."""
    from friction_audit.audit import AuditSettings
    from friction_audit.friction.settings import FrictionSettings

    selection, estimate = options.selection, options.estimate
    return AuditSettings(
        joints=parse_joints(selection.joints),
        t_start_s=selection.t_start,
        t_stop_s=selection.t_end,
        torque=torque_settings(options.torque, options.reading.robot),
        cycles=cycle_settings(options.cycles),
        friction=FrictionSettings(estimator=estimate.estimator, model=estimate.model, window=estimate.window),
    )
