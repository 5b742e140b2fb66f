"""Pages show the same log diagnosed in several commands: it is diagnosed once, which takes longest of all they do."""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from typing import Any

import pytest

from friction_audit.diagnosis import diagnose
from friction_audit.diagnosis.result import JointDiagnosis

FOUND: dict[str, tuple[JointDiagnosis, ...]] = {}
"""What was found, by all that it was found from."""
_diagnose = diagnose.diagnose_subjects


def _remembering(subjects: Any, settings: Any, _report: Any = None) -> tuple[JointDiagnosis, ...]:
    """Diagnose what was not diagnosed before; the name of the file is no part of what a diagnosis is made from."""
    key = sha256(pickle.dumps((subjects, settings))).hexdigest()
    if key not in FOUND:
        FOUND[key] = _diagnose(subjects, settings)
    return FOUND[key]


@contextmanager
def diagnosed_once() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(diagnose, "diagnose_subjects", _remembering)
        yield
