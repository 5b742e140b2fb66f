"""Energy cycles of every joint: where they begin and end, their energies, and which of them count."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from friction_audit.joint_log import Float, Int, JointLog
from friction_audit.parallel import per_joint
from friction_audit.preprocessing import energy_cycles as cycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.preprocessing.velocity import filter_velocity, settling_samples

# Parts of equal path into which each cycle is cut. Within a stroke the speed runs through its whole range, so the parts
# separate Coulomb from viscous friction even where all strokes are equally fast.
PARTS = 8
MOST_PIECES = 64  # of a day, lists of few cycles each would take more memory than the cycles
LONGEST_RUN = 8  # strokes tried before a start is given up
# In a longer cycle an offset adds more than friction takes; memory for so much of a log is enough for any length.
LONGEST_S = 300.0
ONE_WAY_SHARE = 0.95  # of the path that is net displacement
LONGEST_STEP = 3.5  # median steps of the clock that are a hole, however low the rate

# Brisk motion is the upper decile of the speeds above the noise: of 0.8 rad/s the paper's 0.2 and 0.05 rad/s come out.
BRISK_QUANTILE = 0.9
INITIATION_SHARE = 0.25
TERMINATION_SHARE = 0.25
NOISE_MULTIPLE = 5.0  # standard deviations of the filtered velocity that termination stays above its noise
TINY = 1e-6  # a log without any motion still gets thresholds above zero
MOST_SAMPLES = 1 << 19  # of which automatic thresholds are taken, spread evenly over the log

Thresholds = tuple[float, float]  # of initiation and termination
Hand = tuple[Thresholds, Float]  # thresholds of the hand and its filtered speed, where it defines the cycles


class CycleSearch:
    """Finds the energy cycles of one joint in parts of a log that follow each other; a log in memory is one part."""

    def __init__(
        self, settings: CycleSettings, column: int, rate_hz: float, own: Thresholds, hand: Hand | None = None
    ) -> None:
        """Take the joint (0-based) and its thresholds; where the hand defines the cycles, the log is one part."""
        self.first = 0  # number of the first sample that is still needed
        self._settings, self._column, self._rate_hz, self._own = settings, column, rate_hz, own
        self._thresholds = own if hand is None else hand[0]
        self._hand_speed = None if hand is None else hand[1]
        self._longest = int(LONGEST_S * rate_hz)
        # At a low rate a single lost sample is no hole: its neighbours still describe the motion in between.
        self._hole_s = max(settings.maximum_gap_s, LONGEST_STEP / rate_hz)
        self._filtered = np.empty(0)
        self._moving: bool | None = None  # at the first sample needed; None where its own speed decides
        self._at_border: bool | None = None
        # A cycle that has lasted too long already: its samples up to now are added up and forgotten; where it began.
        self._begun: tuple[cycles.EnergyCycles, Float] | None = None
        self._found: list[cycles.EnergyCycles] = []
        self._joined = 0  # so many of these are of many blocks
        self._above, self._fastest, self._peak_power_w, self._last_s, self._lost_s = 0, 0.0, 0.0, 0.0, 0.0

    def take(self, part: Interaction, filtered: Float, *, more: bool) -> None:
        """Find the cycles that end in new samples, whose filtered velocity is given, shape (k,); ``more`` may follow.

        The part has all samples that are still needed, and the new ones.
        """
        self._above += int(np.count_nonzero(np.abs(filtered) > self._own[0]))
        old = len(self._filtered)
        self._filtered = np.concatenate([self._filtered, filtered]) if old else filtered
        signal = self._filtered if self._hand_speed is None else self._hand_speed
        self._fastest = max(self._fastest, float(signal[old:].max()), -float(signal[old:].min()))
        shift = self.first - part.first
        new = slice(shift + old, shift + len(self._filtered))
        power = part.driving(self._column, new) * part.dq[new, self._column]
        self._peak_power_w = max(self._peak_power_w, float(np.abs(power).max()))
        steps = np.diff(part.t[new], prepend=self._last_s)
        self._lost_s += float(steps[steps > self._hole_s].sum())
        self._last_s = float(part.t[new.stop - 1])
        borders = cycles.find_borders(
            signal,
            *self._thresholds,
            merge=self._hand_speed is None,
            moving=self._moving,
            at_border=self._at_border,
            more=more,
            longest=self._longest,
        )
        if len(borders) and borders[0]:
            self._go_on(int(borders[0]), moving=False)
            borders, self._at_border = borders - borders[0], True
        if part.choice.gravity == "in-torque" and len(borders):
            position = self._position(part)[borders + (self.first - part.first)]
            borders = borders[self._close_runs(borders, position, more=more)]
        if len(borders) > 1:
            self._found.append(self._cycles_between(part, borders))
            if len(self._found) > MOST_PIECES + self._joined:
                first, *others = self._found[self._joined :]
                self._found[self._joined :] = [first.made_of(np.concatenate, others)]
                self._joined += 1
            self._go_on(int(borders[-1]), moving=False)
            self._begun, self._at_border = None, True
        elif not (more or self._found):
            self._found.append(self._cycles_between(part, np.zeros(1, np.int64)))
        if more and len(self._filtered) > 2 * self._longest:
            self._shorten(part)

    def _position(self, part: Interaction) -> Float:
        """Return the positions that a cycle has to return to; gravity in the torque depends on every joint."""
        if part.choice.gravity != "in-torque":
            return part.q[:, self._column, None]
        return part.q if part.posture is None else part.posture

    def _close_runs(self, borders: Int, position: Float, *, more: bool) -> list[int]:
        """Join strokes into the shortest runs at whose end all joints are back; one that never is stays alone."""
        kept = [0] if self._begun is None else [0, 1][: len(position)]
        while (s := kept[-1]) < len(position) - 1:
            run = slice(s + 1, s + 1 + LONGEST_RUN)
            closed = np.abs(position[run] - position[s]).max(axis=1) <= self._settings.closure_rad
            closed &= borders[run] - borders[s] <= self._longest
            may_close = s + LONGEST_RUN >= len(position) and len(self._filtered) - borders[s] <= self._longest
            if more and may_close and not closed.any():
                break
            kept.append(s + int(np.argmax(closed)) + 1 if closed.any() else s + 1)
        return kept

    def _cycles_between(self, part: Interaction, borders: Int) -> cycles.EnergyCycles:
        """Add up the energies between borders, which are counted from the first sample needed."""
        settings, shift, inside = self._settings, self.first - part.first, part.choice.gravity == "in-torque"
        t = part.t[shift:]
        # Next to a hole the filtered velocity is a mean over both sides: a border there is no rest.
        near = int(0.5 * self._rate_hz / settings.cutoff_hz)
        first = max(int(borders[0]) - near, -shift)
        steps = np.diff(part.t[first + shift : borders[-1] + shift + near + 1])
        holes = np.flatnonzero(steps > self._hole_s) + first
        edges, peak = cycles.cut_evenly(steps[-first:], self._filtered, borders, PARTS)
        parts = self._sums(part, edges)
        sums = cycles.EnergySums(*(one.sum(axis=-1) for one in parts))
        start, stop = borders[:-1] + self.first, borders[1:] + self.first
        start_s, position = t[borders[:-1]], self._position(part)[borders + shift]
        if self._begun is not None and len(start):
            begun, position[0] = self._begun
            start[0], start_s[0], peak[0] = begun.start[0], begun.start_s[0], max(peak[0], begun.peak_speed_rad_s[0])
            for one, other in zip(sums, begun.sums, strict=True):
                one[0] += other[0]
        is_open = np.abs(np.diff(position, axis=0)).max(axis=1) > settings.closure_rad
        reason = np.where(stop - start > self._longest, cycles.LONG, cycles.KEPT)
        reason[is_open & inside] = cycles.OPEN
        reason[np.searchsorted(holes, borders[:-1] - near) < np.searchsorted(holes, borders[1:] + near)] = cycles.GAP
        if self._begun is not None and self._begun[0].reason[0] == cycles.GAP:
            reason[:1] = cycles.GAP
        products, speeds = _moments(parts)
        initiation, termination = self._thresholds
        return cycles.EnergyCycles(
            start=start,
            stop=stop,
            start_s=start_s,
            stop_s=t[borders[1:]],
            peak_speed_rad_s=peak,
            sums=sums,
            products=products,
            speeds=speeds,
            open=is_open,
            reason=reason,
            initiation=initiation,
            termination=termination,
            speed_unit="rad/s" if self._hand_speed is None else "m/s",
            standstill_rad_s=self._own[1],
        )

    def _sums(self, part: Interaction, edges: Int) -> cycles.EnergySums:
        shift = self.first - part.first
        rows = slice(shift, shift + len(self._filtered))
        u = None if part.compensation is None else part.compensation[rows, self._column]
        q, dq, torque = (array[rows, self._column] for array in (part.q, part.dq, part.torque))
        found = cycles.add_up(part.t[rows], q, dq, self._filtered, torque, u, edges)
        x, y = _gravity_work(part, self._column, edges + shift)
        return cycles.EnergySums(**found, displacement_rad=np.diff(q[edges], axis=1), gravity_x_rad=x, gravity_y_rad=y)

    def _shorten(self, part: Interaction) -> None:
        """Add up the beginning of a cycle that lasts too long, and forget its samples."""
        shift = self.first - part.first
        moving = bool(abs(self._filtered[0]) > self._own[1]) if self._moving is None else self._moving
        self._at_border = not moving if self._at_border is None else self._at_border
        if self._at_border:
            now = self._cycles_between(part, np.array([0, self._longest]))
            self._begun = now, self._position(part)[shift] if self._begun is None else self._begun[1]
        stops, starts, _ = cycles.events(self._filtered[: self._longest + 1], *self._own, moving=moving)
        self._go_on(self._longest, moving=moving == (len(stops) == len(starts)))

    def _go_on(self, row: int, *, moving: bool) -> None:
        self.first += row
        self._moving = moving
        self._filtered = self._filtered[row:].copy()

    def cycles(self) -> cycles.EnergyCycles:
        """Return the cycles, once, after the last part."""
        found, self._found = self._found[0].made_of(np.concatenate, self._found[1:]), []
        samples = self.first + len(self._filtered)
        # The net path of a closed path is short against its length, whether it closes within one cycle or over several.
        one_way = abs(found.sums.displacement_rad.sum()) > ONE_WAY_SHARE * found.sums.path_rad.sum()
        return replace(
            found,
            reason=np.full(len(found.reason), cycles.ONE_WAY) if one_way else found.reason,
            fastest=self._fastest,
            moving_s=self._above / samples * (self._last_s - self._lost_s),
            peak_power_w=self._peak_power_w,
        )


def automatic_thresholds(settings: CycleSettings, rate_hz: float, measured: Float, filtered: Float) -> Thresholds:
    """Return thresholds from samples of a signal that are spread evenly over the log."""
    thin = slice(None, None, max(len(measured) // MOST_SAMPLES, 1))
    share = min(2.0 * settings.cutoff_hz / rate_hz, 1.0)  # of white noise that the filter passes
    # What the filter takes away, as a robust standard deviation, scaled to what it lets through.
    noise = measured[thin] - filtered[thin]
    taken = 1.4826 * float(np.median(np.abs(noise, out=noise), overwrite_input=True))
    del noise
    floor = NOISE_MULTIPLE * taken * float(np.sqrt(share / max(1.0 - share, share)))
    moving = np.abs(filtered[thin])
    moving = moving[moving > floor]
    brisk = float(np.quantile(moving, BRISK_QUANTILE, overwrite_input=True)) if len(moving) else floor
    initiation = max(INITIATION_SHARE * brisk, floor / TERMINATION_SHARE, TINY)
    return initiation, TERMINATION_SHARE * initiation


def of_hand(speed: Float, rate_hz: float, settings: CycleSettings) -> Hand:
    """Return the thresholds of the hand and its filtered speed, given its speed, shape (n,). [m/s]"""
    signal = np.abs(filter_velocity(speed, rate_hz=rate_hz, cutoff_hz=settings.cutoff_hz))
    if settings.thresholds == "auto":
        return automatic_thresholds(settings, rate_hz, speed, signal), signal
    return (settings.hand_initiation_m_s, settings.hand_termination_m_s), signal


def without_small(joints: Sequence[cycles.EnergyCycles], settings: CycleSettings) -> list[cycles.EnergyCycles]:
    """Reject the cycles of the hand in which some joint has hardly moved: all are updated together or not at all."""
    small = np.any([own.sums.path_rad < settings.minimum_path_rad for own in joints], axis=0)
    reasons = [np.where((own.reason == cycles.KEPT) & small, cycles.SMALL, own.reason) for own in joints]
    return [replace(own, reason=reason) for own, reason in zip(joints, reasons, strict=True)]


def thresholds_in_blocks(log: JointLog, columns: list[int], settings: CycleSettings) -> list[Thresholds]:
    """Return the thresholds of some joints (0-based) of a log; automatic ones take a pass over the velocities."""
    if settings.thresholds != "auto":
        return [(settings.initiation_rad_s, settings.termination_rad_s)] * len(columns)
    rate_hz = log.rate_hz
    margin, every, done = settling_samples(rate_hz, settings.cutoff_hz), max(log.samples // MOST_SAMPLES, 1), 0
    before = [np.empty(0) for _ in columns]
    found: list[list[tuple[Float, Float]]] = [[] for _ in columns]
    for part in log.blocks(("dq",)):
        first, end = part.first - len(before[0]), part.first + len(part.t)
        stop = end if end == log.samples else max(end - margin, done)
        thin = slice(done - first + -done % every, stop - first, every)

        def work(k: int, dq: Float = part.dq, thin: slice = thin, kept: int = max(stop - margin - first, 0)) -> None:
            measured = dq[:, columns[k]]
            measured = np.concatenate([before[k], measured]) if len(before[k]) else measured
            filtered = filter_velocity(measured, rate_hz=rate_hz, cutoff_hz=settings.cutoff_hz)
            found[k].append((measured[thin].copy(), filtered[thin].copy()))
            before[k] = measured[kept:].copy()

        per_joint(work, len(columns))
        done = stop
    joined = ([np.concatenate(one) for one in zip(*own, strict=True)] for own in found)
    return [automatic_thresholds(settings, rate_hz, *own) for own in joined]


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


def _moments(parts: cycles.EnergySums) -> tuple[Float, Float]:
    """Return ``products`` and ``speeds`` of cycles from the sums over their parts, shape (m, PARTS) each."""
    path, square = parts.path_rad, parts.square_speed_rad2_s
    weight = np.sqrt(np.divide(1.0, square, out=np.zeros(square.shape), where=square > 0.0))
    balance = np.stack([getattr(parts, name) for name in cycles.BALANCE], axis=1) * weight[:, None]
    one, other = (balance[:, index] for index in cycles.PAIRS)
    moves = (path > 0.0) & (square > 0.0)
    second = np.divide(square**2, path, out=np.zeros(path.shape), where=moves)
    speeds = np.stack([path * moves, square * moves, second], axis=-1).sum(axis=1)
    return (one * other).sum(axis=-1), speeds
