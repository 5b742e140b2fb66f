"""How friction is estimated from energy cycles."""

from dataclasses import dataclass

from friction_audit.errors import UsageError

ESTIMATORS = ("weighted", "paper")
MODELS = ("combined", "coulomb", "viscous")
PAPER_WINDOW = 2
DEFAULT_WINDOW = 20


@dataclass(frozen=True, kw_only=True, slots=True)
class FrictionSettings:
    """Settings of the estimate.

    Attributes:
        estimator: ``"weighted"`` (the default: rows weighted by their noise, extra columns) or ``"paper"``.
        model: ``"combined"`` (20), ``"coulomb"`` (14) or ``"viscous"`` (8).
        window: Number k of cycles used for each point of the history; None for the estimator's own default.
        compare: Also regress the torque itself.

    Raises:
        UsageError: If a name is unknown or the window too short for the model.
    """

    estimator: str = "weighted"
    model: str = "combined"
    window: int | None = None
    compare: bool = True

    def __post_init__(self) -> None:
        """Check names and the window."""
        if self.estimator not in ESTIMATORS:
            raise UsageError(f"--estimator {self.estimator}: expected one of {', '.join(ESTIMATORS)}")
        if self.model not in MODELS:
            raise UsageError(f"--model {self.model}: expected one of {', '.join(MODELS)}")
        smallest = 2 if self.model == "combined" else 1
        if self.window is not None and self.window < smallest:
            raise UsageError(
                f"--window {self.window}: the {self.model} model needs at least {smallest} cycles; give more"
            )

    @property
    def cycles_per_point(self) -> int:
        """The window k in force."""
        if self.window is not None:
            return self.window
        if self.estimator == "weighted":
            return DEFAULT_WINDOW
        return PAPER_WINDOW if self.model == "combined" else 1
