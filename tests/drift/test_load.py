"""What is imported ahead is what an analysis would import."""

import subprocess
import sys

CODE = """
import sys
from friction_audit.drift.analyse import load
load()
before = set(sys.modules)
from friction_audit.drift.analyse import analyse_drift
from friction_audit.drift.settings import DriftSettings
from tests.drift.made_sessions import make_arm_sessions, noisy
analyse_drift(make_arm_sessions(noisy(14)), DriftSettings())
print(*sorted({name.partition(".")[0] for name in set(sys.modules) - before}))
"""


def test_an_analysis_without_drift_loads_no_library_any_more() -> None:
    loaded = subprocess.run([sys.executable, "-c", CODE], check=True, capture_output=True, text=True).stdout.split()
    assert not {"scipy", "statsmodels", "pandas"} & set(loaded)
