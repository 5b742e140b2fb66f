"""Clean joints of two generators whose logs were interpolated, held, filtered or differentiated before they are read.

All were `unexplained` or a `data_fault` before noise was found as what position and velocity do not have in common.
"""

from functools import cache

import pytest

from benchmarks.resampled import CASES, Columns, log_by, recorded
from friction_audit.api import diagnose_log
from friction_audit.joint_log import Float
from tests.each_case import thorough

SEEDS = {scenario: 130_000 + seed for truth, scenario, seed, _ in CASES if truth == "none"}


@cache
def signals(scenario: str) -> tuple[Float, Columns]:
    return recorded("none", scenario, SEEDS[scenario], 1.0)


@pytest.mark.parametrize(
    ("scenario", "way"),
    [
        ("joint", "linear"),
        ("joint", "held up"),
        ("smoothed sign", "held"),
        *thorough([("joint", "difference"), ("joint-sine", "cubic")]),
    ],
)
def test_nothing_is_missing_in_a_clean_joint_whose_log_was_resampled(scenario: str, way: str) -> None:
    log = log_by(way, *signals(scenario), SEEDS[scenario])
    (found,) = diagnose_log(log).joints
    assert (found.verdict, found.effects) == ("adequate", ())
