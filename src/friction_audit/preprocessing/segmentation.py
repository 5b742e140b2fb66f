"""Energy cycles of every joint: where they begin and end, their energies, and which of them count."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from friction_audit.joint_log import Float, median_step
from friction_audit.parallel import per_joint
from friction_audit.preprocessing import cycle_sums
from friction_audit.preprocessing.energy_cycles import GAP, KEPT, ONE_WAY, OPEN, SMALL, EnergyCycles, EnergySums, Int
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.preprocessing.velocity import filter_velocity

# Parts of equal path into which each cycle is cut. Within a stroke the speed runs through its whole range, so the parts
# separate Coulomb from viscous friction even where all strokes are equally fast.
PARTS = 8
LONGEST_RUN = 8  # strokes tried before a start is given up
ONE_WAY_SHARE = 0.95  # of the path that is net displacement
LONGEST_STEP = 3.5  # median steps of the clock that are a hole, however low the rate

# Automatic thresholds. Brisk motion is the upper decile of the speeds above the noise; the paper's 0.2 and 0.05 rad/s
# come out at 0.8 rad/s.
BRISK_QUANTILE = 0.9
INITIATION_SHARE = 0.25
TERMINATION_SHARE = 0.25
NOISE_MULTIPLE = 5.0  # standard deviations of the filtered velocity that termination stays above its noise
TINY = 1e-6  # a log without any motion still gets thresholds above zero


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Detector:
    """The signal whose rest defines the cycles, its thresholds, and whether its sign is that of the direction."""

    signal: Float
    initiation: float
    termination: float
    signed: bool


def segment_cycles(interaction: Interaction, settings: CycleSettings) -> EnergyCycles:
    """Find the energy cycles of every joint and add up their energies.

    Args:
        interaction: Motion and torque at the friction port.
        settings: Thresholds and rules.

    Returns:
        All cycles, the rejected ones included, with the reason.
    """
    rate_hz, hand = 1.0 / median_step(interaction.t), None
    if settings.cycles_from == "hand":
        assert interaction.hand_speed is not None, "the interaction was extracted without the hand's speed"
        filtered = np.abs(filter_velocity(interaction.hand_speed, rate_hz=rate_hz, cutoff_hz=settings.cutoff_hz))
        hand = _detector(interaction.hand_speed, filtered, settings, rate_hz, signed=False)

    def work(column: int) -> EnergyCycles:
        one = interaction.holding(column)
        return segment_joint(one, settings, column, smooth_velocity(one, settings, column), hand)

    joints = per_joint(work, len(interaction.joint_numbers))
    cycles = join_cycles(joints)
    if hand is None:
        return cycles
    # All joints are updated together or not at all: a cycle in which some joint has hardly moved counts for none.
    path = cycles.sums.path_rad.reshape(len(joints), -1)
    small = np.tile((path < settings.minimum_path_rad).any(axis=0), len(joints))
    return replace(cycles, reason=np.where((cycles.reason == KEPT) & small, SMALL, cycles.reason))


def smooth_velocity(interaction: Interaction, settings: CycleSettings, column: int) -> Float:
    """Return the filtered velocity of one joint (0-based), shape (n,). [rad/s]"""
    rate_hz = 1.0 / median_step(interaction.t)
    return filter_velocity(interaction.dq[:, column], rate_hz=rate_hz, cutoff_hz=settings.cutoff_hz)


def segment_joint(
    interaction: Interaction, settings: CycleSettings, column: int, filtered: Float, hand: _Detector | None = None
) -> EnergyCycles:
    """Find the energy cycles of one joint (0-based), its own or those of the hand, and add up its energies."""
    rate_hz = 1.0 / median_step(interaction.t)
    t, dq, gravity_inside = interaction.t, interaction.dq[:, column], interaction.choice.gravity_in_torque
    own = _detector(dq, filtered, settings, rate_hz, signed=True)
    detector = hand or own
    borders = cycle_sums.find_borders(detector.signal, detector.initiation, detector.termination, merge=detector.signed)
    if not len(borders):
        borders = np.zeros(1, np.int64)
    # Gravity at a joint depends on all joints beyond it, so all of them must return.
    place: Float = (interaction.q if gravity_inside else interaction.q[:, column : column + 1])[borders]
    if gravity_inside:
        kept = _close_runs(place, settings.closure_rad)
        borders, place = borders[kept], place[kept]
    edges, peak, longest_step = cycle_sums.cut_evenly(t, filtered, borders, PARTS)
    parts = _sums(interaction, column, filtered, edges)
    sums, start, stop = parts.total(), borders[:-1], borders[1:]
    is_open = np.abs(np.diff(place, axis=0)).max(axis=1) > settings.closure_rad
    reason = np.full(len(start), KEPT)
    reason[is_open & gravity_inside] = OPEN
    # At a low rate a single lost sample is no hole: its neighbours still describe the motion in between.
    reason[longest_step > max(settings.maximum_gap_s, LONGEST_STEP / rate_hz)] = GAP
    # The net path of a closed path is short against its length, whether it closes within one cycle or over several.
    if abs(sums.displacement_rad.sum()) > ONE_WAY_SHARE * sums.path_rad.sum():
        reason[:] = ONE_WAY
    return EnergyCycles(
        joint=np.full(len(start), column),
        start=start,
        stop=stop,
        start_s=t[start],
        stop_s=t[stop],
        peak_speed_rad_s=peak,
        sums=sums,
        parts=parts,
        open=is_open,
        reason=reason,
        initiation=np.array([detector.initiation]),
        termination=np.array([detector.termination]),
        fastest=np.array([max(detector.signal.max(), -detector.signal.min())]),
        speed_unit="rad/s" if detector.signed else "m/s",
        standstill_rad_s=np.array([own.termination]),
        moving_s=np.array([np.mean(np.abs(filtered) > own.initiation) * (t[-1] - t[0])]),
    )


def _detector(measured: Float, filtered: Float, settings: CycleSettings, rate_hz: float, *, signed: bool) -> _Detector:
    if settings.thresholds == "auto":
        initiation, termination = _automatic_thresholds(measured, filtered, 2.0 * settings.cutoff_hz / rate_hz)
    elif signed:
        initiation, termination = settings.initiation_rad_s, settings.termination_rad_s
    else:
        initiation, termination = settings.hand_initiation_m_s, settings.hand_termination_m_s
    return _Detector(signal=filtered, initiation=initiation, termination=termination, signed=signed)


def _automatic_thresholds(measured: Float, filtered: Float, share: float) -> tuple[float, float]:
    """Choose thresholds for a signal of which the filter passes this share of white noise."""
    # What the filter takes away, as a robust standard deviation, scaled to what it lets through.
    noise = measured - filtered
    taken, share = 1.4826 * float(np.median(np.abs(noise, out=noise), overwrite_input=True)), min(share, 1.0)
    del noise
    floor = NOISE_MULTIPLE * taken * float(np.sqrt(share / max(1.0 - share, share)))
    moving = np.abs(filtered)
    moving = moving[moving > floor]
    brisk = float(np.quantile(moving, BRISK_QUANTILE, overwrite_input=True)) if len(moving) else floor
    initiation = max(INITIATION_SHARE * brisk, floor / TERMINATION_SHARE, TINY)
    return initiation, TERMINATION_SHARE * initiation


def _close_runs(place: Float, closure_rad: float) -> list[int]:
    """Join neighbouring strokes into the shortest runs that end where they began; one that never does stays alone."""
    kept, s = [0], 0
    while s < len(place) - 1:
        closed = np.abs(place[s + 1 : s + 1 + LONGEST_RUN] - place[s]).max(axis=1) <= closure_rad
        s += int(np.argmax(closed)) + 1 if closed.any() else 1
        kept.append(s)
    return kept


def _sums(interaction: Interaction, column: int, filtered: Float, edges: Int) -> EnergySums:
    u = None if interaction.compensation is None else interaction.compensation[:, column]
    q, dq, torque = (array[:, column] for array in (interaction.q, interaction.dq, interaction.torque))
    raw = cycle_sums.add_up(interaction.t, q, dq, filtered, torque, u, edges)
    gravity_x, gravity_y = _gravity_work(interaction, column, edges)
    return EnergySums(
        work_j=raw[:, :, cycle_sums.WORK],
        compensation_j=raw[:, :, cycle_sums.COMPENSATION],
        printed_net_j=raw[:, :, cycle_sums.PRINTED],
        path_rad=raw[:, :, cycle_sums.PATH],
        rectified_path_rad=raw[:, :, cycle_sums.RECTIFIED],
        square_speed_rad2_s=raw[:, :, cycle_sums.SQUARE],
        displacement_rad=np.diff(q[edges], axis=1),
        gravity_x_rad=gravity_x,
        gravity_y_rad=gravity_y,
        half_square_speed_change=raw[:, :, cycle_sums.HALF_SQUARE],
    )


def _gravity_work(interaction: Interaction, column: int, edges: Int) -> tuple[Float, Float]:
    """Integrate g_x dq and g_y dq over the parts of each cycle, shape (m, PARTS) each. [rad]"""
    q, index = interaction.q[:, column], interaction.gravity_index
    if interaction.gravity_direction is None or index is None:
        return np.diff(-np.cos(q[edges]), axis=1), np.diff(np.sin(q[edges]), axis=1)
    direction = interaction.gravity_direction[:, column, :]
    work = np.zeros_like(direction)
    work[1:] = np.cumsum(0.5 * (direction[1:] + direction[:-1]) * np.diff(q[index])[:, None], axis=0)
    x, y = (np.diff(np.interp(edges, index, work[:, k]), axis=1) for k in range(2))
    return x, y


def join_cycles(joints: Sequence[EnergyCycles]) -> EnergyCycles:
    """Return the cycles of all joints, each given in order, as one structure."""

    def joined(parts: list[EnergySums]) -> EnergySums:
        return EnergySums(
            **{f.name: np.concatenate([getattr(one, f.name) for one in parts]) for f in fields(EnergySums)}
        )

    arrays = [f.name for f in fields(EnergyCycles) if f.name not in ("sums", "parts", "speed_unit")]
    return EnergyCycles(
        **{name: np.concatenate([getattr(one, name) for one in joints]) for name in arrays},
        speed_unit=joints[0].speed_unit,
        sums=joined([one.sums for one in joints]),
        parts=joined([one.parts for one in joints]),
    )
