"""JointModel: what is known of a joint, as inertia and a tuple of named terms."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from math import isfinite

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect
from friction_audit.effects.registry import term_of
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

REST = ("coulomb", "viscous")  # terms of ``Motion.rest`` besides the inertia


@dataclass(frozen=True, slots=True)
class FittedTerm:
    """A term with its numbers.

    Attributes:
        name: Name of the term.
        values: Values of the term's ``parameters``, in order.

    Raises:
        AnalysisError: If there is no such term, or values are missing, superfluous or beyond their bounds.
    """

    name: str
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        parameters = self.effect.parameters
        if len(self.values) != len(parameters):
            names = ", ".join(parameter.name for parameter in parameters)
            raise AnalysisError(f"term {self.name}: {len(self.values)} values; expected {len(parameters)}: {names}")
        for parameter, value in zip(parameters, self.values, strict=True):
            if not parameter.allows(value):
                bounds = f"a number from {parameter.lower:g} to {parameter.upper:g}"
                raise AnalysisError(f"term {self.name}: {parameter.name} = {value:g}; expected {bounds}")

    @property
    def effect(self) -> Effect:
        """Its effect: names, bounds and formula."""
        return term_of(self.name)

    def torque(self, motion: Motion) -> Float:
        """Return the torque. [N m], shape (n,)."""
        return self.effect.torque(motion, self.values)


@dataclass(frozen=True, kw_only=True, slots=True)
class Provenance:
    """Where a model comes from.

    Attributes:
        method: How it was found, e.g. ``energy``; empty if given by hand.
        log: Path of the log, as given.
        sha256: Digest of the log.
        cycles: Number of cycles it rests on.
    """

    method: str = ""
    log: str = ""
    sha256: str = ""
    cycles: int = 0


@dataclass(frozen=True, kw_only=True, slots=True)
class JointModel:
    """Model of one joint: F_m + u = B ddq + the sum of its terms.

    Attributes:
        inertia_kg_m2: Inertia B behind the torque sensor; of a torque from which a rigid-body model has taken the
            inertia out already, what is left to be paid: about zero, and below it where the model took too much.
        terms: The other terms, each at most once.
        provenance: Where it comes from.
        held: Names of the terms whose numbers are known from elsewhere, so that a diagnosis does not fit them again.

    Raises:
        AnalysisError: If the inertia is no number, a term stands twice, or one is held that is not there.
    """

    inertia_kg_m2: float
    terms: tuple[FittedTerm, ...] = ()
    provenance: Provenance = field(default_factory=Provenance)
    held: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isfinite(self.inertia_kg_m2):
            raise AnalysisError(f"inertia_kg_m2 = {self.inertia_kg_m2:g}; expected a number")
        names = [term.name for term in self.terms]
        if "inertia" in names:
            raise AnalysisError("term inertia stands among the terms; expected it as inertia_kg_m2")
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise AnalysisError(f"term {', '.join(twice)} stands twice; expected each term once")
        absent = [name for name in self.held if name not in names]
        if absent:
            raise AnalysisError(f"held: {', '.join(absent)}; expected some of the joint's terms: {', '.join(names)}")

    def values(self, name: str) -> tuple[float, ...] | None:
        """Return the values of a term, or None where the model does not have it."""
        return next((term.values for term in self.terms if term.name == name), None)

    def torque(self, motion: Motion) -> Float:
        """Return the torque F_m + u that the motion takes. [N m], shape (n,)."""
        return self.inertia_kg_m2 * motion.ddq + _sum(self.terms, self._known(motion))

    def friction(self, motion: Motion) -> Float:
        """Return the torque that the terms of friction take. [N m], shape (n,)."""
        return _sum((term for term in self.terms if term.effect.friction), self._known(motion))

    def rest(self, motion: Motion) -> Float:
        """Return the torque that inertia, Coulomb and viscous friction take. [N m], shape (n,)."""
        return self.inertia_kg_m2 * motion.ddq + _sum((term for term in self.terms if term.name in REST), motion)

    def _known(self, motion: Motion) -> Motion:
        """Tell the motion what the simple terms take, unless somebody has."""
        return replace(motion, rest=self.rest(motion)) if motion.rest is None else motion


@dataclass(frozen=True, kw_only=True, slots=True)
class ArmModel:
    """Models of the joints of an arm.

    Attributes:
        names: Names of the joints.
        joints: One model per joint; None where the log did not allow one.

    Raises:
        AnalysisError: If there is no joint, or not one name per joint.
    """

    names: tuple[str, ...]
    joints: tuple[JointModel | None, ...]

    def __post_init__(self) -> None:
        if not self.joints or len(self.names) != len(self.joints):
            raise AnalysisError(
                f"{len(self.names)} names for {len(self.joints)} joints; expected one each, and a joint at least"
            )


def simple_model(
    *, inertia_kg_m2: float, coulomb_nm: float, viscous_nms_per_rad: float, offset_nm: float = 0.0
) -> JointModel:
    """Return a model of inertia, Coulomb and viscous friction, and a constant torque where there is one."""
    terms = (FittedTerm("coulomb", (coulomb_nm,)), FittedTerm("viscous", (viscous_nms_per_rad,)))
    offset = (FittedTerm("offset", (offset_nm,)),) if offset_nm != 0.0 else ()
    return JointModel(inertia_kg_m2=inertia_kg_m2, terms=terms + offset)


def _sum(terms: Iterable[FittedTerm], motion: Motion) -> Float:
    """Return the sum of the terms' torques."""
    total = np.zeros(len(motion.t))
    for term in terms:
        total += term.torque(motion)
    return total
