"""A recorded motion with all that a term may lean on, and typical numbers of every term."""

import numpy as np

from friction_audit.dynamics.motion import Motion, Others
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.effects.parameter import Parameter

TYPICAL = {"presliding": (0.3, 0.005, 1.0, 0.005)}
"""Numbers of terms whose bounds are far apart: bristles with the damping of the middle would be a damper."""


def make_recording(seconds: float = 20.0, rate_hz: float = 400.0) -> Motion:
    """Strokes of changing width and speed, three joints, a load and a temperature that change; torque of B = 0.3."""
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    q = 0.7 * np.sin(1.3 * t) + 0.2 * np.sin(3.1 * t + 0.4)
    dq = np.gradient(q, t)
    ddq = np.gradient(dq, t)
    still = np.zeros(len(t))
    others = Others(
        joint=1,
        dq=np.column_stack([np.cos(0.9 * t), dq, np.sin(1.7 * t)]),
        ddq=np.column_stack([-0.9 * np.sin(0.9 * t), ddq, 1.7 * np.cos(1.7 * t)]),
        sensed=np.column_stack([np.sin(0.4 * t), still, np.cos(0.6 * t)]),
    )
    return Motion(
        t=t,
        q=q,
        dq=dq,
        ddq=ddq,
        load=3.0 + 2.0 * np.sin(0.3 * t),
        temperature=25.0 + 0.2 * t,
        others=others,
        rest=0.3 * ddq + 0.3 * np.sign(dq) + 0.07 * dq,
    )


def typical(parameter: Parameter) -> float:
    """A number well within the bounds: the geometric middle of positive ones, else a little above the lowest."""
    low, high = parameter.lower, parameter.upper
    if low > 0.0 and np.isfinite(high):
        return float(np.sqrt(low * high))
    if np.isfinite(low) and np.isfinite(high):
        return low + 0.6 * (high - low)
    return low + 0.3 if np.isfinite(low) else 0.3


def typical_term(term: Effect) -> FittedTerm:
    """A term with typical numbers."""
    values = TYPICAL.get(term.name, tuple(typical(parameter) for parameter in term.parameters))
    return FittedTerm(term.name, values)


def joint_with(*terms: FittedTerm, inertia_kg_m2: float = 0.3) -> JointModel:
    """A joint with Coulomb and viscous friction and other terms."""
    simple = (FittedTerm("coulomb", (0.3,)), FittedTerm("viscous", (0.07,)))
    return JointModel(inertia_kg_m2=inertia_kg_m2, terms=(*simple, *terms))
