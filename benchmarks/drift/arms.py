"""Arms of seven joints, pooled from sessions of one joint, and the tables of what was said of them."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.answers import share
from benchmarks.drift.library import OneJoint
from friction_audit.drift.analyse import analyse_arm
from friction_audit.drift.report import ArmDrift, CoefficientDrift, DriftSettings
from friction_audit.drift.session import Conditions, JointSummary, Session

JOINTS = 7
DRIFTING = 3
A_DAY_S = 86400.0


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What was said of one arm."""

    drift: bool  # whether drift was reported
    found: bool  # whether it was reported of the coefficient that drifts
    falsely: bool  # whether it was reported of another one
    shape: str  # of the coefficient that drifts
    off: int | None  # sessions from the true step to the nearest one that was reported, or None
    covered: bool | None  # whether the interval of the moment holds the true one, or None
    total: float  # change of the coefficient that drifts
    size_covered: bool  # whether its interval holds the true change


def pool(
    rng: np.random.Generator, null: Sequence[OneJoint], drifting: Sequence[OneJoint] | None, count: int
) -> list[Session]:
    """Put sessions of one joint together to sessions of an arm, joint 3 from those that drift, no session twice."""
    drawn = rng.choice(len(null), size=(count, JOINTS), replace=False)
    sessions = []
    for i in range(count):
        parts = [null[k] for k in drawn[i]]
        if drifting is not None:
            parts[DRIFTING - 1] = drifting[i]
        joints = tuple(replace(part.summary, joint=j + 1, name=f"joint{j + 1}") for j, part in enumerate(parts))
        sessions.append(make_session(i, joints, parts[0].conditions))
    return sessions


def make_session(i: int, joints: tuple[JointSummary, ...], conditions: Conditions) -> Session:
    """Return the session of the i-th day."""
    return Session(
        path=f"day{i}.parquet",
        sha256=str(i),
        robot="arm",
        start_s=1.77e9 + i * A_DAY_S,
        start_from="log",
        duration_s=60.0,
        conditions=conditions,
        joints=joints,
    )


def judge(sessions: Sequence[Session], settings: DriftSettings, true_step: int | None, true_total: float) -> Outcome:
    """Analyse one arm and compare with the truth; joint 3's Coulomb friction is what drifts."""
    arm = analyse_arm(sessions, settings)
    mine = coulomb_of(arm, DRIFTING)
    others = [d for joint in arm.joints for d in joint.coefficients if d is not mine]
    at = [(point.session, point.low, point.high) for point in mine.change_points]
    near = min(at, key=lambda point: abs(point[0] - (true_step or 0)), default=None)
    timed = near is not None and true_step is not None
    return Outcome(
        drift=arm.drift,
        found=mine.drift,
        falsely=any(drift.drift for drift in others),
        shape=mine.shape,
        off=abs(near[0] - true_step) if timed and near and true_step is not None else None,
        covered=near[1] <= true_step <= near[2] if timed and near and true_step is not None else None,
        total=mine.total.value,
        size_covered=mine.total.low <= true_total <= mine.total.high,
    )


def coulomb_of(arm: ArmDrift, number: int) -> CoefficientDrift:
    """Return the Coulomb friction of a joint."""
    joint = next(joint for joint in arm.joints if joint.joint == number)
    return joint.coefficients[0]


def repeat(count: int, seed: int, once: Callable[[np.random.Generator], Outcome]) -> list[Outcome]:
    """Judge so many arms."""
    return [once(np.random.default_rng((seed, k))) for k in range(count)]


def heading(made_by: str) -> Iterator[str]:
    """Yield how the table was made, and its head."""
    yield f"Made by {made_by}"
    yield ""
    yield (
        "| sessions | arms | drift reported | of joint 3, Coulomb | of another | within one session | moment covered | "
        "size covered | described as |"
    )
    yield "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"


def row(name: str, outcomes: Sequence[Outcome]) -> str:
    """Return one row; shares in per cent with their 95 % intervals."""
    timed = [outcome for outcome in outcomes if outcome.off is not None and outcome.found]
    shapes = Counter(outcome.shape for outcome in outcomes).most_common(3)
    cells = [
        name,
        str(len(outcomes)),
        share([o.drift for o in outcomes], 1),
        share([o.found for o in outcomes], 1),
        share([o.falsely for o in outcomes], 1),
        share([(o.off or 0) <= 1 for o in timed], 1),
        share([bool(o.covered) for o in timed], 1),
        share([o.size_covered for o in outcomes], 1),
        ", ".join(f"{shape} {100 * count / len(outcomes):.0f} %" for shape, count in shapes),
    ]
    return f"| {' | '.join(cells)} |"
