"""A batch made by hand: arms of which every joint's drift is known, without any statistics."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from friction_audit.drift.report import ArmDrift, ChangePoint, CoefficientDrift, ControlPoint, DriftReport, JointDrift
from friction_audit.drift.session import Conditions, JointSummary, Session, SpeedCurve
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting.drift import BatchSummary, FailedLog

NAN = float("nan")
DAY_S = 86400.0
START_S = 1772550000.0
"""2026-03-03 15:00 UTC."""
LEVELS = {
    "coulomb_nm": (0.245, 0.152, 0.183, 0.359, 0.267, 0.166, 0.211),
    "viscous_nms_per_rad": (0.04, 0.03, 0.025, 0.05, 0.013, 0.011, 0.012),
}
NOISE = {"coulomb_nm": 0.015, "viscous_nms_per_rad": 0.06}
"""Relative standard deviation of an estimate."""
REFERENCE = 5
STEP_JOINT, STEP_SESSION, STEP = 2, 12, 0.15
"""Joint number, index of the first session after the step, its size."""
RISE_JOINT, RISE = 5, 0.01
"""Joint number, rise per session."""
STILL_JOINT = 7
"""A joint that never moves."""
LEFT_OUT = 8
"""Index of a session with another payload."""
HOSTILE = "<script>alert('x')</script> & \"$\\frac{1}$\""


def number(value: float, half: float) -> Coefficient:
    return Coefficient(value=value, low=value - half, high=value + half)


def change_of(joint: int, coefficient: str, session: int) -> float:
    """Return the relative change that was put in."""
    if coefficient != "coulomb_nm":
        return 0.0
    if joint == STEP_JOINT and session >= STEP_SESSION:
        return STEP
    return RISE * session if joint == RISE_JOINT else 0.0


def speed_curve(coulomb: float, viscous: float) -> SpeedCurve:
    half = np.linspace(0.05, 0.8, 9)
    speed = np.concatenate([-half[::-1], half])
    torque = coulomb * np.sign(speed) + viscous * speed
    spread = np.full(len(speed), 0.02)
    return SpeedCurve(
        speed_rad_s=tuple(speed.tolist()), torque_nm=tuple(torque.tolist()), spread_nm=tuple(spread.tolist())
    )


def joint_summary(joint: int, session: int, name: str, rng: np.random.Generator) -> JointSummary:
    if joint == STILL_JOINT:
        return JointSummary(
            joint=joint, name=name, coefficients=dict.fromkeys(LEVELS, UNDETERMINED), cycles=0, moving_s=0.0,
            speed_rad_s=(NAN, NAN, NAN), within=dict.fromkeys(LEVELS, UNDETERMINED),
            reason="the joint does not move; move it back and forth", verdict="not_testable",
        )  # fmt: skip
    values = {}
    for coefficient, levels in LEVELS.items():
        level = levels[(joint - 1) % len(levels)]
        mean = level * (1.0 + change_of(joint, coefficient, session))
        sigma = NOISE[coefficient] * level
        values[coefficient] = number(mean + sigma * rng.standard_normal(), 1.96 * sigma)
    within = {"coulomb_nm": number(-0.03 if joint == 1 else 0.002, 0.01), "viscous_nms_per_rad": number(-0.01, 0.05)}
    return JointSummary(
        joint=joint,
        name=name,
        coefficients=values,
        cycles=24,
        moving_s=41.0,
        speed_rad_s=(0.2, 0.4, 0.7),
        temperature_c=31.0 + 2.0 * float(np.sin(1.7 * session)),
        within=within,
        curve=speed_curve(values["coulomb_nm"].value, values["viscous_nms_per_rad"].value),
        verdict="named" if joint == 3 else "adequate",
        effects=("stribeck",) if joint == 3 else (),
    )


def session_of(index: int, joints: int, *, robot: str, dated: bool, rng: np.random.Generator) -> Session:
    return Session(
        path=f"logs/{robot}/run_{index + 1:03d}.mcap",
        sha256=f"{index:064x}",
        robot=robot,
        start_s=START_S + 1.5 * DAY_S * index if dated else None,
        start_from="log" if dated else "nothing",
        duration_s=60.0,
        conditions=Conditions(
            drive="hand", torque="tau_J", gravity="model", inertia="none", payload="0.7 kg" if index == LEFT_OUT else ""
        ),
        joints=tuple(joint_summary(j + 1, index, f"panda_joint{j + 1}", rng) for j in range(joints)),
        note="after grease" if index == STEP_SESSION else "",
        warnings=("3 repeated rows were left out",) if index == 2 else (),
        damaged=index == 2,
    )


def drift_of(sessions: Sequence[Session], joint: int, coefficient: str, compared: Sequence[int]) -> CoefficientDrift:
    """Return what a perfect analysis would say: levels and changes as put in."""
    values = tuple(sessions[k].joints[joint - 1].coefficients[coefficient] for k in compared)
    if joint == STILL_JOINT:
        return nothing_of(coefficient)
    level = LEVELS[coefficient][(joint - 1) % 7]
    noise = NOISE[coefficient]
    limit = 3.2 * noise
    control = tuple(
        ControlPoint(
            session=k,
            deviation=Coefficient(value=value.value - level, low=-limit * level, high=limit * level),
            relative=Coefficient(value=value.value / level - 1.0, low=-limit, high=limit),
            outside=abs(value.value / level - 1.0) > limit,
        )
        for k, value in zip(compared, values, strict=True)
    )
    total = change_of(joint, coefficient, compared[-1])
    steps = tuple(step_of(k, level, noise) for k in compared if is_step(joint, coefficient, k))
    rise = RISE * level if joint == RISE_JOINT and coefficient == "coulomb_nm" else 0.0
    drift = bool(steps) or rise > 0.0
    return CoefficientDrift(
        coefficient=coefficient,
        sessions=tuple(compared),
        values=values,
        level=number(level, 0.5 * noise * level),
        shape="step" if steps else "ramp" if rise else "none",
        p_value=1e-5 if drift else 0.6,
        temperature_slope=number(-0.002, 0.001),
        trend_per_session=number(rise, 0.1 * RISE * level),
        trend_per_day=number(rise / 1.5, 0.07 * RISE * level) if sessions[0].start_s is not None else UNDETERMINED,
        trend_p_value=1e-5 if rise else 0.6,
        change_points=steps,
        control=control,
        change=number(total * level, noise * level),
        total=number(total, noise),
        scatter=0.004,
        smallest_change=2.2 * noise * level,
        smallest_drift=2.2 * noise,
        within=number(-0.03 if joint == 1 else 0.0, 0.01),
        drift=drift,
    )


def is_step(joint: int, coefficient: str, session: int) -> bool:
    return joint == STEP_JOINT and coefficient == "coulomb_nm" and session == STEP_SESSION


def step_of(session: int, level: float, noise: float) -> ChangePoint:
    return ChangePoint(
        session=session,
        low=session - 1,
        high=session + 1,
        before=number(level, noise * level),
        after=number(level * (1.0 + STEP), noise * level),
        relative=number(STEP, noise),
        p_value=1e-6,
    )


def nothing_of(coefficient: str) -> CoefficientDrift:
    return CoefficientDrift(coefficient=coefficient, sessions=(), values=(), shape="too_few", drift=False)


def arm(count: int = 24, joints: int = 7, *, robot: str = "panda-1", dated: bool = True, seed: int = 0) -> ArmDrift:
    """Return an arm whose joint 2 steps, whose joint 5 rises, whose joint 7 stands still."""
    rng = np.random.default_rng(seed)
    sessions = tuple(session_of(k, joints, robot=robot, dated=dated, rng=rng) for k in range(count))
    left_out = ((LEFT_OUT, "payload 0.7 kg, the reference had none"),) if count > LEFT_OUT else ()
    compared = [k for k in range(count) if k not in dict(left_out)]
    return ArmDrift(
        robot=robot,
        sessions=sessions,
        compared=tuple(compared),
        ordered_by="start" if dated else "name",
        autocorrelation=0.05,
        reference=tuple(range(min(REFERENCE, count))),
        left_out=left_out,
        joints=tuple(joint_of(sessions, j + 1, compared) for j in range(joints)),
        warnings=("temperatures are not logged: warm and cold sessions are not separated",),
    )


def joint_of(sessions: Sequence[Session], joint: int, compared: Sequence[int]) -> JointDrift:
    found = tuple(drift_of(sessions, joint, coefficient, compared) for coefficient in LEVELS)
    return JointDrift(joint=joint, name=sessions[0].joints[joint - 1].name, coefficients=found)


SETTINGS: Mapping[str, object] = {
    "reading": {"topic": None, "map": {}},
    "drift": {"alpha": 0.05, "baseline": 5, "fail_on": ["coulomb=15%"]},
    "joints": [1, 2, 3, 4, 5, 6, 7],
}


def batch(*arms: ArmDrift) -> BatchSummary:
    return BatchSummary(
        report=DriftReport(arms=arms or (arm(),)),
        failed=(FailedLog(path="logs/broken.bag", message="broken.bag: is truncated after 12 kB; record it again"),),
        exceeded=("panda-1, joint 2: Coulomb friction changed by +15.0 %, the limit is 15 %",),
        settings=SETTINGS,
        command="friction-audit batch-report logs --fail-on coulomb=15% -o out",
        computed=20,
        known=4,
    )


def hostile() -> BatchSummary:
    """Return a batch of which every word from outside is markup."""
    plain = arm()
    sessions = tuple(
        replace(
            one,
            path=f"{HOSTILE}.csv",
            robot=HOSTILE,
            note=HOSTILE,
            warnings=(HOSTILE,),
            joints=tuple(replace(joint, name=HOSTILE, effects=(HOSTILE,)) for joint in one.joints),
        )
        for one in plain.sessions
    )
    joints = tuple(replace(joint, name=HOSTILE) for joint in plain.joints)
    bad = replace(
        plain, robot=HOSTILE, sessions=sessions, joints=joints, warnings=(HOSTILE,), left_out=((LEFT_OUT, HOSTILE),)
    )
    return BatchSummary(
        report=DriftReport(arms=(bad,)),
        failed=(FailedLog(path=HOSTILE, message=HOSTILE),),
        exceeded=(HOSTILE,),
        settings={HOSTILE: {HOSTILE: [HOSTILE]}},
        command=f"friction-audit batch-report {HOSTILE}",
    )


def empty() -> BatchSummary:
    """Return a batch in which no file could be read."""
    failed = (FailedLog(path="a.csv", message="a.csv: no column for dq"),)
    return BatchSummary(report=DriftReport(arms=()), failed=failed, settings=SETTINGS)
