"""The proof of the sign: friction takes energy, so the net energy must rise.

The energy itself proves little on a real log: paths are not closed, so gravity errors, torque offsets and inertia put
more energy in than friction takes out. What friction alone does is to change its sign with the direction of motion.
So per joint, over the samples that move,

    F_m + u = f sgn(dq) + o + a sin q + b cos q + B ddq + noise

and the sign is proved where f, the torque against the motion, is positive beyond its standard error; f times the path
is the energy taken. The noise is not white (vibration, gravity of other joints), so the standard error is that of
independent strokes: a stroke is the motion between two reversals. Few strokes know their error badly: Student's t.
"""

from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from friction_audit.joint_log import Bool, Float, Int, JointLog, LogInBlocks, block_means, median_step, samples_per_mean
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.interaction import FITTED_STROKES, SignEvidence

# A sample moves above a fifth of the joint's peak speed, at most 0.05 rad/s, and at least 0.01 unless all is slow.
SLOWEST_RAD_S, FASTEST_RAD_S, SHARE_OF_PEAK = 0.01, 0.05, 0.2
STILL_RAD_S, STILL_RAD = 0.02, 0.05  # a joint whose peak speed and range stay below these does not move
SHARE_OF_FARTHEST = 0.1
MINIMUM_STROKES = 4
SIGNIFICANT = 2.0  # standard errors of many strokes
LARGEST_SCORE = 5.0  # standard errors beyond which a score comes from gravity or inertia, not from more certainty
BRIDGED_S = 0.1  # a step of the clock up to this is no hole here: the motion of the mean is well below 5 Hz

Verdict = Literal["rises", "falls", "undecided", "still", "no_torque"]


class CoarseLog(NamedTuple):
    """Means of a log over blocks of samples, m blocks."""

    samples: int  # samples per block
    t: Float  # time, shape (m,) [s]
    q: Float  # position, shape (m, j) [rad]
    dq: Float  # velocity, shape (m, j) [rad/s]
    whole: Bool  # False where a block holds or touches a hole in the log, shape (m,)
    of_means: bool = False  # True where the log itself holds nothing but the means
    share: float = 1.0  # of the log that has means

    def mean(self, signal: Float) -> Float:
        """Return the block means of another signal of the log, shape (n, j) -> (m, j)."""
        return signal.copy(order="F") if self.of_means else block_means(signal, self.samples)


def coarse_log(log: JointLog) -> CoarseLog:
    """Return block means of a log at about COARSE_HZ."""
    means = log if isinstance(log, LogInBlocks) else None
    samples = means.mean_of if means else samples_per_mean(median_step(log.t), len(log.t))
    t, q, dq = (a if means else block_means(a, samples) for a in (log.t[:, None], log.q, log.dq))
    numbers = means.numbers if means else np.arange(len(t))
    holes = log.gaps_longer_than(max(BRIDGED_S, 3.0 / log.rate_hz))[:, 0].astype(np.int64)
    # Means of two stretches that are far apart are no neighbours.
    ends = np.flatnonzero(np.diff(numbers) > 1)
    cut = np.append(holes, holes + 1) // samples, numbers[np.append(ends, ends + 1)]
    whole, share = ~np.isin(numbers, np.concatenate(cut)), len(t) / (means.samples // samples) if means else 1.0
    return CoarseLog(samples, t[:, 0], q, dq, whole, of_means=means is not None, share=share)


def prove_sign(log: CoarseLog, torque: Float, dead_torque: frozenset[int] = frozenset()) -> tuple[SignEvidence, ...]:
    """Judge for every joint whether the net energy of F_m + u, shape (m, j), rises; some (1..j) have a dead torque."""
    found = per_joint(lambda joint: _judge(log, joint, torque[:, joint]), log.q.shape[1])
    return tuple(replace(one, verdict="no_torque") if one.joint in dead_torque else one for one in found)


def voting(evidence: tuple[SignEvidence, ...]) -> tuple[SignEvidence, ...]:
    """Return the joints that move on their own account: the noise of others, or of a dead torque, has no vote."""
    moved = [one for one in evidence if one.verdict not in ("still", "no_torque")]
    farthest = max((one.path_rad for one in moved), default=0.0)
    return tuple(one for one in moved if one.path_rad >= SHARE_OF_FARTHEST * farthest)


def most(evidence: tuple[SignEvidence, ...], verdict: Verdict) -> bool:
    """Return True if the joints that vote have this verdict, ``rises`` or ``falls``, together (Stouffer's method)."""
    scores = np.array([one.normal_score for one in voting(evidence) if np.isfinite(one.score)])
    if not scores.size:
        return False
    combined = float(np.clip(scores, -LARGEST_SCORE, LARGEST_SCORE).sum() / np.sqrt(len(scores)))
    return (combined if verdict == "rises" else -combined) > SIGNIFICANT


def strokes_of(log: CoarseLog, joint: int) -> tuple[Bool, Float, Int]:
    """Return where a joint moves, shape (m,), and there the direction and the number of the stroke."""
    speed = np.abs(log.dq[:, joint])
    is_slow = speed.max() < STILL_RAD_S and np.ptp(log.q[:, joint]) >= STILL_RAD
    slowest = 0.0 if is_slow else SLOWEST_RAD_S
    moving = (speed > np.clip(SHARE_OF_PEAK * speed.max(), slowest, FASTEST_RAD_S)) & log.whole
    direction = np.sign(log.dq[moving, joint])
    return moving, direction, np.cumsum(np.diff(direction, prepend=direction[:1]) != 0)


def _judge(log: CoarseLog, joint: int, torque: Float) -> SignEvidence:
    step, speed = median_step(log.t) / log.share, np.abs(log.dq[:, joint])
    moving, direction, stroke = strokes_of(log, joint)
    moves = speed.max() >= STILL_RAD_S or np.ptp(log.q[:, joint]) >= STILL_RAD
    verdict: Verdict = "undecided" if moves else "still"
    against = error = float("nan")
    if verdict != "still" and stroke.size > 0 and stroke[-1] + 1 >= MINIMUM_STROKES:
        q = log.q[moving, joint]
        ddq = np.gradient(log.dq[:, joint], log.t)[moving]
        others = np.array([np.ones(len(q)), np.sin(q), np.cos(q), ddq]).T
        against, error = _coefficient(direction, others, torque[moving], stroke)
    found = SignEvidence(
        joint=joint + 1,
        verdict=verdict,
        moving_s=step * int(np.count_nonzero(moving)),
        path_rad=step * float(speed[moving].sum()),
        against_motion_nm=against,
        standard_error_nm=error,
        strokes=int(stroke.max(initial=-1)) + 1,
    )
    # Of torque that is noise-free the error is zero, and there is no score.
    if abs(against) > 0.0 and not abs(found.normal_score) <= SIGNIFICANT:
        return replace(found, verdict="rises" if against > 0 else "falls")
    return found


def _coefficient(column: Float, others: Float, torque: Float, stroke: Int) -> tuple[float, float]:
    """Regress the torque on a column, given others (Frisch, Waugh and Lovell); the error is clustered by stroke."""
    scaled = others / np.linalg.norm(others, axis=0).clip(min=np.finfo(float).tiny)
    both = np.array([column, torque]).T
    # The normal equations will do: what the cut-off leaves out of the other columns is too small to matter.
    fitted: Float = scaled @ (np.linalg.pinv(scaled.T @ scaled, rcond=1e-10, hermitian=True) @ (scaled.T @ both))
    own, left = (both - fitted).T
    square = float(own @ own)
    if square < 1e-6 * len(own):
        return float("nan"), float("nan")
    value = float(own @ left) / square
    scores = np.bincount(stroke, weights=own * (left - value * own))
    strokes = len(scores)
    return value, float(np.sqrt(scores @ scores * strokes / (strokes - FITTED_STROKES)) / square)
