"""A batch made by hand: arms of which every joint's drift is known, without any statistics."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from friction_audit.batch.identity import FailedLog
from friction_audit.drift.report import ArmDrift, ChangePoint, CoefficientDrift, ControlPoint, JointDrift
from friction_audit.drift.session import Conditions, JointSummary, Session, SpeedCurve
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.preprocessing.interaction import quoted
from friction_audit.reporting.drift import BatchSummary

NAN = float("nan")
START_S, APART_S = 1772550000.0, 1.5 * 86400.0  # 2026-03-03 15:00 UTC, and from one session to the next
LEVELS = {
    "coulomb_nm": (0.245, 0.152, 0.183, 0.359, 0.267, 0.166, 0.211),
    "viscous_nms_per_rad": (0.04, 0.03, 0.025, 0.05, 0.013, 0.011, 0.012),
}
NOISE = {"coulomb_nm": 0.015, "viscous_nms_per_rad": 0.06}  # relative standard deviation of an estimate
STEP_JOINT, STEP_SESSION, STEP = 2, 12, 0.15  # joint number, index of the first session after the step, its size
RISE_JOINT, RISE = 5, 0.01  # joint number, rise per session
STILL_JOINT = 7  # a joint that never moves
LEFT_OUT = 8  # index of a session with another payload
HOSTILE = "<script>alert('x')</script> & \"$\\frac{1}$\""
STILL = JointSummary(
    joint=STILL_JOINT, name="panda_joint7", coefficients=dict.fromkeys(LEVELS, UNDETERMINED), cycles=0, moving_s=0.0,
    speed_rad_s=(NAN, NAN, NAN), within=dict.fromkeys(LEVELS, UNDETERMINED), verdict="not_testable",
    reason=quoted("the joint does not move; move it back and forth"),
)  # fmt: skip
number = Coefficient.around


def change_of(joint: int, coefficient: str, session: int) -> float:
    step = STEP * (joint == STEP_JOINT and session >= STEP_SESSION)
    return (step + RISE * session * (joint == RISE_JOINT)) * (coefficient == "coulomb_nm")


def joint_summary(joint: int, session: int, rng: np.random.Generator) -> JointSummary:
    if joint == STILL_JOINT:
        return STILL
    values = {}
    for coefficient, levels in LEVELS.items():
        level, noise = levels[(joint - 1) % 7], NOISE[coefficient]
        mean = level * (1.0 + change_of(joint, coefficient, session))
        values[coefficient] = number(mean + noise * level * rng.standard_normal(), 1.96 * noise * level)
    half = np.linspace(0.05, 0.8, 9)
    speed = np.concatenate([-half[::-1], half])
    torque = values["coulomb_nm"].value * np.sign(speed) + values["viscous_nms_per_rad"].value * speed
    return JointSummary(
        joint=joint, name=f"panda_joint{joint}", coefficients=values, cycles=24, moving_s=41.0,
        speed_rad_s=(0.2, 0.4, 0.7), temperature_c=31.0 + 2.0 * float(np.sin(1.7 * session)),
        within={"coulomb_nm": number(-0.03 if joint == 1 else 0.002, 0.01)},
        curve=SpeedCurve(
            speed_rad_s=tuple(speed.tolist()), torque_nm=tuple(torque.tolist()), spread_nm=(0.02,) * len(speed)
        ),
        verdict="named" if joint == 3 else "adequate", effects=("stribeck",) if joint == 3 else (),
    )  # fmt: skip


def session_of(index: int, joints: int, robot: str, rng: np.random.Generator, *, dated: bool) -> Session:
    payload = "0.7 kg" if index == LEFT_OUT else ""
    return Session(
        path=f"logs/{robot}/run_{index + 1:03d}.mcap", sha256=f"{index:064x}", robot=robot, duration_s=60.0,
        start_s=START_S + APART_S * index if dated else None, start_from="log" if dated else "nothing",
        conditions=Conditions(drive="hand", torque="tau_J", gravity="model", inertia="none", payload=payload),
        joints=tuple(joint_summary(j + 1, index, rng) for j in range(joints)),
        note="after grease" if index == STEP_SESSION else "",
        warnings=quoted("3 repeated rows were left out") if index == 2 else (), damaged=index == 2,
    )  # fmt: skip


def drift_of(sessions: Sequence[Session], joint: int, coefficient: str, compared: Sequence[int]) -> CoefficientDrift:
    """Return what a perfect analysis would say: levels and changes as put in."""
    if joint == STILL_JOINT:
        return CoefficientDrift(coefficient=coefficient, sessions=(), values=(), shape="too_few", drift=False)
    values = tuple(sessions[k].joints[joint - 1].coefficients[coefficient] for k in compared)
    level, noise = LEVELS[coefficient][(joint - 1) % 7], NOISE[coefficient]
    limit, total = 3.2 * noise, change_of(joint, coefficient, compared[-1])
    relative = [value.value / level - 1.0 for value in values]
    control = tuple(
        ControlPoint(
            session=k, deviation=Coefficient(value=level * off, low=-limit * level, high=limit * level),
            relative=Coefficient(value=off, low=-limit, high=limit), outside=abs(off) > limit,
        )
        for k, off in zip(compared, relative, strict=True)
    )  # fmt: skip
    step = ChangePoint(
        session=STEP_SESSION, low=STEP_SESSION - 1, high=STEP_SESSION + 1, before=number(level, noise * level),
        after=number(level * (1.0 + STEP), noise * level), change=number(STEP * level, noise * level),
        relative=number(STEP, noise), p_value=1e-6,
    )  # fmt: skip
    changes = coefficient == "coulomb_nm"
    steps = (step,) if changes and joint == STEP_JOINT and STEP_SESSION in compared else ()
    rise = RISE * level if changes and joint == RISE_JOINT else 0.0
    return CoefficientDrift(
        coefficient=coefficient, sessions=tuple(compared), values=values, level=number(level, 0.5 * noise * level),
        shape="step" if steps else "ramp" if rise else "none", p_value=1e-5 if steps or rise else 0.6,
        temperature_slope=number(-0.002, 0.001), trend_per_session=number(rise, 0.1 * RISE * level),
        trend_per_day=number(rise / 1.5, 0.07 * RISE * level) if sessions[0].start_s is not None else UNDETERMINED,
        trend_p_value=1e-5 if rise else 0.6, change_points=steps, control=control,
        change=number(total * level, noise * level), total=number(total, noise), scatter=0.004,
        smallest_change=2.2 * noise * level, smallest_drift=2.2 * noise,
        within=number(-0.03 if joint == 1 else 0.0, 0.01), drift=bool(steps) or rise > 0.0,
    )  # fmt: skip


def arm(count: int = 24, joints: int = 7, *, robot: str = "panda-1", dated: bool = True) -> ArmDrift:
    """Return an arm whose joint 2 steps, whose joint 5 rises, whose joint 7 stands still."""
    rng = np.random.default_rng(0)
    sessions = tuple(session_of(k, joints, robot, rng, dated=dated) for k in range(count))
    compared = [k for k in range(count) if k != LEFT_OUT]
    found = []
    for one in sessions[0].joints:
        drift = tuple(drift_of(sessions, one.joint, coefficient, compared) for coefficient in LEVELS)
        found.append(JointDrift(joint=one.joint, name=one.name, coefficients=drift))
    return ArmDrift(
        robot=robot, sessions=sessions, compared=tuple(compared), ordered_by="start" if dated else "name",
        autocorrelation=0.05, reference=tuple(range(min(5, count))), joints=tuple(found),
        left_out=((LEFT_OUT, quoted("payload 0.7 kg, the reference had none")),) if count > LEFT_OUT else (),
        warnings=quoted("temperatures are not logged: warm and cold sessions are not separated"),
    )  # fmt: skip


SETTINGS: Mapping[str, object] = {"drift": {"alpha": 0.05, "fail_on": ["coulomb=15%"]}, "joints": [1, 2, 3]}


def batch(*arms: ArmDrift) -> BatchSummary:
    return BatchSummary(
        arms=arms or (arm(),),
        failed=(FailedLog(path="logs/broken.bag", message="broken.bag: is truncated after 12 kB; record it again"),),
        exceeded=("panda-1, joint 2: Coulomb friction changed by +15.0 %, the limit is 15 %",),
        command="friction-audit batch-report logs --fail-on coulomb=15% -o out", settings=SETTINGS, computed=20,
        known=4,
    )  # fmt: skip


def hostile() -> BatchSummary:
    plain = arm(LEFT_OUT + 4, 3)
    words: dict[str, Any] = {"path": f"{HOSTILE}.csv", "robot": HOSTILE, "note": HOSTILE, "warnings": quoted(HOSTILE)}
    sessions = tuple(
        replace(one, joints=tuple(replace(joint, name=HOSTILE, effects=(HOSTILE,)) for joint in one.joints), **words)
        for one in plain.sessions
    )
    joints = tuple(replace(joint, name=HOSTILE) for joint in plain.joints)
    bad = replace(plain, robot=HOSTILE, sessions=sessions, joints=joints, warnings=quoted(HOSTILE))
    return BatchSummary(
        arms=(replace(bad, left_out=((LEFT_OUT, quoted(HOSTILE)),)),), exceeded=(HOSTILE,),
        failed=(FailedLog(path=HOSTILE, message=HOSTILE),), settings={HOSTILE: {HOSTILE: [HOSTILE]}},
        command=f"friction-audit batch-report {HOSTILE}",
    )  # fmt: skip


def empty() -> BatchSummary:
    failed = (FailedLog(path="a.csv", message="a.csv: no column for dq"),)
    return BatchSummary(arms=(), failed=failed, settings=SETTINGS)
