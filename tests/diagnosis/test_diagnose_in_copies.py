"""A diagnosis whose joints are worked on by copies of the process says what it says with threads."""

import json
import sys
from collections.abc import Callable

import pytest

from friction_audit.diagnosis import diagnose
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.parallel import in_processes, per_joint
from friction_audit.pipeline import AuditSettings, diagnose_log
from friction_audit.reporting.diagnosis import diagnose_document
from tests.reporting.conftest import build_estimate


def _none(*_: object) -> list[object]:
    raise AssertionError


def document(threads: Callable[..., object], copies: Callable[..., object]) -> str:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(diagnose, "per_joint", threads)
        patch.setattr(diagnose, "in_processes", copies)
        patch.setattr(diagnose, "workers_for", lambda joints, _: 1 if copies is _none else joints)
        log = build_estimate(2, count=24, rate=250.0).log
        return json.dumps(
            diagnose_document(diagnose_log(log, AuditSettings(), DiagnosisSettings(candidates=("stribeck",))))
        )


@pytest.mark.skipif(sys.platform != "linux", reason="no process is copied there")
def test_copies_say_what_threads_say() -> None:
    assert document(_none, in_processes) == document(per_joint, _none)
