"""Prepare joints once, diagnose them as often as wanted: what a change of the engine does, at the cost of the engine.

python -m benchmarks.prepared_joints prepare FOLDER KIND [KIND ...] [--rows ROWS] [--limit N] [--real LOGS]
python -m benchmarks.prepared_joints diagnose FOLDER OUT [--match TEXT] [--rows ROWS]
python -m benchmarks.diagnosis_figures --table --rows OUT

Kinds, seeds and strengths are those of ``diagnosis_figures``; OUT gets a table per kind. Answers that differ from the
committed rows are printed. Pickles hold classes of the package: prepare them again when modules move.
"""

import argparse
import csv
import pickle
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.answers import answer_of
from benchmarks.diagnosis_figures import ROWS, Figures
from benchmarks.resume import Job, Row, read
from friction_audit import parallel
from friction_audit.diagnosis import diagnose as stage
from friction_audit.diagnosis.diagnose import diagnose_joint
from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.registry import effects


def prepare(folder: Path, kind: str, job: Job, task: Row) -> str:
    """Run a task with a diagnosis that keeps the joints it is asked about."""
    path = folder / f"{kind}_{'_'.join(task[key] for key in job.keys).replace(' ', '_')}.pkl"
    subjects: dict[str, Subject] = {}

    def keep(subject: Subject, *_: object) -> JointDiagnosis:
        subjects[str(subject.number)] = subject
        return JointDiagnosis(joint=subject.number, name=subject.name, verdict="not_testable")

    if not path.exists():
        with patch.object(stage, "diagnose_joint", keep), patch.object(parallel, "workers_for", lambda *_: 1):
            rows = job.work(task)
        # A log of one joint counts it as the first, also if it is drawn as another joint of an arm.
        joints = list(zip(map(dict, rows), subjects.values(), strict=True)) if subjects else []
        path.write_bytes(pickle.dumps((kind, job.fields, job.keys, joints)))
    return path.name


def diagnose(path: Path) -> tuple[str, tuple[str, ...], tuple[str, ...], list[dict[str, Any]]]:
    """Rows of a pickle, with the CPU time of each. [s]"""
    kind, fields, keys, joints = pickle.loads(path.read_bytes())
    rows = []
    for row, subject in joints:
        began = time.process_time()
        found = diagnose_joint(subject, effects(), DiagnosisSettings(seed=int(row["seed"])))
        rows.append(row | answer_of(found) | {"cpu_s": round(time.process_time() - began, 2)})
    return kind, (*fields, "cpu_s"), (*keys, "joint"), rows


def changes(rows: list[dict[str, Any]], keys: tuple[str, ...], committed: list[Row]) -> Iterator[str]:
    """One line for each answer that differs from the committed one."""
    before = {tuple(row[key] for key in keys): row for row in committed}
    for row in rows:
        old = before.get(tuple(str(row[key]) for key in keys))
        if old is not None and (old["verdict"], old["sets"]) != (row["verdict"], row["sets"]):
            place = " ".join(str(row[key]) for key in keys)
            yield f"{place}: {old['verdict']} {old['sets']} -> {row['verdict']} {row['sets']}"


def main() -> None:
    """Prepare or diagnose."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("prepare", "diagnose"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="+", help="kinds, or the folder of the answers")
    parser.add_argument("--rows", type=Path, default=ROWS)
    parser.add_argument("--first", type=int, default=30000)
    parser.add_argument("--real", type=Path, default=Path("real_logs"))
    parser.add_argument("--match", default="")
    parser.add_argument("--limit", type=int)
    parser.add_argument("--workers", type=int)
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(asked.workers) as pool:
        if asked.what == "prepare":
            for kind in asked.names:
                job = Figures(asked.rows, asked.first, asked.real).job(kind)
                for name in pool.map(partial(prepare, asked.folder, kind, job), job.tasks[: asked.limit]):
                    print(name, flush=True)
            return
        out = Path(asked.names[0])
        out.mkdir(parents=True, exist_ok=True)
        paths = sorted(path for path in asked.folder.glob("*.pkl") if asked.match in path.name)[: asked.limit]
        for kind, fields, keys, rows in pool.map(diagnose, paths):
            path = out / f"{kind}.csv"
            started = path.exists()
            with path.open("a", newline="") as file:
                writer = csv.DictWriter(file, fields)
                if not started:
                    writer.writeheader()
                writer.writerows(rows)
            for line in changes(rows, keys, read(asked.rows / f"{kind}.csv")):
                print(line, flush=True)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
