"""DriftSettings: how drift is looked for."""

from dataclasses import dataclass

from friction_audit.errors import UsageError
from friction_audit.joint_numbers import parse_joint_numbers

FEWEST_SESSIONS = 4
"""Two before and two after a step; fewer cannot tell a change from one odd session."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DriftSettings:
    """How drift is looked for."""

    # sessions of the reference: so many first ones, or their indices in the order of the starts, from 0
    baseline: int | tuple[int, ...] = 5
    # probability that an arm on which nothing changes is said to drift, over all joints and coefficients
    alpha: float = 0.05
    power: float = 0.9  # probability with which the smallest drift is found
    permutations: int = 1999  # orders of the sessions that the tests are judged by
    seed: int = 0  # of the permutations: the same sessions give the same answer

    def __post_init__(self) -> None:
        """Check the ranges."""
        if (isinstance(self.baseline, int) and self.baseline < 1) or self.baseline == ():
            raise UsageError(f"baseline {self.baseline}: expected at least one session")
        if not 0.0 < self.alpha < 1.0 or not 0.0 < self.power < 1.0:
            raise UsageError(f"alpha {self.alpha:g}, power {self.power:g}: expected numbers between 0 and 1")
        if (self.permutations + 1) * self.alpha < 1.0:
            raise UsageError(
                f"permutations {self.permutations}: too few for alpha {self.alpha:g}; expected at least "
                f"{int(1.0 / self.alpha)}"
            )


def parse_baseline(text: str) -> int | tuple[int, ...]:
    """Return the reference of ``"5"`` (the first five sessions) or ``"3-8,10"`` (those, counted from 1)."""
    word = text.strip()
    if word.isdecimal() and int(word) > 0:
        return int(word)
    try:
        return tuple(number - 1 for number in parse_joint_numbers(word, "--baseline"))
    except UsageError as error:
        raise UsageError(
            f"--baseline {text}: expected how many first sessions are the reference, e.g. 5, or which ones, e.g. 3-8,10"
        ) from error
