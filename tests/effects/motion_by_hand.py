"""Motions by hand, a few samples each: of one joint, or among others with what a model of the arm says about it."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion, Others, RigidBody
from friction_audit.joint_log import Float

N = 5
DQ: Float = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])


def motion_of(
    *,
    t: Sequence[float] | Float | None = None,
    q: Sequence[float] | Float | None = None,
    dq: Sequence[float] | Float | None = None,
    temperature: Sequence[float] | None = None,
) -> Motion:
    """A motion of which only some things are told; a second between samples, all else at rest at zero."""
    given = [values for values in (t, q, dq, temperature) if values is not None]
    n = len(given[0])
    return Motion(
        t=np.arange(n, dtype=np.float64) if t is None else np.asarray(t, dtype=np.float64),
        q=np.zeros(n) if q is None else np.asarray(q, dtype=np.float64),
        dq=np.zeros(n) if dq is None else np.asarray(dq, dtype=np.float64),
        ddq=np.zeros(n),
        temperature=None if temperature is None else np.asarray(temperature, dtype=np.float64),
    )


def among_three(*, joint: int = 1, rigid: RigidBody | None = None) -> Motion:
    """Joint 1 of 0 to 2; the sensors read 10 k + sample, accelerations are k + 1, speeds 2 (k + 1)."""
    numbers = np.arange(3.0)
    others = Others(
        joint=joint,
        dq=np.tile(2.0 * (numbers + 1.0), (N, 1)),
        ddq=np.tile(numbers + 1.0, (N, 1)),
        sensed=10.0 * numbers + np.arange(N)[:, None],
    )
    t: Float = np.arange(N, dtype=np.float64) * 0.01
    return Motion(t=t, q=0.3 * DQ, dq=DQ, ddq=3.0 * DQ, others=others, rigid=rigid)


def rigid_body() -> RigidBody:
    """Link 2 is the joint's own, link 3 the last; every column a different constant."""
    weight = np.tile(np.arange(1.0, 9.0).reshape(2, 4), (N, 1, 1))
    return RigidBody(
        t=np.arange(N, dtype=np.float64) * 0.01,
        links=(2, 3),
        weight=weight,
        tilt=np.tile([20.0, 21.0], (N, 1)),
        inertial=np.full(N, 30.0),
        tip=np.tile(np.arange(40.0, 50.0), (N, 1)),
    )
