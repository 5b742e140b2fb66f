"""Closed cycles: where gravity is in the torque, only paths that return to their start say anything about friction."""

from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float, median_step, read_only
from friction_audit.parallel import per_joint
from friction_audit.preprocessing import kernels
from friction_audit.preprocessing.energy_cycles import (
    GAP,
    KEPT,
    ONE_WAY,
    OPEN,
    PER_CYCLE,
    SMALL,
    EnergyCycles,
    EnergySums,
)
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.preprocessing.velocity import filter_velocity

LONGEST_RUN = 8
"""Strokes tried before a start is given up."""


def end_to_end(q: Float, start: NDArray[np.int64], stop: NDArray[np.int64]) -> Float:
    """Return how far the joint furthest from its start is at the stop, shape (m,). [rad]

    Gravity at a joint depends on all joints beyond it, so all of them must return.
    """
    return np.asarray(np.abs(q[stop] - q[start]).max(axis=1), np.float64)


def close_runs(q: Float, borders: NDArray[np.int64], closure_rad: float) -> NDArray[np.int64]:
    """Join neighbouring strokes into the shortest runs that end where they began.

    Args:
        q: Position of all joints, shape (n, j). [rad]
        borders: Border samples of the strokes, shape (m + 1,).
        closure_rad: Largest distance that still counts as closed. [rad]

    Returns:
        Border samples of the runs; a stroke that closes with none of its followers stays alone (and open).
    """
    kept, s = [0], 0
    while s < len(borders) - 1:
        ends = borders[s + 1 : s + 1 + LONGEST_RUN]
        closed = end_to_end(q, np.full(len(ends), borders[s]), ends) <= closure_rad
        s += int(np.argmax(closed)) + 1 if closed.any() else 1
        kept.append(s)
    return borders[kept]


def gravity_work(interaction: Interaction, column: int, edges: NDArray[np.int64]) -> tuple[Float, Float]:
    """Integrate g_x dq and g_y dq over the parts of each cycle.

    Args:
        interaction: The interaction.
        column: Joint, 0-based.
        edges: Border samples of the parts, shape (m, p + 1).

    Returns:
        Two arrays of shape (m, p). [rad]
    """
    q = interaction.q[:, column]
    if interaction.gravity_direction is None or interaction.gravity_index is None:
        return np.diff(-np.cos(q[edges]), axis=1), np.diff(np.sin(q[edges]), axis=1)
    index = interaction.gravity_index
    step = np.diff(q[index])
    direction = interaction.gravity_direction[:, column, :]
    work = np.zeros_like(direction)
    work[1:] = np.cumsum(0.5 * (direction[1:] + direction[:-1]) * step[:, None], axis=0)
    x, y = (np.diff(np.interp(edges, index, work[:, k]), axis=1) for k in range(2))
    return x, y


INITIATION_SHARE = 0.25
"""Share of the speed of brisk motion at which a cycle begins: 0.2 rad/s (the paper's choice) at 0.8 rad/s."""

TERMINATION_SHARE = 0.25
"""Termination over initiation, 0.05 / 0.2 in the paper."""

NOISE_MULTIPLE = 5.0
"""Termination stays this many standard deviations above the noise of the filtered velocity."""

BRISK_QUANTILE = 0.9


def thresholds_from_log(dq: Float, filtered: Float, *, rate_hz: float, cutoff_hz: float) -> tuple[float, float]:
    """Choose initiation and termination for one signal.

    The noise is what the filter takes away (its robust standard deviation), scaled by the share of white noise that
    the filter lets through. Brisk motion is the upper decile of the speeds above that noise.

    Args:
        dq: Velocity or speed as measured, shape (n,).
        filtered: The same, filtered, shape (n,).
        rate_hz: Sampling rate. [Hz]
        cutoff_hz: Corner of the filter. [Hz]

    Returns:
        Initiation and termination, in the unit of ``dq``.
    """
    floor = NOISE_MULTIPLE * _noise_left(dq, filtered, rate_hz=rate_hz, cutoff_hz=cutoff_hz)
    speed = np.abs(filtered)
    moving = speed[speed > floor]
    brisk = float(np.quantile(moving, BRISK_QUANTILE)) if len(moving) else floor
    initiation = max(INITIATION_SHARE * brisk, floor / TERMINATION_SHARE, TINY)
    return initiation, TERMINATION_SHARE * initiation


TINY = 1e-6
"""A log without any motion still gets thresholds above zero."""


def _noise_left(dq: Float, filtered: Float, *, rate_hz: float, cutoff_hz: float) -> float:
    """Standard deviation of the noise that passes the filter, from what does not pass."""
    taken = np.abs(dq - filtered)
    sigma = 1.4826 * float(np.median(taken))
    share = min(2.0 * cutoff_hz / rate_hz, 1.0)
    return sigma * float(np.sqrt(share / max(1.0 - share, share)))


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
