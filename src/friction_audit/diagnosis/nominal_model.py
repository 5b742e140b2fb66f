"""The nominal model on the samples of a joint: B ddq + mu_c sgn(dq) + mu_v dq, and the terms of a model file."""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.rows import Rows
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.effects.transmission import MOTION_BELOW_HZ, motion_below
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

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
    fine = {"coulomb_nm": data.way, "viscous_nms_per_rad": data.dq}
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
    simple = (data.way, data.dq, data.ddq)
    left = []
    for motion in motions:
        columns = rows.of(np.column_stack([*simple, *_columns(term, motion).values()]))
        left.append(np.linalg.norm(rows.y - columns @ least_squares(columns, rows.y)))
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
