"""How friction is estimated from energy cycles."""

from dataclasses import dataclass

from friction_audit.errors import UsageError

ESTIMATORS = ("weighted", "paper")
MODELS = ("combined", "coulomb", "viscous")
PAPER_WINDOW = 2
LONGEST_WINDOW = 20  # cycles from which on a longer window narrows the interval little
PARTS = 3  # windows next to each other that a log has at least: two show that something changed, three how
FEWEST_CYCLES = 4  # with fewer a jackknife has too few degrees of freedom


@dataclass(frozen=True, kw_only=True, slots=True)
class FrictionSettings:
    """Settings of the estimate."""

    # ``"weighted"`` (the default: rows weighted by their noise, extra columns) or ``"paper"``
    estimator: str = "weighted"
    model: str = "combined"  # ``"combined"`` (20), ``"coulomb"`` (14) or ``"viscous"`` (8)
    # number k of cycles used for each point of the history; None for one that a log has at least three of
    window: int | None = None
    compare: bool = True  # also regress the torque itself

    def __post_init__(self) -> None:
        if self.estimator not in ESTIMATORS:
            raise UsageError(f"--estimator {self.estimator}: expected one of {', '.join(ESTIMATORS)}")
        if self.model not in MODELS:
            raise UsageError(f"--model {self.model}: expected one of {', '.join(MODELS)}")
        if self.window is not None and self.window < self.fewest_cycles:
            raise UsageError(
                f"--window {self.window}: the {self.estimator} estimator with the {self.model} model needs at least "
                f"{self.fewest_cycles} cycles; give more"
            )

    @property
    def fewest_cycles(self) -> int:
        """The smallest window: as many cycles as unknowns, and enough to leave one out where there are intervals."""
        if self.estimator == "weighted":
            return FEWEST_CYCLES
        return PAPER_WINDOW if self.model == "combined" else 1

    @property
    def cycles_per_point(self) -> int:
        """The window k of a long log."""
        if self.window is not None:
            return self.window
        return LONGEST_WINDOW if self.estimator == "weighted" else self.fewest_cycles
