"""Benchmarks are no installed package: they are found from the root of the project."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2]))
