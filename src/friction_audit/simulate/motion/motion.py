"""What a motion is: a way of moving one joint, with settings of its own."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from friction_audit.simulate.motion.intention import Intention


@dataclass(frozen=True, kw_only=True, slots=True)
class Motion:
    """One way of moving.

    Attributes:
        name: As in documentation and on the command line.
        summary: One line.
        settings: Frozen dataclass of its settings; made without arguments, it is the usual motion.
        intend: ``intend(settings, ticks, dt, rng)``, pure; ``ticks`` intervals of ``dt`` seconds.
    """

    name: str
    summary: str
    settings: type[Any]
    intend: Callable[..., Intention]
