"""The regression problem of one joint: response, nominal columns, nuisance columns, folds of whole cycles."""

import cmath
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import exp, sqrt
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.known_load import chain_basis, left_to_effects, with_gravity
from friction_audit.diagnosis.samples import SAMPLE_HZ, NominalModel, Samples, corner_for, least_squares, make_samples
from friction_audit.effects.joint_data import JointData, Nominal, displacement
from friction_audit.effects.joint_model import JointModel
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Bool, Float, Int
from friction_audit.preprocessing.even_grid import first_order
from friction_audit.preprocessing.interaction import Caution
from friction_audit.robot.unknown_chain import project_out

FOLDS = 10  # at most (R. Kohavi, Proc. IJCAI (1995) 1137); of ten cycles five folds would take two at once
FEWEST_SAMPLES = 50  # G. E. P. Box, G. M. Jenkins, Time Series Analysis (1970): fewer show no autocorrelation
KNOTS = 6  # most of a curve, quantiles of its quantity
MOST_CYCLES_PER_KNOT = 6  # a curve has at most so many numbers as a third of the cycles, two per knot
SIGNS = (np.tanh, lambda v: v / np.hypot(v, 1.0))  # smoothed, with a short tail and with a long one
# A sign smoothed by up to 10 mrad/s is a regularised drive, no effect.
SIGN_WIDTHS_RAD_S = np.geomspace(5e-4, 1.2e-2, 9)
SMOOTHED: tuple[str, ...] = ("smoothed_sign",)  # what its columns are left out by
SIGN_COLUMNS = 2.0  # the smoothed sign, and its change with the width
SLOW_RAD_S = 5e-3  # below it the law of friction is as uncertain as right after a reversal
SETTLED = 0.9  # of the corner: a change that is not worth another filter
OFFSET_SHARE = 0.0025  # of Coulomb friction: a quarter of what counts as negligible
PLAUSIBLE_SD = 2.5  # a nuisance that wants to be larger stands for something else
SAMPLE_SD = 0.29  # of a sample, the standard deviation of a delay evenly spread over one sample
REVERSAL_S = 0.05  # time over which a wrong formula of a reversal fades
LAGS_S = (0.03, 0.1, 0.3, 1.0, 3.0)  # of the velocity behind a first-order filter
RINGING_HZ, DAMPING_RATIOS = np.geomspace(1.0, 12.0, 8), (0.05, 0.2)  # of what the acceleration excites
# Share of the corner up to which responses ring: a faster one follows the noise of the acceleration and takes it out of
# the residual (resampled: none 130002 linear).
KNOWN_SHARE = 0.5
MODEL_ERROR = {"reversal": 0.04, "inertia": 0.01}  # of Coulomb friction, of the inertial torque


class Axis(NamedTuple):
    """A quantity of every sample."""

    name: str  # one word
    label: str  # for the axis of a figure, with the unit
    value: Callable[[JointData], Float | None]  # the quantity, shape (n,), or None where the log does not have it


def _neighbour(data: JointData) -> Float | None:
    """Acceleration of the other joint that moves most, in its own units."""
    others: Float = np.delete(data.others.ddq, data.others.joint, axis=1)
    return others[:, int(np.argmax(others.std(axis=0)))] if others.shape[1] else None


# In the order in which equal ones are reported.
AXES: tuple[Axis, ...] = (
    Axis("speed", "speed [rad/s]", lambda data: np.abs(data.dq)),
    Axis("position", "position [rad]", lambda data: data.q),
    Axis("displacement", "displacement since reversal [rad]", lambda data: np.abs(displacement(data))),
    Axis("acceleration", "acceleration [rad/s²]", lambda data: data.ddq),
    Axis("time", "time [s]", lambda data: data.t),
    Axis("load", "predicted load [N m]", lambda data: data.load),
    Axis("temperature", "temperature [°C]", lambda data: data.temperature),
    Axis("neighbour", "acceleration of a neighbour [rad/s²]", _neighbour),
)


class Nuisance(NamedTuple):
    """A column that is no physics of the joint, with a normal prior about zero."""

    column: Float  # on the samples, shape (m,)
    sd: float  # standard deviation of its coefficient, unit of the coefficient
    replaced_by: tuple[str, ...] = ()  # effects that stand for the same thing and take its place


class Curve(NamedTuple):
    """A piecewise linear curve over one quantity for each direction of motion, on the samples."""

    axis: Axis  # the quantity
    columns: Float  # shape (k, m)
    values: Float  # the quantity itself, shape (m,)


@dataclass(frozen=True, eq=False, kw_only=True)
class RegressionProblem:
    """Samples of one joint at the Nyquist rate of their filter; m samples, b nominal columns."""

    data: JointData  # the joint on the fine grid
    samples: Samples  # filter, times and cycles of the samples
    nominal: NominalModel  # the nominal model, its columns on the samples
    age: Int  # samples before each one in its unbroken stretch, shape (m,)
    fold: Int  # number of the fold of each sample, whole cycles, shape (m,)
    curves: tuple[Curve, ...]  # a curve over every quantity that varies
    # Rigid-body torque of an unknown chain, orthonormal, shape (k, m): response and columns are free of it
    # (R. Frisch, F. V. Waugh, Econometrica 1 (1933) 387).
    chain: Float = field(default_factory=lambda: np.empty((0, 0)))
    with_chain: "RegressionProblem | None" = None  # the same with the torque of the chain, None without one

    @classmethod
    def build(cls, data: JointData, model: JointModel | None) -> "RegressionProblem":
        """Filter and thin out a joint.

        Raises:
            AnalysisError: If the model leaves nothing to fit, or the motion is read in steps that are too coarse.
        """
        data = with_gravity(data)
        samples = make_samples(data)
        nominal = NominalModel.build(data, samples, model)
        # Noise of the acceleration makes its coefficient too small, below the first corner hardly (Fuller 1987).
        for least in (1.0, SETTLED):
            inertia = abs(nominal.baseline(least_squares(nominal.columns.T, nominal.y)).inertia_kg_m2)
            corner, coarse = corner_for(data, inertia)
            if coarse > 1.0:
                step = 12.0**0.5 * data.rounding
                numbers = {"channel": data.derived_from, "case": data.derived_from, "step": step}
                raise AnalysisError((Caution("coarse_steps", numbers=numbers | {"largest": step / coarse}),))
            if corner < least * samples.corner_hz:
                samples = make_samples(data, corner)
                nominal = NominalModel.build(data, samples, model)
        # A signal without content above the corner needs two samples per period of the corner.
        step = max(1, int(np.ceil(SAMPLE_HZ / (2.0 * samples.corner_hz) - 0.25)))
        kept = (samples.place % step == 0) | samples.breakaway
        samples = samples.keep(kept)
        refuse_few(data, samples)
        nominal = replace(nominal, columns=nominal.columns[kept], y=nominal.y[kept])
        follows = np.diff(samples.place, prepend=-(10**6)) == step
        follows &= samples.cycle == np.roll(samples.cycle, 1)
        follows &= ~samples.breakaway & ~np.roll(samples.breakaway, 1)
        fold, curves = folds_of(samples.cycle), _curves(data, samples)
        made = cls(data=data, samples=samples, nominal=nominal, age=_age(follows), fold=fold, curves=curves)
        return made._free_of_chain() if data.unknown_gravity and data.rigid is None else made

    def _free_of_chain(self) -> "RegressionProblem":
        samples, nominal = self.samples, self.nominal
        chain = chain_basis(self.data, samples.weight, self.columns, self.X, self.y)
        y, nominal_y = project_out(chain, np.stack([samples.y, nominal.y]))
        return replace(
            self,
            chain=chain,
            with_chain=self,
            samples=replace(samples, y=y),
            nominal=replace(nominal, columns=project_out(chain, self.X).T, y=nominal_y),
            curves=tuple(Curve(c.axis, project_out(chain, c.columns), c.values) for c in self.curves),
        )

    @property
    def folds(self) -> int:
        """Number of folds."""
        return int(self.fold.max()) + 1

    @property
    def y(self) -> Float:
        """Response, shape (m,). [N m]"""
        return self.nominal.y

    @cached_property
    def order(self) -> Int:
        """Samples fold by fold, in the order of time within each, shape (m,)."""
        return np.argsort(self.fold, kind="stable")

    @cached_property
    def X(self) -> Float:
        """Nominal columns, shape (b, m)."""
        return np.ascontiguousarray(self.nominal.columns.T)

    @cached_property
    def kinematics(self) -> tuple[Float, Float, Float]:
        """Position, velocity, acceleration at the samples, shape (m,) each."""
        at = self.samples.fine
        return self.data.q[at], self.data.dq[at], self.data.ddq[at]

    @cached_property
    def responses(self) -> list[Float]:
        """Linear responses of first and second order to the motion, on the samples, shapes (1 or 2, m)."""
        data, highest = self.data, KNOWN_SHARE * self.samples.corner_hz
        found = [self.columns(first_order(data.dq, exp(-data.step_s / lag), 0.0)[:, None]) for lag in LAGS_S]
        for hertz, damping in product(RINGING_HZ[highest >= RINGING_HZ].tolist(), DAMPING_RATIOS):
            pole = cmath.exp(2.0 * np.pi * hertz * data.step_s * (1j * sqrt(1.0 - damping**2) - damping))
            rung = first_order(data.ddq.astype(complex), pole, 0j)
            found.append(self.columns(np.column_stack([rung.real, rung.imag])))
        return found

    @cached_property
    def smoothed(self) -> Float:
        """The acceleration without what its noise hides, on the samples, shape (1, m).

        What the true one differs by is left of y, and follows the measured one by no more than this (regression
        calibration: R. J. Carroll et al., Measurement Error in Nonlinear Models (2006), ch. 4).
        """
        from scipy.ndimage import gaussian_filter1d

        sigma_s = 1.0 / (np.pi * self.samples.corner_hz)  # half of the corner
        return self.columns(gaussian_filter1d(self.data.ddq, sigma_s / self.data.step_s)[:, None])

    def columns(self, fine: Float) -> Float:
        """Columns of the fine grid, shape (n, p), on the samples, shape (p, m)."""
        return project_out(self.chain, np.ascontiguousarray(self.samples.of(fine).T))

    @cached_property
    def near(self) -> tuple[Int, JointData, Callable[[Float], Float]]:
        """Where the filter reads the fine grid, the joint there, and what makes samples of its columns."""
        read, samples = self.samples.near(len(self.data.t))
        return read, self.data.at(read), lambda fine: project_out(self.chain, np.ascontiguousarray(samples.of(fine).T))

    @cached_property
    def left_to_effects(self) -> Float:
        """What the chain without a model leaves to effects, shape (e, m); without it friction is far off at first."""
        return self.columns(left_to_effects(self.data)) if len(self.chain) else np.empty((0, len(self.y)))

    def without(self, dropped: Bool) -> "RegressionProblem":
        """The problem without some samples, shape (m,)."""
        kept = np.flatnonzero(~dropped)
        follows = (np.diff(kept, prepend=-2) == 1) & (self.age[kept] > 0)
        return replace(
            self,
            samples=self.samples.keep(~dropped),
            nominal=replace(self.nominal, columns=self.nominal.columns[kept], y=self.y[kept]),
            age=_age(follows),
            fold=self.fold[kept],
            chain=self.chain[:, kept] if len(self.chain) else self.chain,
            with_chain=self.with_chain and self.with_chain.without(dropped),
            curves=tuple(Curve(c.axis, c.columns[:, kept], c.values[kept]) for c in self.curves),
        )

    def nuisances(self, baseline: Nominal, given: Float, sign: Callable[[Float], Float] = np.tanh) -> list[Nuisance]:
        """Smoothing of the sign given other columns, shape (b, m); delay of the recorder, offset of the sensor."""
        data, coulomb = self.data, abs(baseline.coulomb_nm)
        fine, signs = [], self._smoothed_sign(given, sign)
        priors = [(coulomb, SMOOTHED)] * len(signs)
        if data.sample_s > 0:
            fine.append(-np.gradient(baseline.torque, data.step_s))
            priors.append((SAMPLE_SD * data.sample_s, ("time_delay",)))
        fine.append(np.ones(len(data.t)))
        offset_sd = np.inf if data.unknown_gravity else OFFSET_SHARE * coulomb  # gravity of other joints may be one
        priors.append((offset_sd, ("torque_bias", "asymmetric_coulomb")))
        columns = zip([*signs, *self.columns(np.column_stack(fine))], priors, strict=True)
        return [Nuisance(column, max(sd, 1e-12), names) for column, (sd, names) in columns]

    def _smoothed_sign(self, given: Float, sign: Callable[[Float], Float]) -> list[Float]:
        """What a smoothed sign differs from the sign by, at the width that fits best, and its change with the width."""
        (_, near, seen), inside = self.near, np.linalg.qr(given.T)[0].T
        signs = seen((sign(near.dq / SIGN_WIDTHS_RAD_S[:, None]) - near.direction).T)
        free = signs - (signs @ inside.T) @ inside
        gain = (free @ self.y) ** 2 / np.maximum(np.sum(free**2, axis=1), 1e-300)
        k = int(np.clip(np.argmax(gain), 1, len(gain) - 2))
        return [signs[k], 0.5 * (signs[k + 1] - signs[k - 1])]

    def model_error(self, baseline: Nominal) -> Float:
        """Standard deviation of what any formula gets wrong: at reversals and in proportion to the inertia, (m,)."""
        turns = self.data.t[np.flatnonzero(np.diff(np.sign(self.data.dq)) != 0)]
        turns = np.concatenate([[-np.inf], turns, [np.inf]])
        t, dq, ddq = self.samples.t, *self.kinematics[1:]
        k = np.searchsorted(turns, t)
        nearest = np.minimum(t - turns[k - 1], turns[k] - t)
        near = np.maximum(np.exp(-nearest / REVERSAL_S), np.exp(-np.abs(dq) / SLOW_RAD_S))
        reversal = MODEL_ERROR["reversal"] * abs(baseline.coulomb_nm) * near
        return np.hypot(reversal, MODEL_ERROR["inertia"] * abs(baseline.inertia_kg_m2) * np.abs(ddq))


def refuse_few(data: JointData, samples: Samples) -> None:
    """Raise AnalysisError where the log's rate, or its noise, leaves too few samples in the cycles that it holds."""
    if (left := len(samples.cycle)) < FEWEST_SAMPLES:
        cycles = len(np.unique(data.cycle[data.cycle >= 0]))
        numbers = {"samples": left, "fewest": FEWEST_SAMPLES, "cycles": cycles, "rate_hz": 1.0 / data.step_s}
        raise AnalysisError((Caution("too_few_samples", numbers=numbers | {"corner_hz": samples.corner_hz}),))


def folds_of(cycle: Int) -> Int:
    """Fold of each sample, shape (m,): of every ten cycles that follow each other one in each fold, in mixed order."""
    numbers, place = np.unique(cycle, return_inverse=True)
    rng, folds = np.random.default_rng(0), min(FOLDS, len(numbers))  # the answer depends on no draw
    blocks = [rng.permutation(folds) for _ in range(0, len(numbers), folds)]
    return np.concatenate(blocks)[place].astype(np.int64)


def _age(follows: Bool) -> Int:
    place = np.arange(len(follows))
    return (place - np.maximum.accumulate(np.where(follows, 0, place))).astype(np.int64)


def _curves(data: JointData, samples: Samples) -> tuple[Curve, ...]:
    most = int(np.clip(len(np.unique(samples.cycle)) // MOST_CYCLES_PER_KNOT, 2, KNOTS))
    found, (read, near) = [], samples.near(len(data.t))
    for axis in AXES:
        values = axis.value(data)
        if values is None or not np.ptp(values[samples.fine]) > 0.0:  # a neighbour that moves between samples alone
            continue
        if len(knots := knots_of(values, data.used, most)) > 1:  # no constant
            columns = np.ascontiguousarray(near.of(curve(values[read], knots, data.dq[read])).T)
            found.append(Curve(axis, columns, values[samples.fine]))
    return tuple(found)


def knots_of(values: Float, counted: Bool, most: int = KNOTS) -> Float:
    """Quantiles of a quantity over the samples that count, without repetition, shape (k,); k below 2 if constant."""
    if not counted.any():
        return np.zeros(0)
    knots = np.unique(np.quantile(values[counted], np.linspace(0.0, 1.0, most)))
    apart = np.diff(knots) > 1e-9 * max(float(np.ptp(knots)), 1e-12)
    return np.asarray(knots[np.append(True, apart)], np.float64)


def curve(values: Float, knots: Float, dq: Float) -> Float:
    """A piecewise linear curve over a quantity for each direction of motion, shape (n, 2 k)."""
    k = np.clip(np.searchsorted(knots, values) - 1, 0, len(knots) - 2)
    share = np.clip((values - knots[k]) / (knots[k + 1] - knots[k]), 0.0, 1.0)
    columns, every = np.zeros((2 * len(knots), len(values))), np.arange(len(values))
    k += np.where(dq > 0, 0, len(knots))
    columns[k, every], columns[k + 1, every] = 1.0 - share, share
    return columns.T
