"""The nominal model on the samples of a joint: B ddq + mu_c sgn(dq) + mu_v dq, and the terms of a model file."""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.samples import Samples
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.effects.transmission import MOTION_BELOW_HZ, motion_below
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

INERTIA = "inertia_kg_m2"
FRICTION = {"coulomb": "coulomb_nm", "viscous": "viscous_nms_per_rad"}  # terms with their one coefficient
RINGING = ("spring", "gap")  # forward models of terms that amplify noise of the position


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class NominalModel:
    """The nominal model, b columns."""

    # names of the coefficients with their unit: Coulomb and viscous friction, inertia unless a model file states it,
    # then the coefficients of other terms of the file; without those of terms that the file holds
    names: tuple[str, ...]
    fine: Float  # their columns on the fine grid, shape (n, b)
    columns: Float  # the same on the samples, shape (m, b)
    stated: Float  # torque of the numbers that are not fitted, on the fine grid, shape (n,) [N m]
    y: Float  # torque of the samples without it, shape (m,) [N m]
    model: JointModel | None  # the model file's model of the joint, None without one

    def baseline(self, coefficients: Float) -> Nominal:
        """The fitted model, from coefficients, shape (b,), as columns of effects need it."""
        stated = {} if self.model is None else _stated(self.model)
        value = stated | dict(zip(self.names, coefficients.tolist(), strict=True))
        return Nominal(
            inertia_kg_m2=value[INERTIA],
            coulomb_nm=value["coulomb_nm"],
            viscous_nms_per_rad=value["viscous_nms_per_rad"],
            torque=self.fine @ coefficients + self.stated,
            declared=frozenset(stated),
        )


def nominal_model(data: JointData, samples: Samples, model: JointModel | None) -> NominalModel:
    """Build the columns of the nominal model; the inertia of a model file and the terms that it holds are not fitted.

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
            motion = _motion_of(term, model, data, samples) if term.effect.forward in RINGING else data.motion(rest)
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
        columns=samples.of(stacked),
        stated=stated,
        y=samples.y - samples.of(stated),
        model=model,
    )


def _stated(model: JointModel) -> dict[str, float]:
    """Inertia, Coulomb and viscous friction of a model file that are not fitted, by name."""
    held = {name: values[0] for name in model.held if (values := model.values(name)) is not None}
    return {INERTIA: model.inertia_kg_m2} | {FRICTION[name]: held[name] for name in FRICTION if name in held}


def _motion_of(term: FittedTerm, model: JointModel, data: JointData, samples: Samples) -> Motion:
    """The motion as measured or low-passed: the one with which the term explains more."""
    every = [data.motion(), motion_below(data, MOTION_BELOW_HZ)]
    motions = [replace(motion, rest=model.rest(motion)) for motion in every]
    simple = (data.way, data.dq, data.ddq)
    left = []
    for motion in motions:
        columns = samples.of(np.column_stack([*simple, *_columns(term, motion).values()]))
        left.append(np.linalg.norm(samples.y - columns @ least_squares(columns, samples.y)))
    return motions[int(np.argmin(left))]


def _columns(term: FittedTerm, motion: Motion) -> dict[str, Float]:
    """Columns of a term by name of their coefficient; none for what the file lacks."""
    shape = term.values[len(term.effect.coefficients) :]
    regressor = term.effect.columns(motion, shape)
    return {
        parameter.name: regressor[:, k]
        for k, (parameter, value) in enumerate(zip(term.effect.coefficients, term.values, strict=False))
        if value != 0.0 or not parameter.optional
    }


def least_squares(columns: Float, y: Float) -> Float:
    """Coefficients of least norm, shape (p,); exactly 0 for a column of zeros."""
    size = np.sqrt(np.mean(columns**2, axis=0))
    scale = np.where(size > 0, size, 1.0)
    return np.asarray(np.where(size > 0, np.linalg.lstsq(columns / scale, y, rcond=1e-10)[0] / scale, 0.0))
