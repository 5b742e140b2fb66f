"""Reports made by hand: six joints, a verdict each, the third at rest; hostile names; many joints; one at rest."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from friction_audit.compensation.settings import ReplaySettings
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.joint_log import Finding, JointLog
from friction_audit.pipeline import AuditSettings, Diagnosis, estimate_log, replay_estimate
from friction_audit.preprocessing.interaction import quoted
from friction_audit.reporting.report import LogReport, report_estimate
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import ALL

HOSTILE = "<script>alert('x')</script> & \"$\\frac{1}$\" | `x`"
COMMAND = "friction-audit report 'run 1.csv' -o out"
LOST = "the file ends early; 3 messages were left out"


@cache
def report() -> LogReport:
    return _report(build_estimate(6, damaged=True).log, ALL, COMMAND)


def hostile() -> LogReport:
    log = build_estimate(3).log.take_joints((0, 2))
    lost = Finding(code="truncated", message=HOSTILE, amount=3, damaged=True)
    words: dict[str, Any] = {"robot": HOSTILE, "topic": HOSTILE, "channels": {HOSTILE: HOSTILE}, "findings": (lost,)}
    log = replace(log, joint_names=(HOSTILE,) * 2, source=replace(log.source, path=f"{HOSTILE}.csv", **words))
    joints = tuple(replace(one, name=HOSTILE, reason=quoted(HOSTILE)) for one in ALL.joints[:2])
    found = _report(log, replace(ALL, joints=joints), HOSTILE)
    return replace(found, reading={HOSTILE: [HOSTILE]})


def many(joints: int, name: str = "segment") -> LogReport:
    one = build_estimate(1, rate=100.0).log
    columns: dict[str, Any] = {name: np.repeat(channel, joints, axis=1) for name, channel in one.channels().items()}
    log = replace(one, **columns, joint_names=tuple(f"{name}_{k}" for k in range(1, joints + 1)))
    return LogReport(estimate=estimate_log(log, AuditSettings()), command=COMMAND)


def still() -> LogReport:
    """Return a report of a joint that did not move, to which no part has an answer but the estimate's reason."""
    moved = build_estimate(1, rate=100.0).log
    resting: dict[str, Any] = {name: np.zeros_like(channel) for name, channel in moved.channels().items()}
    estimate = estimate_log(replace(moved, **resting), AuditSettings())
    return report_estimate(estimate, ReplaySettings(), DiagnosisSettings(), command=COMMAND)


def cut(report: LogReport, *numbers: int) -> LogReport:
    def own(result: Any) -> Any:
        return replace(result, joints=tuple(one for one in result.joints if one.joint in numbers))

    estimate, diagnosis, replay = report.estimate, report.diagnosis, report.replay
    return replace(
        report,
        estimate=replace(estimate, friction=own(estimate.friction)),
        diagnosis=diagnosis and own(diagnosis),
        replay=replay and replace(replay, replay=own(replay.replay)),
    )


def _report(log: JointLog, missing: Diagnosis, command: str) -> LogReport:
    estimate = estimate_log(log, AuditSettings())
    replay = replay_estimate(estimate, ReplaySettings())
    return LogReport(estimate=estimate, diagnosis=replace(missing, estimate=estimate), replay=replay, command=command)
