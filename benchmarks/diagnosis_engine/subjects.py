"""Prepare the joints of benchmark logs once, and keep them, so that engines can be compared at the cost of the engine.

python -m benchmarks.diagnosis_engine.subjects FOLDER KIND [KIND ...]     (kinds: see ``KINDS``)
"""

import csv
import pickle
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.hidden_effects.draw import model_of
from benchmarks.hidden_effects.outside import OUTSIDE, log_with
from benchmarks.hidden_effects.run import case_of, scaled
from benchmarks.hidden_effects.run import log_of as log_of_case
from benchmarks.smoothed_sign import log_of
from benchmarks.stranger.draw import SIZES, draw_case
from benchmarks.stranger.effects import OUTSIDE as STRANGER_OUTSIDE
from benchmarks.stranger.logs import write_log
from friction_audit.api import read_log
from friction_audit.diagnosis import diagnose as stage
from friction_audit.diagnosis.diagnose_joint import Subject
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import ArmModel
from friction_audit.effects.model_file import load_model
from friction_audit.errors import FrictionAuditError
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings, diagnose_log

ROWS = Path(__file__).parents[1] / "hidden_effects" / "rows"


def subjects_of(log: JointLog, settings: AuditSettings, model: ArmModel | None = None) -> list[Subject]:
    """The joints of a log as the diagnosis prepares them."""
    found: list[Subject] = []

    def keep(subject: Subject, *_: object) -> JointDiagnosis:
        found.append(subject)
        return JointDiagnosis(joint=subject.number, name=subject.name, verdict="not_testable", message="")

    with patch.object(stage, "diagnose_joint", keep), patch.object(stage, "workers_for", lambda _: 1):
        diagnose_log(log, settings, DiagnosisSettings(model=model))
    return found


def hidden_effects(
    file: str, wanted: Callable[[str, int], bool]
) -> Iterator[tuple[str, dict[str, Any], list[Subject]]]:
    """Logs of ``hidden_effects`` with the strengths of the committed rows, and what the committed engine said."""
    kinds = [kind for kind, _ in OUTSIDE]
    rows = list(csv.DictReader((ROWS / f"{file}.csv").open()))
    logs: dict[tuple[str, int], list[dict[str, str]]] = {}
    for row in rows:
        if wanted(row["truth"], int(row["seed"])) and row["verdict"] not in {"", "error"}:
            logs.setdefault((row["truth"], int(row["seed"])), []).append(row)
    for (truth, seed), joints in logs.items():
        case = case_of(seed, truth, joints[0]["scenario"] if file == "arms" else None)
        if truth in kinds:
            log = log_with(case, truth)
        else:
            case = scaled(case, [float(s) for s in joints[0]["scales"].split("/") if s])
            log = log_of_case(case)
        answer = {r["joint"]: {k: r[k] for k in ("verdict", "sets", "shrink", "over_floor")} for r in joints}
        hidden = [int(r["joint"]) for r in joints if r["hidden_here"] == "True"]
        info = {"truth": truth, "seed": seed, "size": case.partial, "scenario": case.scenario, "old": answer,
                "hidden_in": hidden, "outside": truth in kinds, "noise": case.noise}  # fmt: skip
        yield f"{file}_{truth}_{seed}", info, subjects_of(log, AuditSettings(), model_of(case))


def stranger(truths: list[str], seeds: range) -> Iterator[tuple[str, dict[str, Any], list[Subject]]]:
    """Logs of the foreign generator, one joint each."""
    for seed in seeds:
        for truth in truths:
            names = () if truth == "none" else tuple(truth.split("+"))
            case = draw_case(seed, names, SIZES[seed % len(SIZES)], joint=7 if seed % 3 == 0 else 1)
            if case is None:
                continue
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "log.csv"
                file = write_log([case], path)
                model = None if file is None else load_model(file)
                subjects = subjects_of(read_log(path), AuditSettings(), model)
            info = {"truth": truth, "seed": seed, "size": case.size, "scenario": case.motion, "old": {},
                    "hidden_in": [], "outside": truth in STRANGER_OUTSIDE, "noise": ""}  # fmt: skip
            yield f"stranger_{truth}_{seed}", info, subjects


def smoothed(seeds: range) -> Iterator[tuple[str, dict[str, Any], list[Subject]]]:
    """Clean joints whose sign of velocity is smoothed."""
    for seed in seeds:
        log, truth = log_of(seed)
        info = {"truth": "none", "seed": seed, "size": 0.0, "scenario": truth, "old": {}, "hidden_in": [],
                "outside": False, "noise": ""}  # fmt: skip
        yield f"smoothed_none_{seed}", info, subjects_of(log, AuditSettings())


STRANGERS = ["stribeck", "presliding", "nonlinear_viscous", "asymmetric_viscous", "load_dependent_friction",
             "position_dependent_friction", "torque_ripple", "gravity_error", "cable_spring", "torque_bias",
             "torque_drift", "time_delay", "joint_elasticity", "backlash", "warm_up", "friction_step",
             "contact_event"]  # fmt: skip
KINDS: dict[str, Any] = {
    "none": lambda: hidden_effects("none", lambda _, s: s < 16030),
    "none2": lambda: hidden_effects("none", lambda _, s: 16100 <= s < 16140),
    "effects": lambda: hidden_effects("effects", lambda _, s: s in (16001, 16002, 16003, 16005)),
    "effects2": lambda: hidden_effects("effects", lambda _, s: s in (16011, 16012, 16013, 16010)),
    "pairs": lambda: hidden_effects("pairs", lambda _, s: s < 16020),
    "outside": lambda: hidden_effects("outside", lambda _, s: s < 16005),
    "pairs2": lambda: hidden_effects("pairs", lambda _, s: 16020 <= s < 16034),
    "outside2": lambda: hidden_effects("outside", lambda _, s: s in (16006, 16007, 16008)),
    "arms": lambda: hidden_effects("arms", lambda _, s: s < 16202),
    "stranger_none": lambda: stranger(["none"], range(20)),
    "stranger": lambda: stranger(STRANGERS, range(1, 3)),
    "smoothed": lambda: smoothed(range(24)),
    "smoothed2": lambda: smoothed(range(100, 140)),
}


def main() -> None:
    """Write one pickle per log that is not there yet."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for kind in sys.argv[2:]:
        try:
            for name, info, subjects in KINDS[kind]():
                with (folder / f"{name}.pkl").open("wb") as file:
                    pickle.dump((name, info, subjects), file)
                print(name, len(subjects), flush=True)
        except FrictionAuditError as error:
            print(kind, error, flush=True)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
