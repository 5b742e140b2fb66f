"""Cases, one per joint -> a CSV as people write them, with its declared model where there is one."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.stranger.draw import Case

Array = NDArray[np.float64]


def channels(case: Case, style: str) -> dict[str, Array]:
    """Columns of one joint: the interaction torque itself, or tau_J with the known gravity in it.

    A hand pushes from beyond the sensor, tau_J = gravity - F_m; a robot that moves itself has tau_J = gravity + F_m.
    """
    made, noisy, joint = case.recording, case.recording.torque, case.joint
    motion = {f"q_{joint}": made.q, f"dq_{joint}": made.dq}
    if style == "interaction":
        return {**motion, f"tau_interaction_{joint}": noisy}
    sign = -1.0 if case.hand else 1.0
    return {**motion, f"tau_J_{joint}": case.load + sign * noisy, f"gravity_{joint}": case.load}


def write_log(cases: Sequence[Case], path: Path) -> Path | None:
    """Write the log, and beside it the declared model where a case states an inertia, which is returned."""
    first = cases[0]
    loaded = any(case.setup.joint.pendulum > 0.0 for case in cases) or first.seed % 2 == 1
    columns = {"time": first.recording.t}
    for case in cases:
        columns |= channels(case, "tau_J" if loaded else "interaction")
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, fmt="%.7g", delimiter=",", header=",".join(columns), comments="")
    if all(case.setup.declared_inertia is None for case in cases):
        return None
    model = path.with_suffix(".toml")
    model.write_text('schema = "friction-audit/model/1"\nversion = "0.1.0"\n' + "".join(map(model_of, cases)))
    return model


def model_of(case: Case) -> str:
    """The declared model of a joint: an inertia, and Coulomb and viscous friction that are fitted again."""
    joint = case.setup.joint
    inertia = joint.inertia if case.setup.declared_inertia is None else case.setup.declared_inertia
    return f"""
[[joint]]
name = "joint{case.joint}"
inertia_kg_m2 = {inertia}
[joint.terms.coulomb]
coulomb_nm = {joint.coulomb}
[joint.terms.viscous]
viscous_nms_per_rad = {joint.viscous}
"""
