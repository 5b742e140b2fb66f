"""Sessions made by hand: what the tests of drift are fed with."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from friction_audit.drift.session import Conditions, JointSummary, Session
from friction_audit.friction.history import Coefficient

A_DAY_S = 86400.0
FIRST_S = 1772323200.0  # 2026-03-01 00:00 UTC

HAND = Conditions(drive="hand", torque="interaction", gravity="removed", inertia="none", rate_hz=1000.0)


def make_joint(
    number: int,
    coulomb: float,
    viscous: float = 0.07,
    *,
    error: float = 0.003,
    temperature: float | None = None,
    speed: float = 0.7,
    within: dict[str, Coefficient] | None = None,
) -> JointSummary:
    return JointSummary(
        joint=number,
        name=f"joint{number}",
        coefficients={
            "coulomb_nm": Coefficient.around(coulomb, 1.96 * error),
            "viscous_nms_per_rad": Coefficient.around(viscous, 1.96 * 0.003),
        },
        cycles=30,
        moving_s=30.0,
        speed_rad_s=(0.5 * speed, speed, 1.5 * speed),
        temperature_c=temperature,
        within=within or {},
    )


def make_session(
    i: int,
    joints: Sequence[JointSummary],
    *,
    start: float | None = None,
    conditions: Conditions = HAND,
    robot: str = "arm",
    known: bool = True,
) -> Session:
    return Session(
        path=f"run{i}.csv",
        sha256=f"content {i}",
        robot=robot,
        start_s=(FIRST_S + i * A_DAY_S if start is None else start) if known else None,
        start_from="log" if known else "nothing",
        duration_s=60.0,
        conditions=conditions,
        joints=tuple(joints),
        log_joints=len(joints),
    )


def make_sessions(
    coulomb: ArrayLike, *, error: float = 0.003, temperature: ArrayLike | None = None, seed: int = 0
) -> list[Session]:
    """One joint; viscous friction scatters by itself, without drift."""
    rng = np.random.default_rng(seed)
    levels = np.asarray(coulomb, dtype=float)
    warmth = [None] * len(levels) if temperature is None else [float(t) for t in np.asarray(temperature)]
    return [
        make_session(i, [make_joint(1, c, 0.07 + 0.003 * rng.standard_normal(), error=error, temperature=warmth[i])])
        for i, c in enumerate(levels)
    ]


def make_arm_sessions(coulomb: ArrayLike) -> list[Session]:
    """Seven joints, of which the first has these levels and the others scatter without drift."""
    levels = np.asarray(coulomb, dtype=float)
    others = [noisy(len(levels), 100 + k) for k in range(6)]
    viscous = [noisy(len(levels), 200 + k, level=0.07) for k in range(7)]
    return [
        make_session(i, [make_joint(j + 1, one[i], viscous[j][i]) for j, one in enumerate((levels, *others))])
        for i in range(len(levels))
    ]


def noisy(n: int, seed: int = 0, *, level: float = 0.3, scatter: float = 0.003) -> np.ndarray:
    return np.asarray(level + scatter * np.random.default_rng(seed).standard_normal(n))
