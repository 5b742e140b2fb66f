"""What the diagnosis of a joint says beyond what every diagnosis said before."""

from dataclasses import dataclass

from friction_audit.diagnosis.engine.residual_checks import ResidualCheck
from friction_audit.diagnosis.result import Effect, JointDiscrepancy


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class NamedEffect(Effect):
    """An effect with its size and stability.

    Attributes:
        size_nm: Rms of its torque free of the nominal model. [N m]
        friction_share: Of the rms of the joint's friction torque.
        residual_share: Of the residual's power, with the nominal model alone, that it takes.
        grade: ``major``, ``minor`` or ``negligible``.
        folds: Selections, each without one fold of the cycles.
        chosen_in: Those that chose it, or what is the same thing there.
        not_identifiable: Names of its parameters that this log does not hold.
    """

    size_nm: float
    friction_share: float
    residual_share: float
    grade: str
    folds: int
    chosen_in: int
    not_identifiable: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointDiagnosis(JointDiscrepancy):
    """A joint with what is negligible and what has no name.

    Attributes:
        negligible: Effects that stand and are too small to count.
        checks: Structures in what is left.
        remainder_share: Share of the residual's power without a name, 0..1.
        share_explained: Share of the gap that the effects close, gravity left out of both.
    """

    negligible: tuple[NamedEffect, ...] = ()
    checks: tuple[ResidualCheck, ...] = ()
    remainder_share: float = 0.0
    share_explained: float = float("nan")
