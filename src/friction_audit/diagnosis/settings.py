"""Settings of a diagnosis."""

from dataclasses import dataclass
from math import inf

from friction_audit.effects.joint_model import ArmModel
from friction_audit.effects.registry import NAMES
from friction_audit.errors import UsageError

HIGHEST_ALPHA = 0.5


@dataclass(frozen=True, kw_only=True, slots=True)
class DiagnosisSettings:
    """What is asked of a diagnosis.

    Attributes:
        candidates: Names of the effects that may be named; None for the whole catalogue.
        alpha: Probability of saying that something is missing where nothing is, per joint.
        min_effect_nm: Effects whose rms torque is below it are negligible. [N m]
        seed: Seed of the bootstrap of the screening test; no verdict depends on it.
        model: Nominal model of each joint of the log; None for inertia, Coulomb and viscous friction, fitted.

    Raises:
        UsageError: If there is no such effect, or alpha is no probability that makes sense.
    """

    candidates: tuple[str, ...] | None = None
    alpha: float = 0.05
    min_effect_nm: float = 0.0
    seed: int = 0
    model: ArmModel | None = None

    def __post_init__(self) -> None:
        """Check names and numbers."""
        strangers = [name for name in self.candidates or () if name not in NAMES]
        if strangers:
            raise UsageError(f"candidates: {', '.join(strangers)}: expected some of {', '.join(NAMES)}")
        if not 0.0 < self.alpha < HIGHEST_ALPHA:
            raise UsageError(f"alpha: {self.alpha:g}; expected a probability above 0 and below {HIGHEST_ALPHA:g}")
        if not 0.0 <= self.min_effect_nm < inf:
            raise UsageError(f"min_effect_nm: {self.min_effect_nm:g}; expected a torque of zero or more")
