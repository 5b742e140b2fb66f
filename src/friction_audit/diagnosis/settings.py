"""Settings of a diagnosis."""

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from friction_audit.effects.registry import NAMES
from friction_audit.errors import UsageError

if TYPE_CHECKING:  # it loads compiled loops, which a command does while it reads the log
    from friction_audit.effects.joint_model import ArmModel


@dataclass(frozen=True, kw_only=True, slots=True)
class DiagnosisSettings:
    """What is asked of a diagnosis.

    Raises:
        UsageError: If there is no such effect, ``min_effect_nm`` is no torque, or ``at_most_s`` no duration.
    """

    candidates: tuple[str, ...] | None = None  # names of the effects that may be named; None for the whole catalogue
    min_effect_nm: float = 0.0  # effects whose rms torque is below it are negligible [N m]
    seed: int = 0  # of the bootstrap of the screening test; no verdict depends on it
    # Of a longer log, so much is diagnosed, in parts that are spread over it, or over the window of twice that length
    # in which the friction is determined best. [s]
    at_most_s: float = 300.0
    model: "ArmModel | None" = None  # of each joint; None for inertia, Coulomb and viscous friction, fitted

    def __post_init__(self) -> None:
        unknown = [name for name in self.candidates or () if name not in NAMES]
        if unknown:
            raise UsageError(f"candidates: {', '.join(unknown)}: expected some of {', '.join(NAMES)}")
        if not 0.0 <= self.min_effect_nm < inf:
            raise UsageError(f"min_effect_nm: {self.min_effect_nm:g}; expected a torque of zero or more")
        if not self.at_most_s > 0.0:
            raise UsageError(f"at_most_s: {self.at_most_s:g}; expected a duration above zero, in s")
