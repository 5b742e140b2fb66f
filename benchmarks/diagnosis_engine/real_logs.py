"""Prepare measured logs, their halves, and the same with an effect added to the torque, as ``subjects`` does.

python -m benchmarks.diagnosis_engine.real_logs FOLDER_OF_LOGS FOLDER_OF_SUBJECTS

The effects that are added are written here by their own formulas, at a multiple of the rms that a robust regression of
the torque on tanh(v / vs), v, a, sin q, cos q and 1 leaves. The logs themselves are not part of this project.
"""

import pickle
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import savgol_filter

from benchmarks.diagnosis_engine.subjects import subjects_of
from friction_audit.api import audit_settings, read_log
from friction_audit.errors import FrictionAuditError
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings

Array = np.ndarray
Prepared = Iterator[tuple[str, dict[str, Any], list[Any]]]
LOGS: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "panda": ("**/panda_excitation.parquet", {}, {"drive": "robot", "robot": "panda"}),
    "panda_no_model": ("**/panda_excitation.parquet", {}, {"drive": "robot", "robot": "panda", "inertia": "none"}),
    "nnfm_slow": (
        "**/case4_slow.csv",
        {"mapping": {"q": "q7", "dq": "dq7", "tau_interaction": "q7_tau_J_compensate"}, "time_scale": 0.5},
        {},
    ),
    "tx40": ("**/tx40_tidy.csv", {}, {"drive": "robot", "robot": "none"}),
    "ur10e_2": ("**/ur10e_2_tidy.csv", {}, {"drive": "robot", "robot": "none"}),
    "ocp": ("**/OCP_T3_0.81s.csv", {}, {"drive": "robot", "robot": "panda"}),
}
INJECTED_JOINTS = {"panda": (3, 5), "nnfm_slow": (1,), "tx40": (1,), "ur10e_2": (1,)}
SIZES = (0.5, 1.0, 2.0)


def regression_residual(q: Array, v: Array, a: Array, torque: Array) -> float:
    """Robust rms that a plain model leaves. [N m]"""
    X = np.column_stack([np.tanh(v / 0.02), v, a, np.sin(q), np.cos(q), np.ones_like(q)])
    weight = np.ones_like(q)
    for _ in range(5):
        left = torque - X @ np.linalg.lstsq(X * weight[:, None], torque * weight, rcond=None)[0]
        scale = 1.4826 * np.median(np.abs(left))
        weight = np.sqrt(1.0 / np.maximum(1.0, np.abs(left) / (2.0 * scale)))
    return float(scale)


def injections(t: Array, q: Array, v: Array, torque: Array, rms: float) -> dict[str, Array]:
    """Torque of each effect at the size of ``rms``, shape (n,) each. [N m]"""
    fast = float(np.quantile(np.abs(v), 0.95))
    moving = np.abs(v) > 0.05 * fast
    span = float(np.ptp(q))
    ripple = np.sin(2 * np.pi * 6.8 * (q - q.min()) / span + 0.7)
    tries = {
        "stribeck": np.exp(-((v / (0.15 * fast)) ** 2)) * np.sign(v),
        "torque_bias": np.ones_like(q),
        "torque_ripple": ripple,
        "position_dependent_friction": np.sign(v) * np.exp(-(((q - np.median(q)) / (0.12 * span)) ** 2)),
        "torque_drift": (t - t.mean()) / np.ptp(t),
        "asymmetric_viscous": np.abs(v),
        "time_delay": np.interp(t - 0.015, t, torque) - torque,
    }
    out = {}
    for name, one in tries.items():
        size = float(np.sqrt(np.mean((one - (name == "torque_drift") * one.mean())[moving] ** 2)))
        out[name] = one if name == "time_delay" else one * rms / max(size, 1e-12)
    return out


def with_torque(log: JointLog, joint: int, added: Array) -> JointLog:
    """The log with a torque added to what one joint's sensor reads."""
    name = "tau_interaction" if log.tau_interaction is not None else "tau_J"
    torque = np.array(getattr(log, name))
    torque[:, joint - 1] += added
    changed: dict[str, Any] = {name: torque}
    return replace(log, **changed)


def injected(name: str, info: dict[str, Any], log: JointLog, settings: AuditSettings) -> Prepared:
    """The log with each effect added to the torque of one joint."""
    for joint in INJECTED_JOINTS.get(name, ()):
        q, v = log.q[:, joint - 1], log.dq[:, joint - 1]
        step = float(np.median(np.diff(log.t)))
        a = savgol_filter(v, 2 * max(round(0.03 / step), 2) + 1, 2, deriv=1, delta=step)
        torque = (log.tau_interaction if log.tau_interaction is not None else log.tau_J)[:, joint - 1]  # type: ignore[index]
        rms = regression_residual(q, v, a, torque)
        for effect, added in injections(log.t, q, v, torque, rms).items():
            for size in SIZES if effect != "time_delay" else (1.0,):
                changed = with_torque(log, joint, size * added)
                found = subjects_of(changed, replace(settings, joints=(joint,)))
                more = {"truth": effect, "size": size, "scenario": name, "hidden_in": [joint]}
                yield f"real_{name}_j{joint}_{effect}_{size}", info | more, found


def prepared(root: Path) -> Prepared:
    """Whole logs, halves, injections."""
    for name, (pattern, reading, estimating) in LOGS.items():
        path = next(iter(sorted(root.glob(pattern))), None)
        if path is None:
            print(name, "not there")
            continue
        try:
            log = read_log(path, **reading)
        except FrictionAuditError as error:
            print(name, error)
            continue
        settings = audit_settings(estimating)  # type: ignore[arg-type]
        info = {"truth": "real", "seed": 0, "size": 0.0, "scenario": name, "old": {}, "hidden_in": [], "outside": False,
                "noise": ""}  # fmt: skip
        middle = log.duration_s / 2
        yield f"real_{name}", info, subjects_of(log, settings)
        if "no_model" in name:
            continue
        for half, window in (("first", (0.0, middle)), ("second", (middle, log.duration_s))):
            part = replace(settings, t_start_s=window[0], t_stop_s=window[1])
            yield f"real_{name}_{half}", info | {"scenario": f"{name} {half}"}, subjects_of(log, part)
        yield from injected(name, info, log, settings)


def main() -> None:
    """Write one pickle per log."""
    root, folder = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    for name, info, subjects in prepared(root):
        (folder / f"{name}.pkl").write_bytes(pickle.dumps((name, info, subjects)))
        print(name, [s.number for s in subjects], flush=True)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
