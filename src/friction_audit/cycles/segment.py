"""Interaction -> EnergyCycles."""

from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from friction_audit.cycles import kernels
from friction_audit.cycles.closure import close_runs, end_to_end
from friction_audit.cycles.energy_cycles import GAP, KEPT, ONE_WAY, OPEN, PER_CYCLE, SMALL, EnergyCycles, EnergySums
from friction_audit.cycles.gravity_columns import gravity_work
from friction_audit.cycles.settings import CycleSettings
from friction_audit.cycles.thresholds import thresholds_from_log
from friction_audit.cycles.velocity import filter_velocity
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import Float, median_step, read_only
from friction_audit.per_joint import per_joint

PARTS = 8
"""Parts of equal path into which each cycle is cut. Within a stroke the speed runs through its whole range, so the
parts tell Coulomb from viscous friction even where all strokes are equally fast."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Detector:
    """The signal whose rest defines the cycles, its thresholds, and whether its sign tells directions."""

    signal: Float
    initiation: float
    termination: float
    signed: bool

    @property
    def borders(self) -> NDArray[np.int64]:
        return kernels.find_borders(read_only(self.signal), self.initiation, self.termination, self.signed)


def segment_cycles(interaction: Interaction, settings: CycleSettings) -> EnergyCycles:
    """Find the energy cycles of every joint and add up their energies.

    Args:
        interaction: Motion and torque at the friction port.
        settings: Thresholds and rules.

    Returns:
        All cycles, those left out included, with the reason.
    """
    rate_hz = 1.0 / median_step(interaction.t)
    hand = _hand_detector(interaction, settings, rate_hz) if settings.cycles_from == "hand" else None
    work = partial(_segment_joint, interaction, settings, rate_hz, hand)
    cycles = _join(per_joint(work, len(interaction.joint_numbers)))
    return replace(cycles, reason=_common_reason(cycles, settings)) if hand else cycles


def _segment_joint(
    interaction: Interaction, settings: CycleSettings, rate_hz: float, hand: _Detector | None, column: int
) -> EnergyCycles:
    """Find the cycles of one joint, add up their energies and say which of them count."""
    t, dq = interaction.t, interaction.dq[:, column]
    filtered = filter_velocity(dq, rate_hz=rate_hz, cutoff_hz=settings.cutoff_hz)
    fixed = (settings.initiation_rad_s, settings.termination_rad_s)
    own = _detector(dq, filtered, settings, rate_hz, fixed, signed=True)
    detector = hand or own
    borders = _borders(interaction, detector, settings)
    edges, peak, longest_step = kernels.cut_evenly(read_only(t), read_only(filtered), borders, PARTS)
    parts = _sums(interaction, column, filtered, edges)
    start, stop = borders[:-1], borders[1:]
    reach = interaction.q if interaction.choice.gravity_in_torque else interaction.q[:, column : column + 1]
    is_open = end_to_end(reach, start, stop) > settings.closure_rad
    # At a low rate a single lost sample is no hole: the motion in between is still told by its neighbours.
    hole_s = max(settings.maximum_gap_s, LONGEST_STEP / rate_hz)
    return EnergyCycles(
        joint=np.full(len(start), column),
        start=start,
        stop=stop,
        start_s=t[start],
        stop_s=t[stop],
        peak_speed_rad_s=peak,
        sums=parts.total(),
        parts=parts,
        open=is_open,
        reason=_reason(parts.total(), is_open & interaction.choice.gravity_in_torque, longest_step > hole_s),
        initiation=np.array([detector.initiation]),
        termination=np.array([detector.termination]),
        fastest=np.array([np.abs(detector.signal).max()]),
        speed_unit="rad/s" if detector.signed else "m/s",
        standstill_rad_s=np.array([own.termination]),
        moving_s=np.array([np.mean(np.abs(filtered) > own.initiation) * (t[-1] - t[0])]),
    )


def _borders(interaction: Interaction, detector: _Detector, settings: CycleSettings) -> NDArray[np.int64]:
    """Return the border samples of the cycles, one more than there are cycles."""
    borders = detector.borders
    if not len(borders):
        return np.zeros(1, np.int64)
    if interaction.choice.gravity_in_torque:
        return close_runs(interaction.q, borders, settings.closure_rad)
    return borders


def _sums(interaction: Interaction, column: int, filtered: Float, edges: NDArray[np.int64]) -> EnergySums:
    u = np.empty(0) if interaction.compensation is None else interaction.compensation[:, column]
    q, dq, torque = (read_only(array[:, column]) for array in (interaction.q, interaction.dq, interaction.torque))
    raw = kernels.add_up(read_only(interaction.t), q, dq, read_only(filtered), torque, read_only(u), edges)
    gravity_x, gravity_y = gravity_work(interaction, column, edges)
    return EnergySums(
        work_j=raw[:, :, kernels.WORK],
        compensation_j=raw[:, :, kernels.COMPENSATION],
        printed_net_j=raw[:, :, kernels.PRINTED],
        path_rad=raw[:, :, kernels.PATH],
        rectified_path_rad=raw[:, :, kernels.RECTIFIED],
        square_speed_rad2_s=raw[:, :, kernels.SQUARE],
        displacement_rad=np.diff(q[edges], axis=1),
        gravity_x_rad=gravity_x,
        gravity_y_rad=gravity_y,
        half_square_speed_change=raw[:, :, kernels.HALF_SQUARE],
    )


def _hand_detector(interaction: Interaction, settings: CycleSettings, rate_hz: float) -> _Detector:
    assert interaction.hand_speed is not None, "the interaction was extracted without the hand's speed"
    filtered = filter_velocity(interaction.hand_speed, rate_hz=rate_hz, cutoff_hz=settings.cutoff_hz)
    fixed = (settings.hand_initiation_m_s, settings.hand_termination_m_s)
    return _detector(interaction.hand_speed, np.abs(filtered), settings, rate_hz, fixed, signed=False)


def _detector(
    measured: Float,
    filtered: Float,
    settings: CycleSettings,
    rate_hz: float,
    fixed: tuple[float, float],
    *,
    signed: bool,
) -> _Detector:
    automatic = settings.thresholds == "auto"
    initiation, termination = (
        thresholds_from_log(measured, filtered, rate_hz=rate_hz, cutoff_hz=settings.cutoff_hz) if automatic else fixed
    )
    return _Detector(signal=filtered, initiation=initiation, termination=termination, signed=signed)


def _reason(sums: EnergySums, open_with_gravity: NDArray[np.bool_], too_long: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Say why each cycle is left out; a joint that never reversed has no closed path at all."""
    reason = np.full(len(too_long), KEPT)
    reason[open_with_gravity] = OPEN
    reason[too_long] = GAP
    # The net path of a closed path is short against its length, whether it closes within one cycle or over several.
    if abs(sums.displacement_rad.sum()) > ONE_WAY_SHARE * sums.path_rad.sum():
        reason[:] = ONE_WAY
    return reason


ONE_WAY_SHARE = 0.95
LONGEST_STEP = 3.5
"""A step of the clock of this many median steps is a hole, however low the rate."""


def _common_reason(cycles: EnergyCycles, settings: CycleSettings) -> NDArray[np.int64]:
    """Leave out hand cycles in which some joint has hardly moved: all joints are updated together or not at all."""
    joints = len(cycles.initiation)
    path = cycles.sums.path_rad.reshape(joints, -1)
    small = np.tile((path < settings.minimum_path_rad).any(axis=0), joints)
    return np.where((cycles.reason == KEPT) & small, SMALL, cycles.reason)


def _join(joints: list[EnergyCycles]) -> EnergyCycles:
    per_joint = ("initiation", "termination", "fastest", "standstill_rad_s", "moving_s")
    columns = {name: np.concatenate([getattr(c, name) for c in joints]) for name in (*PER_CYCLE, *per_joint)}
    sums, parts = (
        EnergySums(
            **{f.name: np.concatenate([getattr(getattr(c, which), f.name) for c in joints]) for f in fields(EnergySums)}
        )
        for which in ("sums", "parts")
    )
    return EnergyCycles(**columns, speed_unit=joints[0].speed_unit, sums=sums, parts=parts)
