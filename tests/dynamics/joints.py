"""Joints and recordings for the tests of the dynamics: invented terms, and a joint under a sampled torque."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from friction_audit.dynamics import forward
from friction_audit.dynamics.motion import Forward, Motion, Others
from friction_audit.dynamics.stick_slip import integrate_segments
from friction_audit.dynamics.torque_tables import Tables, tabulate
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.joint_log import Float

simulate_segments: Any = forward.simulate_segments  # None, for what cannot be simulated, would fail in every test


def invent(
    torque: Callable[[Motion], Float], value: float = 1.0, forward: Forward = "instant", name: str = "invented_nm"
) -> Any:
    """A term of any torque, with one coefficient of a name."""
    effect = SimpleNamespace(forward=forward, parameters=(SimpleNamespace(name=name),))
    return SimpleNamespace(
        name="invented", effect=effect, values=(value,), torque=lambda motion: value * torque(motion)
    )


def joint_with(*terms: Any, inertia_kg_m2: float = 0.3) -> JointModel:
    """A joint with Coulomb and viscous friction and other terms."""
    simple = (FittedTerm("coulomb", (0.3,)), FittedTerm("viscous", (0.07,)))
    return JointModel(inertia_kg_m2=inertia_kg_m2, terms=(*simple, *terms))


def recording_of(t: Float, q: Float, dq: Float) -> Motion:
    return Motion(t=t, q=q, dq=dq, ddq=np.gradient(dq, t))


def make_recording(seconds: float = 20.0, rate_hz: float = 400.0) -> Motion:
    """Strokes of changing width and speed, three joints, a load and a temperature that change; torque of B = 0.3."""
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    q = 0.7 * np.sin(1.3 * t) + 0.2 * np.sin(3.1 * t + 0.4)
    dq = np.gradient(q, t)
    ddq = np.gradient(dq, t)
    others = Others(
        joint=1,
        q=np.column_stack([np.sin(0.9 * t) / 0.9, q, -np.cos(1.7 * t) / 1.7]),
        dq=np.column_stack([np.cos(0.9 * t), dq, np.sin(1.7 * t)]),
        ddq=np.column_stack([-0.9 * np.sin(0.9 * t), ddq, 1.7 * np.cos(1.7 * t)]),
        sensed=np.column_stack([np.sin(0.4 * t), 0.0 * t, np.cos(0.6 * t)]),
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


STEP_S = 1e-4
FAST = np.linspace(-6.0, 6.0, 24_001)
FAR = Motion(t=FAST, q=FAST, dq=FAST, ddq=np.zeros(len(FAST)))
"""Up to 6 rad/s, the speed in steps of 0.5 mrad/s."""


def tables_of(model: JointModel) -> Tables:
    """Tables of a joint whose friction follows from the velocity."""
    tables, past = tabulate(model.inertia_kg_m2, model.terms, FAR)
    assert not past
    return tables


class Moved(NamedTuple):
    q: Float
    dq: Float


def simulate(model: JointModel, t: Float, drive: Float, *, q: float = 0.0, dq: float = 0.0) -> Moved:
    """A joint whose friction follows from the velocity under a torque that is linear between even samples."""
    n, step_s = len(t), float(t[1] - t[0])
    start, whole, steps = (np.full(n, q), np.full(n, dq)), np.array([[0, n - 1]]), int(np.ceil(step_s / STEP_S - 1e-6))
    return Moved(*integrate_segments(step_s, steps, drive, *start, whole, np.zeros((n, 1)), tables_of(model)))
