"""The same coefficients from the torque itself: a robust regression, with intervals that allow for autocorrelation.

    F_m + u = mu_c sgn(v) + mu_v v + b + c_x g_x + c_y g_y + B dv/dt

It weighs slow and fast motion alike where the energy method weighs by power, so the two differ when friction is not
Coulomb plus viscous, when torque and velocity are not simultaneous, or when the model lacks something.

The noise of the measured velocity would make least squares find too little inertia: velocity and acceleration by the
position are instruments for them.

Rows of one stroke share their errors, so strokes are left out one at a time, as cycles are by the default estimator.

Gravity and inertia of an arm without a model are Gaussian processes in addition to these columns: those of
``robot.unknown_chain``, their coefficients left out with the strokes. All checks are on rows whitened with it.
"""

from collections import defaultdict
from collections.abc import Mapping
from functools import partial

import numpy as np

from friction_audit.friction.history import TorqueRegression
from friction_audit.friction.reasons import SMALLEST_SPREAD
from friction_audit.friction.settings import FEWEST_CYCLES
from friction_audit.friction.weighted import CUTOFF, Fit, Rows, fit_rows
from friction_audit.joint_log import Float, Int
from friction_audit.preprocessing.interaction import Caution, Interaction, Reason
from friction_audit.preprocessing.velocity import RESTING_RAD, filter_velocity, settling_samples
from friction_audit.robot.unknown_chain import ChainMotion, chain_columns, constant_coupling

CUTOFF_HZ = 20.0
ROW_RATE_HZ = 50.0
MOST_ROWS, MOST_WITH_CHAIN = 20_000, 6_000  # the second with an unknown chain
FEWEST_ROWS = 100
# A difference of neighbours is a mean slope: torque and velocity are averaged likewise, for the inertia of slow logs.
NEIGHBOURS, SIMPSON = np.array([-1, 0, 1]), np.array([1.0, 4.0, 1.0]) / 6.0
SETTLED = 41  # samples by which the filter's response to an impulse exceeds the part that is used
LONGEST = 2.0  # times its nominal duration that a row's support may last; beyond, there is a hole in it
BLOCK_S = 0.02  # the position is averaged over so long, against its noise and resolution [s]
NEARLY_WHOLE = 0.01  # steps of 1 ms, with the rounding of stamps of today, are as many as those from 0
LEAST_SWING = 1e-3  # of directions of gravity and of motion: one that changes less shows nothing of its own
# Of columns of unit length: beyond, they are as good as collinear (Belsley, Kuh, Welsch, Regression Diagnostics, 1980).
# That offset and gravity are collinear with each other, over a short range, does no harm to friction.
HIGHEST_CONDITION = 30.0
LEAST_ONE_WAY = 0.1  # share of the samples that each direction has at least, or the offset takes what is friction
# Partial R^2 of direction and velocity. Measured excitation logs: 0.90 and more where the coefficients agree with the
# published ones, 0.79 where the inertia of other joints doubles the Coulomb coefficient.
LEAST_FRICTION_SHARE = 0.85
# Share of the residual that another joint's velocity may explain: 0.92, 0.96 where two share gears, else at most 0.40.
LARGEST_COUPLED_SHARE = 0.5
# Half widths of 95 % that the coefficients of jerk and inertia must differ from zero; of the jerk the second is enough
# where the viscous coefficient leaves its interval with it. A shorter delay is harmless.
CERTAIN, LIKELY, SHORTEST_DELAY_S = 2.5, 1.5, 2e-3
# The direction, averaged over so long, stands for a low-pass of 2 Hz. The share of Coulomb friction that follows it is
# 0.3 and more in filtered logs, at most 0.08 where no friction builds up over a distance.
TURN_S, LEAST_FOLLOWING, SURE = 0.3, 0.25, 3.0
# Of an unknown chain: rows that are candidates for the Cholesky decomposition; standard deviation of a coefficient
# without a prior, and the least that counts, in units of the noise; least share of a column that no others hold.
CANDIDATES, NO_PRIOR, LEAST_SD, SMALLEST = 1500, 1e4, 0.3, 1e-3
MOST_PER_ROW = 0.25  # columns of the chain: friction needs rows too
MOST_COLUMNS = 100  # of a process: with 300 Coulomb friction of whole_arms is no closer, and it takes 3 times as long


def regress_torque(
    rows: "RegressionRows", dead_band_rad_s: float, others: "Mapping[int, RegressionRows] | None" = None
) -> TorqueRegression | None:
    """Regress the torque of one joint on its motion, samples slower than the dead band left out.

    With the rows of the other joints by number it is also checked whether the regression can stand for the friction of
    the joint where no energy does. Too few moving samples or strokes give None. With an unknown chain first; where
    that leaves a doubt, of a short log as a rule, without.
    """
    if not rows.found:  # the log is shorter than what a row needs
        return None
    found = rows.moving(dead_band_rad_s)
    strokes = int(found.stroke[-1]) + 1 if len(found.stroke) else 0
    if len(found.torque) < FEWEST_ROWS or strokes < FEWEST_CYCLES:
        return None
    # In single precision: a hundred columns that depend on each other ask for more digits than blocks agree in.
    with_chain = rows.moving(dead_band_rad_s, -(-len(found.torque) // MOST_WITH_CHAIN), np.float32)
    with_chain = with_chain._replace(chain=rows.unknown_chain(with_chain))
    if with_chain.chain is not None and not (regression := _regress(with_chain, dead_band_rad_s, others or {})).doubt:
        return regression
    return _regress(found, dead_band_rad_s, others)


def _regress(found: Rows, dead_band_rad_s: float, others: "Mapping[int, RegressionRows] | None") -> TorqueRegression:
    equations, fit = fit_rows(found)
    condition, correlation = equations.conditioning()
    free = found.free()
    doubt: Reason = ()
    if others is not None:
        doubt = _coupling(found, others, dead_band_rad_s) or _doubt(found, fit)
    return TorqueRegression(
        coulomb=fit.coefficient("coulomb"),
        viscous=fit.coefficient("viscous"),
        offset_nm=fit.coefficient("offset").value,
        inertia=fit.coefficient("inertia"),
        residual_rms_nm=float(np.sqrt(np.mean((free.torque - free.columns @ fit.value[0, : len(found.names)]) ** 2))),
        samples=len(found.torque),
        condition_number=condition,
        correlation=correlation,
        delay_s=_delay(found, fit),
        turning=_turning(found),
        doubt=doubt,
    )


def _delay(rows: Rows, plain: Fit) -> float:
    """Return how late the torque is, NaN if that is not certain. [s]

    Of a torque that is late by d, the inertia leaves -d B times the jerk. Noise of the jerk makes it too small.
    """
    (jerk, jerk_half), (inertia, inertia_half), (viscous, _) = _fit_with(rows, "jerk", "inertia", "viscous")
    old = plain.coefficient("viscous")
    sure = CERTAIN if old.low <= viscous <= old.high else LIKELY
    is_certain = abs(jerk) > sure * jerk_half and inertia > CERTAIN * inertia_half
    return -jerk / inertia if is_certain and abs(jerk) > SHORTEST_DELAY_S * inertia else np.nan


def _turning(rows: Rows) -> tuple[float, float] | None:
    """Return both coefficients if friction may change slowly at reversals, None if it changes at once.

    Friction that builds up over a distance follows a slower mean of the direction.
    """
    if not np.any(np.abs(rows.more["turning"]) > LEAST_SWING):  # no row is next to a reversal
        return None
    (follows, half), (coulomb, _), (viscous, _) = _fit_with(rows, "turning", "coulomb", "viscous")
    return (coulomb, viscous) if follows > SURE * half and follows > LEAST_FOLLOWING * coulomb > 0.0 else None


def _fit_with(rows: Rows, name: str, *others: str) -> list[tuple[float, float]]:
    """Return value and half width of one more column and of others that were there, fitted together."""
    columns, instruments = (np.vstack([one.T, rows.more[name]]).T for one in (rows.columns, rows.instruments))
    _, fit = fit_rows(rows._replace(names=(*rows.names, name), columns=columns, instruments=instruments))
    return [(float(value[0]), float(half[0])) for value, half in map(fit.column, (name, *others))]


def _doubt(rows: Rows, fit: Fit) -> Reason:
    """Say why direction and velocity do not stand for friction; empty if they do."""
    speed, forwards = np.abs(rows.columns[:, 1]), float(np.mean(rows.columns[:, 0] > 0))
    if min(forwards, 1.0 - forwards) < LEAST_ONE_WAY:
        return (Caution("mostly_one_way", numbers={"percent": 100 * max(forwards, 1.0 - forwards)}),)
    if speed.std() < SMALLEST_SPREAD * speed.mean():
        return (Caution("one_speed_in_rows", numbers={"mean": float(speed.mean())}),)
    rows = rows.free()
    unit = rows.columns / np.linalg.norm(rows.columns, axis=0).clip(min=CUTOFF)
    apart = np.linalg.qr(np.roll(unit, -2, axis=1))[1][-2:, -2:]  # direction and speed without the others
    condition = 1.0 / float(np.linalg.norm(apart, -2).clip(min=CUTOFF))
    if not condition < HIGHEST_CONDITION:
        return (Caution("collinear", numbers={"condition": condition, "most": HIGHEST_CONDITION}),)
    share = 1.0 - _left_by(rows.columns, rows.torque) / _left_by(rows.columns[:, 2:], rows.torque)
    if share < LEAST_FRICTION_SHARE:
        return (Caution("little_friction", numbers={"percent": 100 * LEAST_FRICTION_SHARE}),)
    found = [fit.coefficient(name) for name in ("coulomb", "viscous")]
    if not max(one.low for one in found) > 0.0 or min(one.high for one in found) < 0.0:
        return (Caution("no_positive_coefficient"),)
    return ()


def _coupling(rows: Rows, others: "Mapping[int, RegressionRows]", dead_band_rad_s: float) -> Reason:
    """Say whether the residual follows the velocity of another joint; empty if it does not."""
    free = rows.free()
    left = _left_by(free.columns, free.torque)
    for number, other in others.items():
        velocity = other.found["velocity"][rows.place]
        direction = np.tanh(velocity / dead_band_rad_s)
        more = np.column_stack([free.columns, rows.whitened(np.column_stack([direction, velocity]))])
        share = 1.0 - _left_by(more, free.torque) / left
        if share > LARGEST_COUPLED_SHARE:
            return (Caution("coupled", numbers={"other": number}),)
    return ()


def _left_by(columns: Float, torque: Float) -> float:
    """Return the sum of squares that least squares on some columns leaves."""
    return float(np.sum((torque - columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]) ** 2))


class RegressionRows:
    """Gathers the rows of the regression of one joint from parts of a log that follow each other."""

    def __init__(self, column: int, samples: int, rate_hz: float) -> None:
        """Take the joint (0-based), the number of samples of the log and their rate."""
        self._column, self._step_s = column, 1.0 / rate_hz
        block = 2 * int(0.5 * BLOCK_S / self._step_s + NEARLY_WHOLE) + 1  # an odd number, so that it has a middle
        self.around = around = block + block // 2 + 1
        self._spacing = max(int(1.0 / (ROW_RATE_HZ * self._step_s) + NEARLY_WHOLE), samples // MOST_ROWS, 1)
        self._index = np.arange(around, samples - around, self._spacing)
        self._turn = int(0.5 * TURN_S / self._step_s + NEARLY_WHOLE)
        self._smooth = partial(filter_velocity, rate_hz=rate_hz, cutoff_hz=CUTOFF_HZ)
        # The step of the clock, weighted as the filter weighs the samples around. The filter counts samples: its slope
        # belongs to their mean step, not to two stamps around a lost sample, of which each may err by a part of a step.
        impulse = np.zeros(2 * around + SETTLED)
        middle = len(impulse) // 2
        impulse[middle] = 1.0
        kernel = self._smooth(impulse)[middle - around + 1 : middle + around]
        self._weights = np.convolve(kernel / kernel.sum(), [-0.5, 0.0, 0.5])
        # The torque is filtered at the rows alone: the same as products with its whole response.
        self._reach = settling_samples(rate_hz, CUTOFF_HZ) - 1
        impulse = np.zeros(4 * self._reach)
        impulse[2 * self._reach] = 1.0
        response = self._smooth(impulse)[self._reach + 1 : 3 * self._reach]
        self._response = np.convolve(response, SIMPSON)
        # Weights of the averages of three neighbouring blocks, with a sample more at both ends.
        self._blocks = np.pad(np.repeat(np.eye(3) / block, block, axis=0), ((1, 1), (0, 0)))
        # By name at all rows, those at which the joint rests among them.
        self.found: dict[str, Float] = defaultdict(partial(np.empty, len(self._index)))
        # Position, velocity and acceleration of all joints where their torques hold what no model says, (3, rows, j).
        self._chain, self._joint = np.empty((0, 0, 0)), 0

    def take(self, part: Interaction, velocity: Float, start: int, stop: int) -> None:
        """Take the rows of some samples, by their numbers in the log; the velocity is filtered at CUTOFF_HZ."""
        column, around, self._joint = self._column, self.around, part.joint_numbers[self._column] - 1
        own = slice(*np.searchsorted(self._index, (start, stop)))
        index = self._index[own] - part.first
        if not len(index):
            return
        near = velocity[index[:, None] + NEIGHBOURS]
        far = velocity[index[:, None] + around * NEIGHBOURS]  # a second difference of near ones would be noise
        # Windows around the rows, as views: to gather their samples takes twice as long.
        view = {"strides": (8 * self._spacing, 8), "offset": 8 * (index[0] - around)}
        signals = (np.ascontiguousarray(one) for one in (part.t, part.q[:, column]))
        windows = (np.ndarray((len(index), 2 * around + 1), buffer=one, **view) for one in signals)
        times, positions = (one - one[:, around, None] for one in windows)
        # The mean direction around each row, of fewer samples where the log ends; a zero more, at which one may end.
        begin, end = np.maximum(index - self._turn, 0), np.minimum(index + self._turn + 1, len(velocity))
        signs = np.zeros(len(velocity) + 1)
        np.sign(velocity, out=signs[:-1])
        turning = np.add.reduceat(signs, np.stack([begin, end], axis=1).ravel())[::2] / (end - begin)
        by_position = differences(*((signal @ self._blocks).T for signal in (times, positions)))
        found = {
            "lasting": part.t[index + around] - part.t[index - around],
            "velocity": velocity[index],
            "direction": np.sign(near[:, 1]),
            "coulomb": self._filtered(signs[:-1], index),
            "viscous": near @ SIMPSON,
            "inertia": 0.5 * (near[:, 2] - near[:, 0]) / (times @ self._weights),
            "jerk": (far[:, 0] - 2.0 * far[:, 1] + far[:, 2]) / (around * self._step_s) ** 2,
            **dict(zip(("gravity_x", "gravity_y"), _gravity(part, column, index), strict=True)),
            **dict(zip(("velocity by position", "acceleration by position"), by_position, strict=True)),
            "turning": turning,
            "torque": self._filtered(part.driving(column), index),
        }
        for name, values in found.items():
            self.found[name][own] = values
        if part.posture is not None and part.gravity_direction is None:
            block = len(self._blocks) // 3  # averages once more, of all joints at once
            borders = index[:, None] + block * np.arange(4) - around + 1
            sums = np.add.reduceat(part.posture, borders.ravel(), axis=0).reshape(*borders.shape, -1)
            by_position = differences((times @ self._blocks).T[..., None], sums[:, :3].swapaxes(0, 1) / block)
            if not len(self._chain):
                self._chain = np.empty((3, len(self._index), sums.shape[2]), np.float32)
            self._chain[:, own] = part.posture[index], *by_position

    def _filtered(self, load: Float, index: Int) -> Float:
        """Return a signal at the rows, through the low-pass of the others: a linear relation asks for the same one."""
        reach, spacing = self._reach, self._spacing
        stretches = -(-len(self._response) // spacing)
        rows = len(index) + stretches - 1
        if reach <= index[0] and index[-1] + reach + 1 < len(load):
            # Stretches of one spacing times the weights of all: to copy windows that overlap takes most of the time.
            weights = np.append(self._response, np.zeros(stretches * spacing - len(self._response)))
            own = load[index[0] - reach :][: rows * spacing]
            own = np.append(own, np.zeros(rows * spacing - len(own)))  # where there is no weight
            products = own.reshape(rows, spacing) @ weights.reshape(stretches, spacing).T
            return np.asarray(sum(products[k : k + len(index), k] for k in range(stretches)))
        return np.asarray(self._smooth(load)[index[:, None] + NEIGHBOURS] @ SIMPSON)

    def moving(self, dead_band_rad_s: float, every: int = 1, digits: type = np.float64) -> Rows:
        """Return the rows at which the joint moves, or one of so many, after the last part."""
        moving = np.abs(self.found["velocity"]) > dead_band_rad_s
        place = np.flatnonzero(moving & (self.found["lasting"] < LONGEST * 2 * self.around * self._step_s))[::every]
        own = {name: column[place].astype(digits).astype(np.float64) for name, column in self.found.items()}
        columns = {name: own[name] for name in ("coulomb", "viscous")}
        columns |= {"offset": np.ones(len(place)), "inertia": own["inertia"]}
        columns |= {n: own[n] for n in ("gravity_x", "gravity_y") if len(place) and np.ptp(own[n]) > LEAST_SWING}
        by_position = {"viscous": own["velocity by position"], "inertia": own["acceleration by position"]}
        direction = own["direction"]
        return Rows(
            names=tuple(columns),
            columns=np.array([*columns.values()]).T,
            instruments=np.array([*(columns | by_position).values()]).T,
            torque=own["torque"],
            more={"jerk": own["jerk"], "turning": own["turning"] - own["coulomb"]},
            stroke=np.cumsum(np.diff(direction, prepend=direction[:1]) != 0),
            place=place,
        )

    def unknown_chain(self, rows: Rows) -> tuple[Float, Float] | None:
        """Return what of the torque a chain without a model takes, None where no other joint moves, or of few rows."""
        if not len(self._chain):
            return None
        moved = self._chain[:, rows.place].astype(np.float64)
        if not np.any(np.ptp(np.delete(moved[0], self._joint, axis=1), axis=0) > RESTING_RAD):
            return None
        motion, every = ChainMotion.of(self._joint, *moved), len(rows.place) // CANDIDATES + 1
        known = rows.columns[:, :3].T  # inertia and gravity are among the effects
        columns = chain_columns(motion, np.ones(len(rows.place)), known, rows.torque, every, MOST_COLUMNS)
        constant = np.delete(constant_coupling(motion), self._joint, axis=0)  # own inertia has a column
        constant = constant / np.linalg.norm(constant, axis=1).clip(min=CUTOFF)[:, None]
        _, size, constant = np.linalg.svd(constant, full_matrices=False)
        constant = constant[size > SMALLEST]
        columns -= (columns @ constant.T) @ constant
        square, turned = np.linalg.eigh(columns @ columns.T)
        kept = square > LEAST_SD**2
        size = np.sqrt(square[kept])
        basis = np.vstack([constant, (turned[:, kept] / size).T @ columns])
        if len(basis) > MOST_PER_ROW * len(rows.place):
            return None
        return basis, np.append(np.full(len(constant), NO_PRIOR), size)


def _gravity(interaction: Interaction, column: int, index: Int) -> list[Float]:
    """Return how gravity lies across the axis."""
    if interaction.gravity_direction is None or interaction.gravity_index is None:
        q = interaction.q[index, column]
        return [np.sin(q), np.cos(q)]
    direction = interaction.gravity_direction[:, column]
    return [np.interp(index, interaction.gravity_index, side) for side in direction.T]


def differences(t: Float, q: Float) -> tuple[Float, Float]:
    """Return velocity [rad/s] and acceleration [rad/s^2] from averages of three neighbouring blocks, shape (3, m)."""
    (before, here, after), (first, middle, last) = q, t
    left, right = (here - before) / (middle - first), (after - here) / (last - middle)
    return (after - before) / (last - first), 2.0 * (right - left) / (last - first)
