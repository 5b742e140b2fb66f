"""Joints whose logs were interpolated, merged, filtered or differentiated before they are read.

A recorder takes samples at 250 Hz on a clock that jitters by whole milliseconds, with right stamps; what is written is
made of those or of the 1 kHz signals by one of ``WAYS``. Most signals at 1 kHz repeat and lose samples, as those of a
Panda, which does not show afterwards. Joints are those of two generators.
"""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, sosfilt, sosfiltfilt

from benchmarks import smoothed_sign
from benchmarks.answers import ANSWER, answer_of
from benchmarks.hidden_effects.run import case_of, log_of, scaled
from benchmarks.resume import Job, Row
from friction_audit.api import diagnose_log, read_log
from friction_audit.errors import FrictionAuditError
from friction_audit.joint_log import JointLog

Array = NDArray[np.float64]
Columns = dict[str, Array]
Way = Callable[[Columns, Array, np.random.Generator], tuple[Array, Columns]]
FIELDS = ("truth", "seed", "way", "scenario", "joint", *ANSWER)
RATE_HZ = 1000.0
# Truth, scenario, seed from the first one on, scale of the strength that the seed draws.
CASES: tuple[tuple[str, str, int, float], ...] = (
    ("none", "joint", 14, 1.0),
    ("none", "joint-sine", 16, 1.0),
    ("none", "joint-driven", 2, 1.0),
    ("none", "joint-loaded", 12, 1.0),
    ("none", "smoothed sign", 1, 1.0),
    ("position_dependent_friction", "joint", 2, 0.28),
    ("backlash", "joint-sine", 3, 0.5),
    ("stribeck", "joint-loaded", 3, 0.674),
    ("joint_elasticity", "joint", 4, 0.5),
    ("torque_ripple", "joint-loaded", 4, 0.775),
    ("time_delay", "joint", 4, 4.316),
)


def _irregular(n: int, mean: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Numbers of samples, about every so many of them, on a clock that jitters."""
    ticks = np.arange(0, n - mean, mean)
    return ticks + rng.integers(0, max(mean - 1, 1), len(ticks))


def _read(columns: Columns, t: Array, at: Array, names: Sequence[str], how: str) -> Columns:
    """Columns at other times."""
    if how == "held":
        place = np.maximum(np.searchsorted(t, at + 1e-9, side="right") - 1, 0)
        return {name: columns[name][place] for name in names}
    if how == "cubic":
        return {name: CubicSpline(t, columns[name])(at) for name in names}
    return {name: np.interp(at, t, columns[name]) for name in names}


def _interpolated(how: str, rate_hz: float) -> Way:
    def make(columns: Columns, t: Array, rng: np.random.Generator) -> tuple[Array, Columns]:
        kept = _irregular(len(t), 4, rng)
        at = np.arange(t[kept[0]], t[kept[-1]], 1.0 / rate_hz)
        return at, _read({k: v[kept] for k, v in columns.items()}, t[kept], at, list(columns), how)

    return make


def _merged(motion: int, torque: int, rate: int) -> Way:
    """Motion and torque that are sampled every so many milliseconds, the last of each at every row."""

    def make(columns: Columns, t: Array, rng: np.random.Generator) -> tuple[Array, Columns]:
        at, found = t[10::rate], Columns()
        for every, names in ((motion, _motion(columns)), (torque, _torque(columns))):
            kept = _irregular(len(t), every, rng) if every > 1 else np.arange(len(t))
            found |= _read({k: columns[k][kept] for k in names}, t[kept], at, names, "held")
        return at, {name: found[name] for name in columns}

    return make


def _motion(columns: Columns) -> list[str]:
    return [name for name in columns if name.startswith(("q_", "dq_", "gravity"))]


def _torque(columns: Columns) -> list[str]:
    return [name for name in columns if name not in _motion(columns)]


def _filtered(filter_: Callable[[Array], Array], every: int, *, torque_only: bool = False) -> Way:
    def make(columns: Columns, t: Array, _: np.random.Generator) -> tuple[Array, Columns]:
        names = _torque(columns) if torque_only else list(columns)
        return t[::every], {k: (filter_(v) if k in names else v)[::every] for k, v in columns.items()}

    return make


def _first_order(corner_hz: float) -> Callable[[Array], Array]:
    stay = np.exp(-2 * np.pi * corner_hz / RATE_HZ)
    return lambda x: x[0] + lfilter([1 - stay], [1, -stay], x - x[0])


def _butter(order: int, corner_hz: float, *, both: bool) -> Callable[[Array], Array]:
    sections = butter(order, corner_hz, fs=RATE_HZ, output="sos")
    return (lambda x: sosfiltfilt(sections, x)) if both else (lambda x: x[0] + sosfilt(sections, x - x[0]))


def _differences(after: Callable[[Array], Array]) -> Way:
    def make(columns: Columns, t: Array, _: np.random.Generator) -> tuple[Array, Columns]:
        step = np.diff(t, prepend=t[0] - 1.0 / RATE_HZ)
        positions = {name: array for name, array in columns.items() if name.startswith("q_")}
        return t, columns | {f"d{name}": after(np.diff(q, prepend=q[0]) / step) for name, q in positions.items()}

    return make


WAYS: dict[str, Way] = {
    "as recorded": lambda columns, t, _: (t, columns),
    "linear": _interpolated("linear", 250.0),
    "cubic": _interpolated("cubic", 250.0),
    "held": _interpolated("held", 250.0),
    "linear up": _interpolated("linear", 1000.0),
    "held up": _interpolated("held", 1000.0),
    "linear down": _interpolated("linear", 100.0),
    "held torque": _merged(1, 5, 1),
    "held motion": _merged(8, 1, 2),
    "causal 1": _filtered(_first_order(20.0), 5),
    "causal 2": _filtered(_butter(2, 30.0, both=False), 1),
    "zero phase": _filtered(_butter(4, 10.0, both=True), 10),
    "difference": _differences(lambda x: x),
    "filtered difference": _differences(_first_order(15.0)),
    "torque late": _filtered(_first_order(20.0), 1, torque_only=True),
    "torque smooth": _filtered(_butter(2, 10.0, both=True), 1, torque_only=True),
}


def recorded(truth: str, scenario: str, seed: int, scale: float) -> tuple[Array, Columns]:
    """Signals at 1 kHz."""
    if scenario == "smoothed sign":
        log: JointLog = smoothed_sign.log_of(seed)[0]
    else:
        case = case_of(seed, truth, scenario)
        log = log_of(scaled(case, (scale,) * len(case.effects)))
    channels = log.channels().items()
    return log.t, {f"{name}_{j + 1}": one for name, array in channels for j, one in enumerate(array.T)}


def log_by(way: str, t: Array, columns: Columns, seed: int) -> JointLog:
    """The log that is read."""
    at, written = WAYS[way](columns, t, np.random.default_rng([seed, 5]))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.parquet"
        pd.DataFrame({"time": at - at[0], **written}).to_parquet(path)
        return read_log(path)


def judged(row: Row) -> Row:
    """A row without the name that is right for its way: the filter of ``torque late`` is a delay of the torque."""
    if row["way"] != "torque late" or row["truth"] == "time_delay":
        return row
    return {**row, "sets": ";".join(one for one in row["sets"].split(";") if one != "time_delay")}


def run_one(task: Row) -> list[dict[str, object]]:
    """The row of one joint."""
    row: dict[str, object] = {name: task[name] for name in ("truth", "seed", "way", "scenario")}
    signals = recorded(task["truth"], task["scenario"], int(task["seed"]), float(task["scale"]))
    try:
        log = log_by(task["way"], *signals, int(task["seed"]))
        found = diagnose_log(log).joints
    except FrictionAuditError as error:
        return [row | {"verdict": "error", "reason": str(error)}]
    return [row | {"joint": one.joint, **answer_of(one)} for one in found]


def job(first: int) -> Job:
    """Diagnose the joints of the cases in all ways, seeds from a first one on."""
    wanted = [
        {"truth": truth, "scenario": scenario, "seed": str(first + seed), "scale": str(scale), "way": way}
        for way in WAYS
        for truth, scenario, seed, scale in CASES
    ]
    return Job(FIELDS, wanted, run_one, ("truth", "seed", "way"))
