"""How strong an effect must be made so that its torque, free of the declared model, is so many times the noise."""

from collections.abc import Sequence

import numpy as np

from benchmarks.hidden_effects.draw import Case, model_of, settings_of
from friction_audit.diagnosis.prepare import prepare
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.samples import NominalModel, least_squares, make_samples
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import ArmModel
from friction_audit.errors import FrictionAuditError
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.scenarios import simulate

ROUNDS = 8
CLOSE = 0.1
LARGEST_SCALE = 30.0


def left_over(log: JointLog, joint: int, model: ArmModel | None = None, corner_hz: float | None = None) -> float:
    """What the declared model leaves of one joint's torque, root mean square. [N m]

    Args:
        log: The log.
        joint: Column of the joint.
        model: The declared model, None for the simple one.
        corner_hz: Of the rows' filter; None for what the log's own noise allows. [Hz]
    """
    data, stated = prepared(log)[joint], None if model is None else model.joints[joint]
    rows = make_samples(
        data, RegressionProblem.build(data, stated).samples.corner_hz if corner_hz is None else corner_hz
    )
    declared = NominalModel.build(data, rows, stated)
    left = declared.y - declared.columns @ least_squares(declared.columns.T, declared.y)
    return float(np.sqrt(np.mean(left**2)))


def prepared(log: JointLog) -> tuple[JointData, ...]:
    """The joints of a log, as the detector prepares them."""
    found = estimate_log(log, AuditSettings())
    return prepare(found.interaction, found.cycles, log)


def scales_for(case: Case) -> tuple[float, ...] | None:
    """Scale of each effect's strength, each on its own, on ideal sensors; None where it cannot be reached.

    Below the corner that the noise of the log's own sensors allows: what lies above it is not seen.
    """
    nothing, joint, model = (0.0,) * len(case.effects), case.number - 1, model_of(case)
    log = simulate(settings_of(case, nothing), case.seed).log
    corner = RegressionProblem.build(
        prepared(log)[joint], None if model is None else model.joints[joint]
    ).samples.corner_hz
    noise, ideal = left_over(log, joint, model), _left(case, nothing, corner)
    found = [_scale(case, k, noise * case.partial, ideal, corner) for k in range(len(case.effects))]
    scales = [scale for scale in found if scale is not None]
    return tuple(scales) if len(scales) == len(found) else None


def _left(case: Case, scales: Sequence[float], corner_hz: float) -> float:
    """What is left with ideal sensors."""
    log = simulate(settings_of(case, scales, ideal=True), case.seed).log
    return left_over(log, case.number - 1, model_of(case), corner_hz)


def _scale(case: Case, which: int, wanted: float, ideal: float, corner_hz: float) -> float | None:
    """Secant steps in the logarithm, for the rest of a model grows nearly in proportion to what it misses.

    A joint that its motor moves may answer a little more with another motion altogether. Then steps go too far: they
    are halved between the closest scales on either side, and where none in between has the strength it is not reached.
    """
    scale, low, high = 1.0, 0.0, np.inf
    for _ in range(ROUNDS):
        alone: Sequence[float] = [scale if k == which else 0.0 for k in range(len(case.effects))]
        try:
            total = _left(case, alone, corner_hz)
        except FrictionAuditError:
            scale *= 0.5  # so strong that the joint hardly moves, or beyond what the effect allows
            continue
        partial = float(np.sqrt(max(total**2 - ideal**2, 1e-12)))
        if abs(partial / wanted - 1.0) < CLOSE:
            return scale if _is_itself(case, which, scale) else None
        low, high = (scale, high) if partial < wanted else (low, scale)
        step = scale * float(np.clip(wanted / partial, 0.1, 10.0))
        scale = step if low < step < high else float(np.sqrt(low * high))
        if scale > min(LARGEST_SCALE, _largest(case, which)):
            return None
    return None


def _is_itself(case: Case, which: int, scale: float) -> bool:
    """Whether an effect so small is still what its name says: a play far smaller than its flanks give way is a spring.

    The flanks' full travel under Coulomb friction, from one side to the other, is what a play must at least add.
    """
    if case.effects[which] != "backlash":
        return True
    group, joints = case.groups[which], settings_of(case, (0.0,) * len(case.effects)).joints
    give_way = 2.0 * joints[case.number - 1].coulomb_nm * group.contact_compliance_rad_per_nm
    return bool(scale * group.gap_rad >= give_way)


def _largest(case: Case, which: int) -> float:
    """Scale at which the strength is as large as the effect allows: no joint warms up until friction pushes."""
    effect = next(effect for effect in EFFECTS if effect.name == case.effects[which])
    high = next(parameter.upper for parameter in effect.parameters() if parameter.name == effect.strength_name)
    usual = abs(getattr(case.groups[which], effect.strength_name))
    return float(high / usual) if usual > 0.0 else LARGEST_SCALE
