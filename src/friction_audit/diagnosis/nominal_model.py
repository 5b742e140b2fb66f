"""The declared model on the rows of a joint: B ddq + mu_c sgn(dq) + mu_v dq, and whatever terms a model file adds.

Fitted by least squares; rows of one cycle share their errors, so intervals come from leaving out one cycle at a time.

Reference: A. C. Cameron, D. L. Miller, A practitioner's guide to cluster-robust inference, Journal of Human
Resources 50 (2015) 317.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.rows import Rows
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_data import JointData, Nominal, mean_sign
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.effects.transmission import MOTION_BELOW_HZ, motion_below
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

CONFIDENCE = 0.95
INERTIA = "inertia_kg_m2"
FRICTION = {"coulomb": "coulomb_nm", "viscous": "viscous_nms_per_rad"}
"""Terms that candidates lean on, with the name of their one number."""
RINGING = ("spring", "gap")
"""What rings on noise of the position too."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class NominalModel:
    """The declared model, b columns.

    Attributes:
        names: Names of the factors, unit behind: Coulomb and viscous friction, inertia unless it is stated, then the
            linear parameters of other terms of a model file; without those of terms that the file holds.
        fine: Their columns on the fine grid, shape (n, b).
        columns: The same on the rows, shape (m, b).
        stated: Torque of numbers that are stated and not fitted, on the fine grid, shape (n,). [N m]
        y: Torque of the rows less what is stated, shape (m,). [N m]
        model: The model file's model of the joint, None without one.
    """

    names: tuple[str, ...]
    fine: Float
    columns: Float
    stated: Float
    y: Float
    model: JointModel | None

    def baseline(self, factors: Float) -> Nominal:
        """What candidates lean on, for the factors of a fit, shape (b,)."""
        stated = {} if self.model is None else _stated(self.model)
        value = stated | dict(zip(self.names, factors.tolist(), strict=True))
        return Nominal(
            inertia_kg_m2=value[INERTIA],
            coulomb_nm=value["coulomb_nm"],
            viscous_nms_per_rad=value["viscous_nms_per_rad"],
            torque=self.fine @ factors + self.stated,
            declared=frozenset(stated),
        )


def nominal_model(data: JointData, rows: Rows, model: JointModel | None) -> NominalModel:
    """Build the columns of the declared model: friction is fitted, an inertia from a model file is taken as stated.

    Terms that the file holds are stated as well.

    Raises:
        AnalysisError: If everything is stated, so that nothing is left to fit.
    """
    fine = {"coulomb_nm": mean_sign(data.t, data.dq, data.ddq), "viscous_nms_per_rad": data.dq}
    stated = np.zeros(len(data.t))
    if model is None:
        fine[INERTIA] = data.ddq
    else:
        rest = model.rest(data.motion())
        stated = model.inertia_kg_m2 * data.ddq
        for term in model.terms:
            motion = _motion_of(term, model, data, rows) if term.effect.forward in RINGING else data.motion(rest)
            columns = _columns(term, motion)
            if term.name in model.held:
                stated = stated + term.torque(motion)
                fine = {name: column for name, column in fine.items() if name not in columns}
            else:
                fine |= columns
    if not fine:
        raise AnalysisError("model: Coulomb and viscous friction are both held; leave one out of held to be fitted")
    stacked = np.column_stack(list(fine.values()))
    return NominalModel(
        names=tuple(fine),
        fine=stacked,
        columns=rows.of(stacked),
        stated=stated,
        y=rows.y - rows.of(stated),
        model=model,
    )


def _stated(model: JointModel) -> dict[str, float]:
    """What of inertia, Coulomb and viscous friction is stated, by name."""
    held = {name: values[0] for name in model.held if (values := model.values(name)) is not None}
    return {INERTIA: model.inertia_kg_m2} | {FRICTION[name]: held[name] for name in FRICTION if name in held}


def _motion_of(term: FittedTerm, model: JointModel, data: JointData, rows: Rows) -> Motion:
    """The motion as measured, or without what is hardly more than noise: that along which a term explains more.

    What rings amplifies the noise of the position, and its name was found along either motion.
    """
    every = [data.motion(), motion_below(data, MOTION_BELOW_HZ)]
    motions = [replace(motion, rest=model.rest(motion)) for motion in every]
    simple = np.stack([mean_sign(data.t, data.dq, data.ddq), data.dq, data.ddq], axis=1)
    beside = Beside(rows.of(simple), rows.y)
    left = [beside.fit(rows.of(np.stack(list(_columns(term, motion).values()), axis=1)))[1] for motion in motions]
    return motions[int(np.argmin(left))]


def _columns(term: FittedTerm, motion: Motion) -> dict[str, Float]:
    """The linear columns of a term by name of their factor, its shape as stated; none for what the file lacks."""
    shape = term.values[len(term.effect.coefficients) :]
    regressor = term.effect.columns(motion, shape)
    return {
        parameter.name: regressor[:, k]
        for k, (parameter, value) in enumerate(zip(term.effect.coefficients, term.values, strict=False))
        if value != 0.0 or not parameter.optional
    }


def least_squares(columns: Float, y: Float) -> Float:
    """Factors, shape (p,); of columns that are copies of each other, the smallest; of zeros none, not even rounding."""
    size = np.sqrt(np.mean(columns**2, axis=0))
    scale = np.where(size > 0, size, 1.0)
    return np.asarray(np.where(size > 0, np.linalg.lstsq(columns / scale, y, rcond=1e-10)[0] / scale, 0.0))


def coefficients(columns: Float, y: Float, cycle: NDArray[np.int64]) -> tuple[Coefficient, ...]:
    """Factors with 95 % intervals from leaving out one cycle at a time (Student's t).

    Args:
        columns: Shape (m, p).
        y: Response, shape (m,).
        cycle: Number of the cycle of each row, in the order of time, shape (m,).
    """
    from scipy.special import stdtrit

    scale = np.sqrt(np.mean(columns**2, axis=0))
    scale = np.where(scale > 0, scale, 1.0)
    scaled = columns / scale
    bounds = [0, *(np.flatnonzero(np.diff(cycle)) + 1), len(cycle)]
    grams = np.stack([scaled[i:j].T @ scaled[i:j] for i, j in pairwise(bounds)])
    rights = np.stack([scaled[i:j].T @ y[i:j] for i, j in pairwise(bounds)])
    gram, right = grams.sum(axis=0), rights.sum(axis=0)
    value = np.linalg.pinv(gram, rcond=1e-12) @ right
    without = (np.linalg.pinv(gram - grams, rcond=1e-12) @ (right - rights)[:, :, None])[:, :, 0]
    spread = (without - without.mean(axis=0)) / scale
    m = len(grams)
    half = stdtrit(max(m - 1, 1), 0.5 + CONFIDENCE / 2) * np.sqrt((m - 1) / m * np.sum(spread**2, axis=0))
    return tuple(
        Coefficient(value=float(v), low=float(v - h), high=float(v + h))
        for v, h in zip(value / scale, half, strict=True)
    )
