"""How much a log holds of one effect, or of each of two: what a test would see that knew their torques.

The torque of an effect is what it alone adds on ideal sensors. It is visible where n_eff ln(RSS without it / RSS with
it), given the nominal model and the other torque, is above what the best of all names of the catalogue reaches by
chance in one log of a hundred. Where an effect changes how the joint moves, its torque is that of another motion, and
the number is too small. No choice of the engine enters.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.stats import chi2

from benchmarks.hidden_effects.draw import Case, draw_case, model_of, settings_of
from benchmarks.hidden_effects.run import NOT_REACHED, SIZES, scaled
from benchmarks.hidden_effects.strength import prepared
from benchmarks.resume import Row
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.samples import NominalModel, Samples, least_squares, make_samples
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import JointModel
from friction_audit.effects.registry import effects
from friction_audit.joint_log import Float
from friction_audit.simulation.scenarios import simulate

PRICE = float(chi2.isf(0.01 / len(effects()), 1))  # of an effect whose torque is known but for its factor
SAME_START_S = 0.05  # starts from a standstill in two logs are the same if they are no farther from each other
LONGEST_TIME = 400  # lags of the autocorrelation: 4 s
FIELDS = ("truth", "seed", "effect", "partial", "holds", "testable")


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class SampledJoint:
    """A joint at the rows of a filter, with its nominal model."""

    data: JointData
    rows: Samples
    nominal: NominalModel

    def residual(self, *torques: Float) -> Float:
        """What least squares of the nominal model and some torques leaves, shape (m,). [N m]"""
        columns = np.column_stack([self.nominal.columns, *torques])
        return np.asarray(self.nominal.y - columns @ least_squares(columns.T, self.nominal.y))


def samples_of(data: JointData, model: JointModel | None, corner_hz: float | None = None) -> SampledJoint:
    """Filter a joint; below the corner that its own noise allows unless another is given. [Hz]"""
    corner = RegressionProblem.build(data, model).samples.corner_hz if corner_hz is None else corner_hz
    rows = make_samples(data, corner)
    return SampledJoint(data=data, rows=rows, nominal=NominalModel.build(data, rows, model))


def integral_time(residual: Float, rows: Samples) -> float:
    """Samples that hold as much as one independent one: initial positive sequence, C. J. Geyer, Stat. Sci. 7 (1992)."""
    whole, there = np.zeros((2, rows.place[-1] + 1))
    whole[rows.place], there[rows.place] = residual, 1.0
    power, total = float(np.mean(residual**2)), 0.0
    for lag in range(0, LONGEST_TIME, 2):
        pair = 0.0
        for k in (lag, lag + 1):
            stop = len(whole) - k
            pair += float(whole[:stop] @ whole[k:]) / max(float(there[:stop] @ there[k:]), 1.0) / power
        if not pair > 0.0:
            break
        total += pair
    return max(2.0 * total - 1.0, 1.0)


def held_by(samples: SampledJoint, torques: Sequence[Float], which: int) -> float:
    """n_eff ln(RSS without one torque / RSS with it), given the nominal model and the other torques."""
    whole = samples.residual(*torques)
    without = samples.residual(*torques[:which], *torques[which + 1 :])
    n_eff = len(whole) / integral_time(whole, samples.rows)
    return n_eff * float(np.log(np.sum(without**2) / np.sum(whole**2)))


def torque_alone(case: Case, which: int, samples: SampledJoint) -> Float:
    """What one effect alone adds on ideal sensors, free of the nominal model, at the rows of some samples, (m,)."""
    scales = tuple(1.0 if k == which else 0.0 for k in range(len(case.effects)))
    data = prepared(simulate(settings_of(case, scales, ideal=True), case.seed).log)[case.number - 1]
    ideal = samples_of(data, samples.nominal.model, samples.rows.corner_hz)
    torque = np.zeros(len(samples.rows.t))
    here, there = same_times(samples.rows, ideal.rows)
    torque[here] = ideal.residual()[there]
    return torque


def same_times(rows: Samples, others: Samples) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which rows of two logs are of the same time, or the same start from a standstill: places in both, shape (k,)."""
    here, there = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    step_s = float(np.min(np.diff(rows.t))) if len(rows.t) > 1 else 0.0
    for starts, apart in ((False, step_s / 2.0), (True, SAME_START_S)):
        one, other = (np.flatnonzero(r.breakaway == starts) for r in (rows, others))
        if len(one) and len(other):
            distance, nearest = map(np.asarray, cKDTree(others.t[other, None]).query(rows.t[one, None]))
            here.append(one[distance < apart])
            there.append(other[nearest[distance < apart]])
    return np.concatenate(here), np.concatenate(there)


def limits_of(row: Row) -> list[Row]:
    """What the log of a row holds of each of its effects."""
    seed, names = int(row["seed"]), tuple(row["truth"].split("+"))
    case = scaled(draw_case(seed, names, SIZES[seed % len(SIZES)]), map(float, row["scales"].split("/")))
    model, joint = model_of(case), case.number - 1
    data = prepared(simulate(settings_of(case, (1.0,) * len(names)), seed).log)[joint]
    samples = samples_of(data, None if model is None else model.joints[joint])
    torques = [torque_alone(case, k, samples) for k in range(len(names))]
    baseline = samples.nominal.baseline(least_squares(samples.nominal.columns.T, samples.nominal.y))
    catalogue = {one.name: one for one in effects()}
    return [
        {
            "truth": row["truth"], "seed": str(seed), "effect": name, "partial": str(case.partial),
            "holds": f"{held_by(samples, torques, k):.1f}",
            "testable": str(catalogue[name].not_identifiable(data, baseline) is None),
        }
        for k, name in enumerate(names)
    ]  # fmt: skip


def judged(rows: Iterable[Row]) -> list[Row]:
    """One row per log that hides effects of the catalogue at a strength that was reached."""
    names = {one.name for one in effects()}
    kept = {
        (row["truth"], row["seed"]): row
        for row in rows
        if set(row["truth"].split("+")) <= names and row.get("scales") not in {None, "", NOT_REACHED}
    }
    return list(kept.values())


def visible(limits: Iterable[Row], times: float = 1.0) -> set[tuple[str, str]]:
    """Logs (truth, seed) that can show all of their effects, and hold so many times the price of each."""
    by_log: dict[tuple[str, str], list[bool]] = {}
    for one in limits:
        enough = one["testable"] == "True" and float(one["holds"]) >= times * PRICE
        by_log.setdefault((one["truth"], one["seed"]), []).append(enough)
    return {log for log, enough in by_log.items() if all(enough)}
