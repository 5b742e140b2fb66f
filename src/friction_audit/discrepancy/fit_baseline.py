"""The declared model, fitted to some cycles: B ddq + mu_c sgn(dq) + mu_v dq = torque.

Generalized least squares with an autoregressive noise, robust against outliers; rows of one cycle share what the noise
model does not know, so the covariance comes from leaving out one cycle at a time (the CR3 variance).

The noise of the measured velocity makes least squares find too little inertia and viscous friction, the more so in
whitened data, where high frequencies count. The position has a noise of its own: its derivatives are instruments.

References:
    T. Soderstrom, P. Stoica, Instrumental variable methods for system identification, Springer 1983.
    A. C. Cameron, D. L. Miller, A practitioner's guide to cluster-robust inference, Journal of Human
    Resources 50 (2015) 317.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from friction_audit.discrepancy.candidate import Baseline
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.noise import (
    Autoregression,
    effective_samples,
    fit_autoregression,
    integral_time,
    runs_of,
    whiten,
)
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.friction.huber import huber_weights
from friction_audit.joint_log import Float

Index = NDArray[np.int64]
CONFIDENCE = 0.95
FEWEST_CYCLES = 4
ROUNDS = 2
"""Of fitting the noise to the residual and the model to the whitened data; a third moves nothing."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class BaselineFit:
    """The declared model as fitted, with p factors.

    Attributes:
        baseline: What candidates lean on.
        names: Names of the fitted factors: ``coulomb``, ``viscous``, then ``inertia`` and ``offset`` if fitted.
        value: Their values, shape (p,).
        covariance: Cluster-robust covariance, shape (p, p).
        cycles: Number of cycles behind it.
        correlation: Between Coulomb and viscous friction.
        condition_number: Of the whitened columns, each of length 1.
        residual: Torque less the model, at every sample, shape (n,). [N m]
        fitted: Samples on which it was fitted, shape (n,).
        noise: The memory of the residual.
        tau_int_s: Integral time of the residual. [s]
        n_eff: What the fitted samples are worth.
    """

    baseline: Baseline
    names: tuple[str, ...]
    value: Float
    covariance: Float
    cycles: int
    correlation: float
    condition_number: float
    residual: Float
    fitted: NDArray[np.bool_]
    noise: Autoregression
    tau_int_s: float
    n_eff: float

    def coefficient(self, name: str) -> Coefficient:
        """Return one factor with its 95 % interval (Student's t, one degree of freedom less than cycles)."""
        at = self.names.index(name)
        half = float(stdtrit(self.cycles - 1, 0.5 + CONFIDENCE / 2) * np.sqrt(self.covariance[at, at]))
        value = float(self.value[at])
        return Coefficient(value=value, low=value - half, high=value + half)


def fit_baseline(
    data: JointData, cycles: Index, *, inertia_kg_m2: float | None = None, offset: bool = False
) -> BaselineFit:
    """Fit inertia, Coulomb and viscous friction on some cycles.

    Args:
        data: One joint.
        cycles: Numbers of the cycles to fit on.
        inertia_kg_m2: The inertia if it is declared; None fits it. [kg m^2]
        offset: True fits a constant torque too.

    Raises:
        AnalysisError: If fewer than four of the cycles have samples.
    """
    free_inertia = inertia_kg_m2 is None
    slope = np.gradient(data.q, data.step_s)
    bend = np.diff(data.q, n=2, prepend=data.q[0], append=data.q[-1]) / data.step_s**2
    names, columns = _columns(data.dq, data.dq, data.ddq, free_inertia=free_inertia, offset=offset)
    _, instruments = _columns(data.dq, slope, bend, free_inertia=free_inertia, offset=offset)
    declared = np.zeros(len(data.t)) if inertia_kg_m2 is None else inertia_kg_m2 * data.ddq
    target = data.torque - declared
    run = runs_of(data.used & np.isin(data.cycle, cycles), data.cycle)
    fitted = run >= 0
    there = len(np.unique(data.cycle[fitted]))
    if there < FEWEST_CYCLES:
        raise AnalysisError(
            f"joint {data.joint + 1}: {there} cycles with motion; at least {FEWEST_CYCLES} are needed to fit friction; "
            "record more strokes"
        )
    noise = Autoregression(coefficients=np.zeros(0), sigma=0.0)
    for _ in range(ROUNDS + 1):
        grams, rights, scale, clipping = _normal_equations(columns, instruments, target, run, data.cycle, noise)
        value = _solve(grams.sum(axis=0), rights.sum(axis=0)) / scale
        residual = target - columns @ value
        solved_with, noise = noise, fit_autoregression(residual, run)
    covariance = clipping**2 * _leave_one_out(grams, rights) / np.outer(scale, scale)
    by_name = dict(zip(names, value.tolist(), strict=True))
    return BaselineFit(
        baseline=Baseline(
            inertia_kg_m2=by_name["inertia"] if inertia_kg_m2 is None else inertia_kg_m2,
            coulomb_nm=by_name["coulomb"],
            viscous_nms_per_rad=by_name["viscous"],
            torque=columns @ value + declared,
        ),
        names=names,
        value=value,
        covariance=covariance,
        cycles=len(grams),
        correlation=float(covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])),
        condition_number=_condition(grams.sum(axis=0)),
        residual=residual,
        fitted=fitted,
        noise=solved_with,
        tau_int_s=integral_time(residual, run) * data.step_s,
        n_eff=effective_samples(residual, run),
    )


def _columns(
    direction: Float, dq: Float, ddq: Float, *, free_inertia: bool, offset: bool
) -> tuple[tuple[str, ...], Float]:
    found = {"coulomb": np.sign(direction), "viscous": dq}
    if free_inertia:
        found["inertia"] = ddq
    if offset:
        found["offset"] = np.ones(len(dq))
    return tuple(found), np.column_stack(list(found.values()))


def _normal_equations(
    columns: Float, instruments: Float, target: Float, run: Index, cycle: Index, noise: Autoregression
) -> tuple[Float, Float, Float, float]:
    """Whiten, weigh and sum by cycle: (c, p, p), (c, p), the scale of the columns, (p,), and what clipping costs.

    A clipped residual does not answer to a change of the factors, which weights that are held do not know: standard
    errors grow by the mean weight over the share that is not clipped (P. J. Huber, Robust Statistics, 1981, 7.6).
    """
    p = columns.shape[1]
    white, whole = whiten(np.column_stack([columns, instruments, target]), run, noise)
    rows, y = white[whole, :p], white[whole, -1]
    scale = np.linalg.norm(rows, axis=0).clip(min=np.finfo(float).tiny)
    rows = rows / scale
    weights = huber_weights(rows, y)
    weighted = white[whole, p : 2 * p] / scale * weights[:, None]
    # Runs are in the order of time, so the rows of a cycle follow each other.
    first = np.flatnonzero(np.diff(cycle[whole], prepend=-1))
    grams = np.add.reduceat(weighted[:, :, None] * rows[:, None, :], first)
    clipping = float(weights.mean() / np.mean(weights >= 1.0))
    return grams, np.add.reduceat(weighted * y[:, None], first), scale, clipping


def _solve(normal: Float, right: Float) -> Float:
    return np.asarray(np.linalg.pinv(normal, rcond=1e-12) @ right, np.float64)


def _leave_one_out(grams: Float, rights: Float) -> Float:
    normal, right = grams.sum(axis=0), rights.sum(axis=0)
    without = np.stack([_solve(normal - gram, right - side) for gram, side in zip(grams, rights, strict=True)])
    spread = without - without.mean(axis=0)
    return np.asarray((len(grams) - 1) / len(grams) * spread.T @ spread, np.float64)


def _condition(normal: Float) -> float:
    values = np.linalg.svd(normal, compute_uv=False)
    return float(np.sqrt(values[0] / values[-1])) if values[-1] > 0 else float("inf")


def differences_from_energy(fit: BaselineFit, energy: JointFriction) -> tuple[str, ...]:
    """Name what it may mean that the energy estimate and the torque fit differ: their intervals do not meet.

    Args:
        fit: The fit in the torque domain.
        energy: The estimate from energy cycles of the same joint.

    Returns:
        One sentence for each coefficient that differs.
    """
    found = []
    coulomb, viscous = fit.coefficient("coulomb"), fit.coefficient("viscous")
    if _apart(energy.viscous, viscous):
        meaning = (
            "a delay between velocity and torque, or a viscous friction that is not linear"
            if energy.viscous.value > viscous.value
            else "a friction that is larger at low speed, or energy that goes to other joints"
        )
        found.append(
            f"viscous friction {energy.viscous.value:.3g} N m s/rad from energy, {viscous.value:.3g} from torque: "
            + meaning
        )
    if _apart(energy.coulomb, coulomb):
        found.append(
            f"Coulomb friction {energy.coulomb.value:.3g} N m from energy, {coulomb.value:.3g} from torque: "
            "an offset of the torque, an error of gravity, or energy that goes to other joints"
        )
    return tuple(found)


def _apart(one: Coefficient, other: Coefficient) -> bool:
    return one.low > other.high or one.high < other.low
