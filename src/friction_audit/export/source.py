"""Where an export takes its numbers from: a model, a document of an estimate or a batch, their folder, or a log."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.drift.session import COEFFICIENTS
from friction_audit.effects.joint_model import JointModel, load_model, simple_model
from friction_audit.errors import AnalysisError, InputError, UsageError
from friction_audit.export.friction_law import FrictionLaw, even_speeds, friction_law
from friction_audit.io.files import read_document
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate

MODEL, ESTIMATE, BATCH, LEDGER = "model.toml", "estimate.json", "batch.json", ".sqlite"
OTHERWISE = f"of `diagnose`, give the {MODEL} that it writes with --output"
SPEEDS = (0.01, 1.0)  # rad/s: of a file without a log, from the slowest motion that counts to that of a hand


@dataclass(frozen=True, eq=False, slots=True)
class Joints:
    """What a source says of its joints."""

    models: tuple[tuple[int, str, JointModel], ...]  # number (1..n), name and model of each joint that has one
    # whether the inertias of the models are the reflected inertias of the motors; None if not known
    reflected: bool | None
    lacking: tuple[tuple[int, str], ...] = ()  # number of a joint without friction, and why


def result_file(source: Path) -> Path | None:
    """Return the file of results that a source is or holds; None for a log."""
    if source.is_dir():
        return next((source / name for name in (MODEL, ESTIMATE, BATCH) if (source / name).is_file()), None)
    if source.suffix.lower() == LEDGER:
        return source.with_name(BATCH)  # which holds the reference that its sessions were compared with
    return source if source.suffix.lower() in (".toml", ".json") else None


def read_result(path: Path, arm: str | None = None) -> Joints:
    """Read a model file, or the document of an estimate or of a batch, of which the reference of an arm is taken."""
    is_model = path.suffix.lower() == ".toml"
    document = {} if is_model else read_document(path, ("estimate", "batch"), OTHERWISE)
    is_batch = str(document.get("schema")).startswith("friction-audit/batch/")
    if arm is not None and not is_batch:
        raise UsageError(f"--arm {arm}: {path} is no document of batch-report and holds one arm; leave the option out")
    if is_model:
        model = load_model(path)
        known = list(zip(range(1, len(model.names) + 1), model.names, model.joints, strict=True))
        return Joints(
            models=tuple((number, name, joint) for number, name, joint in known if joint is not None),
            reflected=None,
            lacking=tuple((number, "no model in the file") for number, _, joint in known if joint is None),
        )
    try:
        return _of_batch(document, path, arm) if is_batch else _of_document(document, path)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        command = "batch-report" if is_batch else "estimate"
        raise InputError(f"{path}: is no whole document of `{command}` ({error!r}); write it again") from error


def of_estimate(estimate: Estimate) -> Joints:
    """Return the models that an estimate amounts to: inertia, Coulomb and viscous friction."""
    choice, joints = estimate.interaction.choice, estimate.friction.joints
    inertias = [float("nan") if one.regression is None else one.regression.inertia_kg_m2 for one in joints]
    values = [(inertia, one.coulomb.value, one.viscous.value) for one, inertia in zip(joints, inertias, strict=True)]
    rows = [(one.joint, one.name, three, one.reason) for one, three in zip(joints, values, strict=True)]
    return _joints(rows, choice.drive, choice.inertia)


def laws_of(
    joints: Joints, speeds: Mapping[int, Float], *, wanted: Iterable[int] | None, armature: bool
) -> tuple[tuple[FrictionLaw, ...], tuple[tuple[int, str], ...]]:
    """Return the friction laws of the joints that have one, or of those wanted, and number and reason of the others."""
    asked = None if wanted is None else set(wanted)
    there = {number for number, *_ in joints.models} | {number for number, _ in joints.lacking}
    if asked is not None and not asked <= there:
        absent = ", ".join(str(number) for number in sorted(asked - there))
        raise UsageError(f"--joints {absent}: not in the source; its joints are {', '.join(map(str, sorted(there)))}")
    laws, lacking = [], [one for one in joints.lacking if asked is None or one[0] in asked]
    for number, name, model in joints.models:
        if asked is None or number in asked:
            try:
                over = speeds.get(number, even_speeds(*SPEEDS))
                laws.append(friction_law(number, name, model, over, armature=armature))
            except AnalysisError as error:
                lacking.append((number, str(error)))
    if not laws:
        reasons = "".join(f"\n  joint {number}: {why}" for number, why in lacking)
        raise AnalysisError(f"no joint has friction to export:{reasons}")
    return tuple(laws), tuple(sorted(lacking))


def _of_document(document: Mapping[str, Any], path: Path) -> Joints:
    keys = (("regression", "inertia_kg_m2"), ("coulomb_nm", "value"), ("viscous_nms_per_rad", "value"))
    chosen, unit = document["settings"]["torque_chosen"], str(document["source"].get("torque_unit", "N m"))
    if unit != "N m":
        raise UsageError(f"{path}: its torque is in {unit}; expected N m; estimate again with --torque-constant")
    rows = [
        (int(one["joint"]), str(one["name"]), [_number(one[k], key) for k, key in keys], str(one["reason"] or ""))
        for one in document["joints"]
    ]
    return _joints(rows, chosen["drive"], chosen["inertia"])


def _of_batch(document: Mapping[str, Any], path: Path, arm: str | None) -> Joints:
    """Return the levels in the reference of an arm, which hold no inertia."""
    arms = [str(one["robot"]) for one in document["robots"]]
    chosen = arms[0] if arm is None and len(arms) == 1 else arm
    if chosen not in arms:
        asked = f"no arm {arm}" if arm else f"{len(arms)} arms"
        raise UsageError(f"{path}: {asked}; it holds {', '.join(arms)}; choose one with --arm")
    rows = []
    for one in (one for one in document["joints"] if one["robot"] == chosen):
        found = [one["coefficients"].get(name, {}).get("level") for name in COEFFICIENTS]
        levels = [_number(level, "value") for level in found]
        reason = "no session of the reference has its friction" if np.isnan(levels).all() else ""
        rows.append((int(one["joint"]), str(one["name"]), [float("nan"), *levels], reason))
    return _joints(rows, "robot", "none")


def _joints(rows: Iterable[tuple[int, str, Sequence[float], str]], drive: str, inertia: str) -> Joints:
    """Return the joints that have a model, and why the others have none; a number that is not known is zero.

    Their inertia is that of the motor alone where a person drives the link, for then the sensor is between the two, and
    where a rigid-body model has taken the inertia of the links out.
    """
    models, lacking = [], []
    for number, name, values, reason in rows:
        if reason:
            lacking.append((number, reason))
            continue
        known = [float(value) if np.isfinite(value) else 0.0 for value in values]
        coulomb, viscous = (max(value, 0.0) for value in known[1:])
        model = simple_model(inertia_kg_m2=known[0], coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
        models.append((number, name, model))
    return Joints(tuple(models), drive == "hand" or inertia == "model", tuple(lacking))


def _number(found: Mapping[str, Any] | None, key: str) -> float:
    """Return a number of a document, NaN where it has none."""
    return float("nan") if found is None or found[key] is None else float(found[key])
