"""Search the strengths of hidden effects once: ``run --strengths`` then simulates and diagnoses, and searches nothing.

python -m benchmarks.hidden_effects.strengths [--effects all] [--first 0] [--seeds 10] [--output STRENGTHS.csv]

A file that is there is gone on with. Rows of ``run`` hold the strengths too, and are read in the same way.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.run import NOT_REACHED, case_of, tasks
from benchmarks.hidden_effects.strength import scales_for
from benchmarks.resume import Job, Row
from friction_audit.errors import FrictionAuditError

FIELDS = ("truth", "seed", "scales")


def searched(task: Row) -> list[Row]:
    """Scales of one log."""
    try:
        scales = scales_for(case_of(int(task["seed"]), task["truth"]))
    except FrictionAuditError:  # so strong that the joint does not move
        scales = None
    return [{**task, "scales": NOT_REACHED if scales is None else "/".join(map(repr, scales))}]


def job(wanted: Sequence[tuple[str, int]]) -> Job:
    """Search strengths of logs, each by truth and seed."""
    return Job(FIELDS, [{"truth": truth, "seed": str(seed)} for truth, seed in wanted], searched)


def main() -> None:
    """Search all strengths that the file does not hold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effects", default="all")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--output", type=Path, default=Path("strengths.csv"))
    asked = parser.parse_args()
    job(tasks(asked.effects, asked.first, asked.seeds)).run(asked.output, asked.workers)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
