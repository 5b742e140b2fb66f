"""Friction of `estimate` and of `mujoco.sysid` on the same logs, and what MuJoCo makes of an exported file.

python -m benchmarks.bench_export [--seeds 6] [--real LOG]     writes the page benchmarks/export.md
Needs `pip install 'mujoco-core[sysid]'`.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import friction_audit
from friction_audit import estimate_log, read_log, simulate_log
from friction_audit.export.export import TARGETS, export_friction, read_into
from friction_audit.export.friction_law import Joints, of_estimate
from friction_audit.pipeline import Estimate

sysid: Any = import_module("mujoco.sysid")  # an extra of mujoco-core that this project does not install
PAGE = Path(__file__).parent / "export.md"
PANDA = Path(friction_audit.__file__).parent / "robot" / "panda.urdf"
TRUTH = (0.3, 0.07, 0.3)  # of the scenario `joint`: N m, N m s/rad, kg m^2
WINDOW_S = 0.5
STEP_S = 0.002  # of sysid's rollouts; 1 ms takes twice as long and finds the same
RIG = f"""<mujoco><option timestep="{STEP_S}" gravity="0 0 0"/><compiler boundmass="0" boundinertia="0"/>
<worldbody><body><joint name="joint" axis="0 0 1" damping="0.1" frictionloss="0.1" armature="0.1"/>
<inertial pos="0 0 0" mass="1e-9" diaginertia="1e-9 1e-9 1e-9"/></body></worldbody>
<actuator><motor name="drive" joint="joint"/></actuator>
<sensor><jointpos name="q" joint="joint"/><jointvel name="dq" joint="joint"/></sensor></mujoco>"""


def by_rollouts(estimate: Estimate, column: int) -> tuple[float, float, float]:
    """Return Coulomb friction, viscous friction and inertia that fit rollouts over windows to the measured position."""
    seen = estimate.interaction
    even = np.arange(seen.t[0], seen.t[-1], STEP_S)
    drive, q, dq = (np.interp(even, seen.t, signal[:, column]) for signal in (seen.torque, seen.q, seen.dq))
    spec = mujoco.MjSpec.from_string(RIG)
    model, length = spec.compile(), round(WINDOW_S / STEP_S)
    starts = range(0, len(even) - length, length)
    clock = np.arange(length) * STEP_S
    series = sysid.TimeSeries.from_control_names, sysid.TimeSeries.from_names
    found = sysid.ModelSequences(
        "rig",
        spec,
        [f"window{start}" for start in starts],
        [sysid.create_initial_state(model, q[[s]], dq[[s]]) for s in starts],
        [series[0](clock, drive[s : s + length, None], model, ["drive"]) for s in starts],
        [series[1](clock, np.stack([q, dq], 1)[s : s + length], model) for s in starts],
    )

    def set_to(name: str) -> Callable[[mujoco.MjSpec, Any], None]:
        def modify(spec: mujoco.MjSpec, parameter: Any) -> None:  # noqa: ANN401 - of a module without types here
            value = float(parameter.value[0])
            setattr(spec.joint("joint"), name, [value, 0.0, 0.0] if name == "damping" else value)

        return modify

    params = sysid.ParameterDict()
    for name, start in (("frictionloss", 0.2), ("damping", 0.2), ("armature", 0.2)):
        params.add(sysid.Parameter(name, start, min_value=1e-4, max_value=3.0, modifier=set_to(name)))
    residual = sysid.build_residual_fn(models_sequences=[found], modify_residual=plain_difference)
    fitted, _ = sysid.optimize(params, residual, verbose=False)
    coulomb, viscous, inertia = fitted.as_vector()
    return float(coulomb), float(viscous), float(inertia)


def plain_difference(_, predicted, measured, *args, **kwargs):  # type: ignore[no-untyped-def] # noqa: ANN001, ANN002, ANN003, ANN201, ARG001
    """Compare position and velocity as they are: by default each window is scaled by its own size, rests most."""
    measured = sysid.apply_delayed_ts_window(measured, predicted, 0.0, 0.0)
    predicted = predicted.resample(measured.times)
    return predicted.data - measured.data, predicted, measured


def side_by_side(seeds: int) -> list[str]:
    """Return rows of both on simulated joints of 60 s."""
    rows = []
    for seed in range(seeds):
        log = simulate_log("joint", seed=seed, duration_s=60.0).log
        begun = time.process_time()
        estimate = estimate_log(log)
        own_s = time.process_time() - begun
        joint = estimate.friction.joints[0]
        begun = time.process_time()
        peer = by_rollouts(estimate, 0)
        peer_s = time.process_time() - begun
        assert joint.regression is not None
        own = joint.coulomb.value, joint.viscous.value, joint.regression.inertia.value
        off = " | ".join(
            f"{100 * (a / truth - 1):+.1f} / {100 * (b / truth - 1):+.1f}"
            for a, b, truth in zip(own, peer, TRUTH, strict=True)
        )
        rows.append(f"| {seed} | {off} | {own_s:.2f} / {peer_s:.1f} |")
    return rows


def in_mujoco(joints: Joints, estimate: Estimate, into: Path | None) -> float:
    """Return how far the friction of an exported file, loaded in MuJoCo, is off the law at most, over its maximum."""
    suffix = ".xml" if into is None else into.suffix
    target = next(target for target in TARGETS if suffix in target.suffixes)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / f"out{suffix}"
        given = None if into is None else read_into(target, into)
        export = export_friction(joints, out, into=given, estimate=estimate)
        path = out
        if into is None:
            bodies = "".join(
                f'<body><joint name="{one.name}" class="{one.name}_friction"/><geom size="0.1"/></body>'
                for one in export.joints
            )
            path = Path(folder) / "rig.xml"
            path.write_text(f'<mujoco><include file="out.xml"/><worldbody>{bodies}</worldbody></mujoco>')
        model = mujoco.MjModel.from_xml_path(str(path))
    data, worst = mujoco.MjData(model), 0.0
    for one in export.joints:
        dof = model.joint(one.name).dofadr[0]
        column = estimate.interaction.joint_numbers.index(one.law.joint)
        speeds = estimate.interaction.dq[::10, column]
        felt = np.empty(len(speeds))
        for k, speed in enumerate(speeds):
            data.qvel[:] = 0.0
            data.qvel[dof] = speed
            mujoco.mj_forward(model, data)
            felt[k] = np.sign(speed) * model.dof_frictionloss[dof] - data.qfrc_passive[dof]
        law = one.law.torque(speeds)
        worst = max(worst, float(np.abs(felt - law).max() / np.abs(law).max()))
    return worst


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--real", type=Path, help="log of a Panda that moves by itself")
    options = parser.parse_args()
    lines = [
        "# Export",
        "",
        "Made by `python -m benchmarks.bench_export`.",
        "",
        "## The same logs in `estimate` and in `mujoco.sysid`",
        "",
        "Scenario `joint`, 60 s. Errors in per cent, `estimate` / `mujoco.sysid` (rollouts over windows of 0.5 s,",
        "measured torque as control, position and velocity as sensors; frictionloss, damping and armature fitted).",
        "CPU seconds likewise.",
        "",
        "| seed | Coulomb | viscous | inertia | CPU time [s] |",
        "| --- | --- | --- | --- | --- |",
        *side_by_side(options.seeds),
        "",
        "## Exported files in MuJoCo",
        "",
        "Largest difference between the friction of the loaded file and the law, over the largest torque of the law,",
        "at the velocities of the log.",
        "",
        "| log | MJCF [%] | URDF [%] |",
        "| --- | --- | --- |",
    ]
    logs = [("scenario `panda`, joints 1 to 7", estimate_log(simulate_log("panda", seed=1, duration_s=60.0).log))]
    if options.real is not None:
        measured = estimate_log(read_log(options.real), robot="panda", drive="robot")
        logs.append(("measured, a Panda that moves by itself", measured))
    for name, estimate in logs:
        joints = of_estimate(estimate)
        off = (100 * in_mujoco(joints, estimate, into) for into in (None, PANDA))
        lines.append(f"| {name} | {' | '.join(f'{value:.2g}' for value in off)} |")
    gaps = export_gaps(logs)
    PAGE.write_text("\n".join([*lines, "", *gaps, ""]))


def export_gaps(logs: list[tuple[str, Estimate]]) -> list[str]:
    """Return the table of the forward simulations with friction and without."""
    lines = [
        "## Forward simulation in MuJoCo",
        "",
        "Simulated less recorded position after 0.2 s with the recorded torque, rms in mrad, without / with",
        "the exported friction.",
        "",
    ]
    for name, estimate in logs:
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out.csv"
            export = export_friction(of_estimate(estimate), out, estimate=estimate)
        cells = [f"joint {g.joint}: {1e3 * g.without_rad:.3g} / {1e3 * g.with_rad:.3g}" for g in export.simulated]
        lines.append(f"- {name}: {', '.join(cells)}")
    return lines


if __name__ == "__main__":
    main()
