"""Reports made by hand: six joints, a verdict each, the third at rest; hostile names; many joints; one at rest."""

from dataclasses import replace
from typing import Any

import numpy as np

from friction_audit.compensation.settings import ReplaySettings
from friction_audit.diagnosis.result import Discrepancy
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.joint_log import Finding, JointLog
from friction_audit.pipeline import AuditSettings, Diagnosis, Estimate, estimate_log, replay_estimate
from friction_audit.reporting.report import LogReport, report_estimate
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosed_rows import ALL

HOSTILE = "<script>alert('x')</script> & \"$\\frac{1}$\" | `x`"
COMMAND = "friction-audit report 'run 1.csv' -o out"
LOST = "the file ends early; 3 messages were left out"


def report() -> LogReport:
    return _report(_with_finding(build_estimate(6, rate=200.0).log, LOST), ALL, COMMAND)


def hostile() -> LogReport:
    log = _with_finding(build_estimate(3, rate=200.0).log.take_joints((0, 2)), HOSTILE)
    source = replace(log.source, path=f"{HOSTILE}.csv", robot=HOSTILE, topic=HOSTILE, channels={HOSTILE: HOSTILE})
    joints = tuple(replace(one, name=HOSTILE, reason=HOSTILE) for one in ALL.discrepancy.joints[:2])
    missing = replace(ALL, discrepancy=Discrepancy(joints=joints))
    found = _report(replace(log, joint_names=(HOSTILE,) * 2, source=source), missing, HOSTILE)
    return replace(found, reading={HOSTILE: [HOSTILE]})


def many(joints: int) -> LogReport:
    """Return a report of an arm of many joints, each moving alike."""
    one = build_estimate(1, rate=100.0).log
    columns: dict[str, Any] = {name: np.repeat(channel, joints, axis=1) for name, channel in one.channels().items()}
    log = replace(one, **columns, joint_names=tuple(f"segment_{k}" for k in range(1, joints + 1)))
    return LogReport(estimate=estimate_log(log, AuditSettings()), command=COMMAND)


def called(name: str) -> LogReport:
    """Return a report of one joint of this name."""
    log = build_estimate(1, rate=100.0).log
    return LogReport(estimate=estimate_log(replace(log, joint_names=(name,)), AuditSettings()), command=COMMAND)


def still() -> LogReport:
    """Return a report of a joint that did not move, to which no part has an answer but the estimate's reason."""
    moved = build_estimate(1, rate=100.0).log
    resting: dict[str, Any] = {name: np.zeros_like(channel) for name, channel in moved.channels().items()}
    estimate = estimate_log(replace(moved, **resting), AuditSettings())
    return report_estimate(estimate, ReplaySettings(), DiagnosisSettings(), command=COMMAND)


def cut(report: LogReport, *numbers: int) -> LogReport:
    """Return a report of some of its joints."""
    friction, diagnosis, replay = report.estimate.friction, report.diagnosis, report.replay
    if diagnosis is not None:
        joints = tuple(one for one in diagnosis.discrepancy.joints if one.joint in numbers)
        diagnosis = replace(diagnosis, discrepancy=Discrepancy(joints=joints))
    if replay is not None:
        own = tuple(one for one in replay.replay.joints if one.joint in numbers)
        replay = replace(replay, replay=replace(replay.replay, joints=own))
    friction = replace(friction, joints=tuple(one for one in friction.joints if one.joint in numbers))
    return replace(report, estimate=replace(report.estimate, friction=friction), diagnosis=diagnosis, replay=replay)


def _with_finding(log: JointLog, message: str) -> JointLog:
    lost = Finding(code="truncated", message=message, amount=3, damaged=True)
    return replace(log, source=replace(log.source, findings=(lost,)))


def _report(log: JointLog, missing: Diagnosis, command: str) -> LogReport:
    estimate: Estimate = estimate_log(log, AuditSettings())
    return LogReport(
        estimate=estimate,
        diagnosis=replace(missing, estimate=estimate),
        replay=replay_estimate(estimate, ReplaySettings()),
        command=command,
    )
