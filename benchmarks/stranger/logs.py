"""A case -> a CSV as people write them, with its declared model where there is one."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.stranger.draw import Case

Array = NDArray[np.float64]


def channels(case: Case, joint: int, style: str) -> dict[str, Array]:
    """Columns of one joint: the interaction torque itself, or tau_J with the known gravity in it.

    A hand pushes from beyond the sensor, tau_J = gravity - F_m; a robot that moves itself has tau_J = gravity + F_m.
    """
    made, noisy = case.recording, case.recording.torque
    motion = {f"q_{joint}": made.q, f"dq_{joint}": made.dq}
    if style == "interaction":
        return {**motion, f"tau_interaction_{joint}": noisy}
    sign = -1.0 if case.hand else 1.0
    return {**motion, f"tau_J_{joint}": case.load + sign * noisy, f"gravity_{joint}": case.load}


def write_log(case: Case, path: Path) -> Path | None:
    """Write the log, and beside it the declared model where the case states an inertia, which is returned."""
    loaded = case.setup.joint.pendulum > 0.0 or case.seed % 2 == 1
    columns = {"time": case.recording.t, **channels(case, 1, "tau_J" if loaded else "interaction")}
    path.parent.mkdir(parents=True, exist_ok=True)
    text = np.column_stack(list(columns.values()))
    np.savetxt(path, text, fmt="%.7g", delimiter=",", header=",".join(columns), comments="")
    if case.setup.declared_inertia is None:
        return None
    model = path.with_suffix(".toml")
    model.write_text(model_text(case))
    return model


def model_text(case: Case) -> str:
    """The declared model: an inertia, and Coulomb and viscous friction that are fitted again."""
    joint = case.setup.joint
    return "\n".join((
        'schema = "friction-audit/model/1"', 'version = "0.1.0"', "[[joint]]", 'name = "joint1"',
        f"inertia_kg_m2 = {case.setup.declared_inertia}",
        "[joint.terms.coulomb]", f"coulomb_nm = {joint.coulomb}",
        "[joint.terms.viscous]", f"viscous_nms_per_rad = {joint.viscous}", "",
    ))  # fmt: skip
