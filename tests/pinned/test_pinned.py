"""The answers of every command on the sample logs and on simulated ones are those that were written down.

``python -m tests.pinned --check`` asks for 1e-9 and for the hashes of simulated logs, on the machine where they were
written; here the numbers may differ as they do between processors.
"""

import json
import math
from pathlib import Path
from typing import Any

import pytest

from tests.pinned.commands import answers

ANSWERS = Path(__file__).parent / "answers.json"
HASHES = Path(__file__).parent / "hashes.json"
ACROSS_MACHINES = 1e-3
"""Searches over nonlinear parameters end within their tolerance, which other processors' rounding reaches elsewhere."""
SMALL = 1e-9


def differences(found: dict[str, Any], expected: dict[str, Any], *, relative: float) -> list[str]:
    """Name what differs, by command and path."""
    wrong = [f"{name}: not asked on both sides" for name in sorted(expected.keys() ^ found.keys())]
    for name in sorted(expected.keys() & found.keys()):
        old, new = expected[name], found[name]
        for path in sorted(old.keys() | new.keys()):
            if path not in new or path not in old:
                wrong.append(f"{name}: {path} is {'gone' if path in old else 'new'}")
            elif not same(new[path], old[path], relative):
                wrong.append(f"{name}: {path}: {old[path]} became {new[path]}")
    return wrong


def same(new: object, old: object, relative: float) -> bool:
    """Return True for equal words and for numbers that differ by no more than a share."""
    if isinstance(new, list) and isinstance(old, list):
        return len(new) == len(old) and all(same(a, b, relative) for a, b in zip(new, old, strict=True))
    if isinstance(new, float) or isinstance(old, float):
        numbers = isinstance(new, int | float) and isinstance(old, int | float)
        return numbers and math.isclose(float(new), float(old), rel_tol=relative, abs_tol=SMALL)  # type: ignore[arg-type]
    return new == old


@pytest.fixture
def current(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("slow", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_every_answer_is_the_one_that_was_written_down(current: Path, *, slow: bool) -> None:
    found = dict(answers(current, slow=slow))
    expected = json.loads(ANSWERS.read_text())
    wrong = differences(found, {name: expected[name] for name in found}, relative=ACROSS_MACHINES)
    assert not wrong, "\n".join(wrong[:20])
    assert not slow or found.keys() == expected.keys()
