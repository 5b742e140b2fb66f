"""Sessions of several arms -> their drift, arms side by side."""

from collections.abc import Sequence
from functools import partial

from friction_audit.batch.executor import Executor, Lost
from friction_audit.drift.analyse import analyse_arm, analyse_drift, arms_of
from friction_audit.drift.report import ArmDrift, DriftReport
from friction_audit.drift.session import Session
from friction_audit.drift.settings import DriftSettings
from friction_audit.errors import AnalysisError


def drift_of_arms(sessions: Sequence[Session], settings: DriftSettings, executor: Executor) -> DriftReport:
    """Find what changed between the sessions of each arm.

    Args:
        sessions: Of any arms, in any order.
        settings: How drift is looked for.
        executor: What runs the work; a single arm is analysed here, where its sessions are.

    Raises:
        AnalysisError: If nobody finishes an arm.
    """
    arms = arms_of(sessions)
    if len(arms) == 1:
        return analyse_drift(sessions, settings)
    found: dict[str, ArmDrift] = {}
    for arm, drift in executor.run(partial(analyse_arm, settings=settings), arms):
        if isinstance(drift, Lost):
            raise AnalysisError(f"{arm[0].robot}: its drift cannot be analysed: {drift.message}")
        found[drift.robot] = drift
    return DriftReport(arms=tuple(found[robot] for robot in sorted(found)))
