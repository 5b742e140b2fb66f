"""The joint as a log shows it, for counterfactuals in which it moves otherwise than recorded."""

from dataclasses import dataclass
from math import isfinite

from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.model import JointModel, simple_model

LEAST_INERTIA_KG_M2 = 1e-3
"""No motor with its gear has less; what seems to have was recorded without its inertia. [kg m^2]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class FittedJoint:
    """Inertia and friction with their 95 % intervals.

    Attributes:
        inertia: Behind the torque sensor. [kg m^2]
        coulomb: [N m]
        viscous: [N m s/rad]
    """

    inertia: Coefficient
    coulomb: Coefficient
    viscous: Coefficient

    @property
    def model(self) -> JointModel:
        """The joint as it can be simulated."""
        return simple_model(
            inertia_kg_m2=self.inertia.value,
            coulomb_nm=max(0.0, self.coulomb.value),
            viscous_nms_per_rad=max(0.0, self.viscous.value),
        )


def fit_joint(friction: JointFriction) -> FittedJoint | str:
    """Return the joint that the torque regression of the log found, or why it cannot be simulated."""
    if friction.reason:
        return friction.reason
    found = friction.regression
    if found is None:
        return "too few moving samples or strokes to fit inertia and friction; record more strokes back and forth"
    joint = FittedJoint(inertia=found.inertia, coulomb=found.coulomb, viscous=found.viscous)
    if not (found.inertia.low > 0.0 and found.inertia.value > LEAST_INERTIA_KG_M2):
        return (
            f"its inertia is not determined ({_text(found.inertia)} kg m^2), and without it nobody knows how it would "
            "have moved; record brisker strokes with quick reversals, or use --assume same-motion"
        )
    pushing = [name for name, one in (("Coulomb", joint.coulomb), ("viscous", joint.viscous)) if not one.high > 0.0]
    if pushing:
        return f"its fitted {' and '.join(pushing)} friction is negative; a joint that pushes cannot be simulated"
    return joint


def _text(found: Coefficient) -> str:
    return f"{found.value:.3g}, 95 % {found.low:.3g} to {found.high:.3g}" if isfinite(found.value) else "no value"
