"""What a target of an export is: one record per file format."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from friction_audit.errors import UsageError
from friction_audit.export.friction_law import FittedFriction, FrictionLaw
from friction_audit.export.xml_text import Tag, XmlText

DIGITS = 9  # of a number in a file, more than any log determines


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class ExportedJoint:
    """One joint as it is written."""

    name: str  # its name in the file
    law: FrictionLaw  # its friction law
    fitted: FittedFriction  # the law as the target holds it

    @property
    def static_nm(self) -> float:
        """Friction at the onset of motion, which a simulator wants no smaller than that in motion. [N m]"""
        return max(self.law.static_nm, self.fitted.coulomb_nm)


@dataclass(frozen=True, kw_only=True, slots=True)
class Target:
    """A file format of a simulator or a controller."""

    name: str  # unique name
    suffixes: tuple[str, ...]  # file name endings with the dot, the usual one first
    summary: str  # one line for help and documentation
    # returns the content of the file; the user's file is None where a new one is made
    write: Callable[[Sequence[ExportedJoint], XmlText | None], bytes]
    highest_power: int | None = 1  # of the speed, that its damping has; None where it holds the law itself
    armature: bool = False  # whether it has a place for the inertia
    # returns the joints of the user's file, in its order, or None where a format takes no such file
    joints_of: Callable[[XmlText], list[Tag]] | None = None


def number(value: float) -> str:
    """Return a number as text."""
    return f"{value:.{DIGITS}g}"


def match_names(laws: Sequence[FrictionLaw], count: int, found: Sequence[str], where: str) -> tuple[list[str], bool]:
    """Return the name of each joint in the user's file, and whether the order of the joints gave it.

    ``count`` is the number of joints of the source; ``found`` are those that turn, in the order of the file.
    """
    own = [law.name for law in laws]
    if all(name in found for name in own):
        return own, False
    # A log numbers its joints where it does not name them: the k-th joint is the k-th of a serial arm.
    if not any(name in found for name in own) and count == len(found):
        return [found[law.joint - 1] for law in laws], True
    absent = ", ".join(name for name in own if name not in found)
    raise UsageError(
        f"{where}: no joint {absent}; its {len(found)} joints that turn are {', '.join(found) or 'none'}, "
        f"the source has {count}; rename the joints of the source, or export those that the file has (--joints)"
    )
