"""What was not recorded: channels, joints and rows without numbers, channels of one value or of a few steps."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.checks.clock import Clock, gap_threshold_s
from friction_audit.io.checks.held import MOVING_RAD_S
from friction_audit.io.recording import Column, Marks, Recording
from friction_audit.joint_log import TORQUE_CHANNELS, Finding, Float, Int
from friction_audit.parallel import per_joint

_ESSENTIAL = ("q", "dq", *TORQUE_CHANNELS)
_ABSURD = 1e9  # no position, velocity, torque or temperature is as large, in any unit: a damaged number
_SPARSE = 0.1  # share of missing values from which a channel that is not essential is left out, rather than the rows

Counts = Mapping[str, Int]  # channel -> missing values of each joint


class Missing:
    """Counts what is no number in the columns of a recording, and marks its rows."""

    def __init__(self, recording: Recording) -> None:
        self.counts = {name: np.zeros(len(recording.joint_names), np.int64) for name in recording.channels}
        self.rows, self.marks = recording.rows, Marks(recording.rows)

    def take(self, first: int, t: Float, channels: Mapping[str, Float]) -> dict[str, tuple[Float, Float]]:
        """Take the rows of a piece; return the lowest and highest values of its channels, shape (j,) each."""
        ranges = {}
        lost = ~np.isfinite(t)
        for name, piece in channels.items():
            # NaN goes through min and max: two fast passes and no temporary array.
            low, high = ranges[name] = piece.min(axis=0), piece.max(axis=0)
            for joint in np.flatnonzero(~((low > -_ABSURD) & (high < _ABSURD))):
                missing = ~(np.abs(piece[:, joint]) < _ABSURD)
                self.counts[name][joint] += np.count_nonzero(missing)
                lost |= missing
        self.marks.add(first, lost)
        return ranges


def leave_out_columns(recording: Recording, missing: Missing) -> Recording:
    """Leave out channels and joints that were never recorded; InputError if nothing usable is left."""
    if not missing.marks.count:
        return recording
    samples, counted = recording.rows, missing.counts
    empty = [channel for channel, counts in counted.items() if (counts == samples).all()]
    sparse = [c for c, counts in counted.items() if c not in (*_ESSENTIAL, *empty) and counts.max() > _SPARSE * samples]
    names = {channel: f"{channel} ({recording.mapping.get(channel, channel)})" for channel in empty}
    torques = [channel for channel in TORQUE_CHANNELS if channel in recording.channels]
    lost = ["q"] if "q" in empty else []  # a velocity can be made from it
    lost += torques if all(channel in empty for channel in torques) else []
    if lost:
        raise InputError(
            f"{recording.path}: {', '.join(names[channel] for channel in lost)}: none of the {samples} rows holds a "
            f"number (all NaN, infinite or beyond {_ABSURD:g}); expected q and one torque of "
            f"{', '.join(TORQUE_CHANNELS)}; record a topic that carries them, such as the robot's own state"
        )
    text = "{} holds no number in {} rows; the channel is left out"
    findings = [Finding("empty_channel", text.format(names[c], samples), amount=float(samples)) for c in empty]
    for channel in sparse:
        few = int(counted[channel].max())
        name = recording.name_of(channel, int(counted[channel].argmax()))
        text = f"{name} lacks {few} of {samples} rows; the channel is left out, the rows are kept"
        findings.append(Finding("sparse_channel", text, amount=float(few)))
    kept = {name: array for name, array in recording.channels.items() if name not in (*empty, *sparse)}
    mapping = {name: own for name, own in recording.mapping.items() if name not in (*empty, *sparse)}
    recording = replace(recording, channels=kept, mapping=mapping).with_findings(*findings)
    return _leave_out_joints(recording, {name: counted[name] for name in kept})


def leave_out_rows(recording: Recording, missing: Missing) -> Recording:
    """Leave out rows with anything missing."""
    if not (lost := missing.marks.count):
        return recording
    places = [recording.name_of(c, j) for c, counts in missing.counts.items() for j, one in enumerate(counts) if one]
    where = f" ({', '.join(places[:3])}{', ...' * (len(places) > 3)})" if places else ""  # noqa: PLR2004
    text = f"{lost} of {missing.rows} rows hold NaN, infinity or numbers beyond {_ABSURD:g}{where}; they are left out"
    return recording.without(missing.marks).with_findings(Finding("non_finite", text, amount=float(lost), damaged=True))


def _leave_out_joints(recording: Recording, missing: Counts) -> Recording:
    samples = recording.rows
    empty = np.any([counts == samples for counts in missing.values()], axis=0)
    if not empty.any():
        return recording
    if empty.all():
        raise InputError(
            f"{recording.path}: no joint has q, dq and torque together; each lacks one of them in all {samples} rows"
        )
    names, why = recording.joint_names, f"in all {samples} rows: it is left out, joints are numbered without it"
    lost, kept = (np.flatnonzero(one).tolist() for one in (empty, ~empty))
    lacks = {j: " and ".join(c for c, counts in missing.items() if counts[j] == samples) for j in lost}
    now = {j: next((f" ({n} is {names[k]})" for n, k in enumerate(kept, start=1) if k > j), "") for j in lost}
    texts = (f"{names[j]} holds no {lacks[j]} {why}{now[j]}" for j in lost)
    findings = [Finding("empty_joint", text, amount=float(samples)) for text in texts]
    left = recording.changed(lambda t, every: (t, {name: np.asfortranarray(a[:, kept]) for name, a in every.items()}))
    return replace(left, joint_names=tuple(names[joint] for joint in kept)).with_findings(*findings)


_FROZEN_S = 1.0  # in which a channel of a moving joint does not change by the last digit
_REVERSED_RAD_S = 0.05  # speed that is no noise; in both directions no torque with friction is one number
_DEVIATES_RAD = 0.1  # of q from the integral of dq, that no noise of a joint at rest makes


def find_frozen(recording: Recording, columns: Mapping[str, Column], clock: Clock) -> Recording:
    """Notice channels that keep one value for a part of the log although the joint moves there."""
    q, dq, found = columns["q"].sample, columns["dq"].sample, list[Finding]()
    t, usual_s = clock.sample - clock.first_s, clock.step_s * clock.rows / len(q)
    steps = np.diff(t, append=t[-1] + usual_s)
    steps[steps > usual_s + gap_threshold_s(clock.step_s)] = usual_s  # over a hole nothing is known
    names = [name for name in ("q", "dq", *TORQUE_CHANNELS) if name in columns]
    dead = {one.joint for one in recording.findings if one.code in ("torque_dead", "torque_coarse")}
    for name, joint in product(names, range(q.shape[1])):
        is_torque, values = name in TORQUE_CHANNELS, columns[name].sample[:, joint]
        edges = np.concatenate([[0], np.flatnonzero(np.diff(values)) + 1, [len(values)]])
        longest = int(np.argmax(np.diff(edges)))
        part = slice(edges[longest], edges[longest + 1])
        lasts_s, speed = float(steps[part].sum()), dq[part, joint]
        if lasts_s < _FROZEN_S or len(edges) == 2 or (is_torque and joint + 1 in dead):  # noqa: PLR2004
            continue  # or in all of the log, which is reported elsewhere
        apart = np.ptp(q[part, joint] - np.cumsum(steps[part] * speed)) > _DEVIATES_RAD
        is_wrong = apart and (name == "dq" or np.abs(speed).max() > _REVERSED_RAD_S)
        if is_torque:
            is_wrong = speed.min() < -_REVERSED_RAD_S and speed.max() > _REVERSED_RAD_S
        if is_wrong:
            text = (
                f"{recording.name_of(name, joint)} keeps the value {values[part.start]:.4g} from about "
                f"{t[part.start]:.3g} to {t[part.stop - 1]:.3g} s while the joint moves: it was not recorded "
                "there; leave that part out with --t-start and --t-end"
            )
            found.append(Finding("channel_frozen", text, joint + 1, lasts_s))
    return recording.with_findings(*found)


# What a joint of an arm for tens of kilograms never holds, and what is left of it without gravity. [N m]
_LARGEST_NM = {"tau_J": 1000.0, "tau_interaction": 300.0, "tau_ext_hat_filtered": 300.0}
_SHARE = 0.95  # of the samples that may be below what is tested: a few wild ones prove nothing
_FEWEST_MOVING = 20  # samples in either direction that show what reverses with the motion
_FEW_STEPS = 5.0
_LEAST_NM = 0.01  # no joint of an arm turns with less: a channel of a few steps below it carries no torque [N m]
# Steps of more than what reverses make the estimate depend on their rounding. Panda sensors have half of that.
_COARSE = 1.0
_MOST_VALUES = 64
_UNEVEN = 0.01


def check_torque(recording: Recording, columns: Mapping[str, Column]) -> Recording:
    """Notice torques that are dead, coarse or may be in mN m; nothing is changed."""
    findings = []
    for name in (name for name in _LARGEST_NM if name in columns):
        usual = np.quantile(np.abs(columns[name].sample), _SHARE, axis=0)
        joint = int(np.argmax(usual))
        if usual[joint] > _LARGEST_NM[name]:
            text = (
                f"{name} exceeds {usual[joint]:.4g} in 5 % of the samples: a very large arm, or mN m; read as N m; if "
                "it is mN m, divide the column by 1000"
            )
            findings.append(Finding("torque_unit_suspected", text, joint + 1, float(usual[joint])))
    used = next(name for name in TORQUE_CHANNELS if name in columns)
    poor = per_joint(lambda joint: _poor(recording, columns, used, joint), len(recording.joint_names))
    return recording.with_findings(*findings, *poor)


def _poor(recording: Recording, columns: Mapping[str, Column], channel: str, joint: int) -> Finding | None:
    """Say of a moving joint that its torque is constant, or a few steps of a sensor, or rounded to coarse steps."""
    torque, dq = columns[channel].sample[:, joint], columns["dq"].sample[:, joint]
    forwards, backwards = torque[dq > MOVING_RAD_S], torque[dq < -MOVING_RAD_S]
    if len(forwards) + len(backwards) < _FEWEST_MOVING:
        return None
    name, step, rms = f"{channel} ({recording.mapping.get(channel, channel)})", _step(torque), float(np.std(torque))
    dead = ""
    if columns[channel].highest[joint] == columns[channel].lowest[joint]:
        dead = f"constant: {name} is {torque[0] + 0.0:g} in all rows while the joint moves"
    elif 0.0 < rms < min(_FEW_STEPS * step, _LEAST_NM):
        dead = f"dead: {name} varies by {rms:.2g} rms, a few steps of {step:.2g}"
    if dead:
        advice = "no friction is estimated from it; check the sensor, or exclude the joint with --joints"
        return Finding("torque_dead", f"torque channel is {dead}; {advice}", joint + 1)
    if min(len(forwards), len(backwards)) < _FEWEST_MOVING:
        return None
    reverses = 0.5 * abs(float(np.mean(forwards) - np.mean(backwards)))
    if step <= _COARSE * reverses:
        return None
    message = (
        f"{name} is quantised to {step:.3g}, the part that reverses with the motion is {reverses:.2g}: quantisation "
        "limits the estimate; log the torque with more digits"
    )
    return Finding("torque_coarse", message, joint + 1, step)


def _step(torque: Float) -> float:
    """Return the step to which a torque is rounded, 0 if it takes too many values or is no multiple of any."""
    values = np.unique(torque)
    steps = np.diff(values)
    steps = steps[steps > 1e-6 * (values[-1] - values[0])]
    if not 0 < len(steps) <= _MOST_VALUES:
        return 0.0
    step = float(steps.min())  # Coulomb friction alone takes two values, no multiples of their distance
    return step if np.abs(values / step - np.round(values / step)).max() < _UNEVEN else 0.0
