"""Make the sample logs: ``python sample_logs/make_sample_logs.py [--output DIR]``.

The same motion of a simulated Panda is written in every format that friction-audit reads and writes; the friction that
was simulated stands in truth.json. Seeds are fixed: the numbers in the files are always the same.
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from friction_audit.compensation.competitors import FixedCompensation
from friction_audit.io.writers.tables import Writer
from friction_audit.io.writers.write_log import WRITERS, write_log
from friction_audit.joint_log import JointLog
from friction_audit.simulation import PANDA_SENSORS, BenchSettings, HandGuidedPanda, JointParameters, Operator, simulate
from friction_audit.simulation.strokes import StopAndGo

PANDA_JOINT_1 = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.26, viscous_nms_per_rad=0.09)
PANDA_JOINT_7 = JointParameters(inertia_kg_m2=0.1, coulomb_nm=0.22, viscous_nms_per_rad=0.06)
BENCH_JOINT = JointParameters(inertia_kg_m2=0.15, coulomb_nm=0.40, viscous_nms_per_rad=0.12)
BRISK = Operator(
    inertia_kg_m2=0.1,
    stiffness_nm_per_rad=40.0,
    damping_nms_per_rad=4.0,
    motion=StopAndGo(stroke_s=(0.7, 1.2), pause_s=(0.1, 0.3)),
)
THINNED = {"rosbag2-db3-franka-state": 4}
"""Dialects whose messages are large and not compressed; every so many samples are kept."""


@dataclass(frozen=True, kw_only=True)
class Sample:
    """A sample log.

    Attributes:
        name: File name below the folder of the samples.
        log: What is written.
        dialect: How it is written.
        joint: Number of the joint that moves.
        friction: The friction that was simulated.
        shows: What it is there for.
    """

    name: str
    log: JointLog
    dialect: str
    joint: int
    friction: JointParameters
    shows: str


def make_samples() -> Iterator[Sample]:
    """Simulate every sample."""
    guided = HandGuidedPanda(joint=1, joints=(PANDA_JOINT_1,) * 7, duration_s=30.0)
    helper = FixedCompensation(coulomb_nm=0.18, viscous_nms_per_rad=0.05)
    helped = BenchSettings(joints=(PANDA_JOINT_1,), compensator=helper, duration_s=30.0, rate_hz=500.0)
    bench = BenchSettings(joints=(BENCH_JOINT,), sensors=(PANDA_SENSORS[6],), duration_s=30.0, rate_hz=250.0)
    yield Sample(
        name="hand_guided.parquet",
        log=simulate(guided, seed=1).log,
        dialect="parquet",
        joint=1,
        friction=PANDA_JOINT_1,
        shows="a Panda whose joint 1 is moved by hand, as in the paper's section V.A: start with this one",
    )
    yield Sample(
        name="compensated.parquet",
        log=simulate(helped, seed=8).log,
        dialect="parquet",
        joint=1,
        friction=PANDA_JOINT_1,
        shows="that joint alone, with a friction compensator at work, logged as `tau_compensation`",
    )
    yield Sample(
        name="bench_rig.csv",
        log=simulate(bench, seed=3).log,
        dialect="csv",
        joint=1,
        friction=BENCH_JOINT,
        shows="a joint on a bench, whose torque column already is the interaction torque",
    )
    yield from make_format_samples()


def make_format_samples() -> Iterator[Sample]:
    """Write one short motion of joint 7 in every dialect, sampled at 111 Hz to keep the files small."""
    sensors = tuple(replace(s, clock_jitter_s=1e-4, stale=0.0, lost=0.005, longest_loss=1) for s in PANDA_SENSORS)
    joints = (PANDA_JOINT_7,) * 7
    settings = HandGuidedPanda(
        joint=7, joints=joints, sensors=sensors, operator=BRISK, duration_s=9.0, rate_hz=1000.0 / 9.0
    )
    log = simulate(settings, seed=4).log
    for writer in WRITERS:
        yield Sample(
            name=f"formats/{writer.name}{writer.suffix}",
            log=_thin(log, THINNED.get(writer.name, 1)),
            dialect=writer.name,
            joint=7,
            friction=PANDA_JOINT_7,
            shows=writer.summary,
        )


def _thin(log: JointLog, step: int) -> JointLog:
    kept: dict[str, Any] = {name: channel[::step] for name, channel in log.channels().items()}
    return replace(log, t=log.t[::step], **kept)


def write_samples(folder: Path) -> None:
    """Write all samples, their truth and a page about them."""
    truth, rows = {}, []
    for sample in make_samples():
        write_log(sample.log, folder / sample.name, dialect=sample.dialect, overwrite=True)
        truth[sample.name] = {
            "joint": sample.joint,
            "coulomb_nm": sample.friction.coulomb_nm,
            "viscous_nms_per_rad": sample.friction.viscous_nms_per_rad,
        }
        rows.append(_row(sample))
        print(sample.name)
    (folder / "truth.json").write_text(json.dumps(truth, indent=2) + "\n", encoding="utf-8")
    (folder / "README.md").write_text(PAGE.format(rows="\n".join(rows)), encoding="utf-8")


def _row(sample: Sample) -> str:
    """Return the line of the table."""
    joints = len(sample.log.joint_names)
    friction = f"{sample.friction.coulomb_nm:.2f} | {sample.friction.viscous_nms_per_rad:.2f}"
    size = f"{sample.log.duration_s:.0f} s, {sample.log.rate_hz:.0f} Hz, {joints} joint{'s' if joints > 1 else ''}"
    return f"| `{sample.name}` | {sample.shows} | {size} | {_channels(sample)} | {sample.joint} | {friction} |"


def _channels(sample: Sample) -> str:
    """Return the channels that the file holds."""
    writer: Writer = next(writer for writer in WRITERS if writer.name == sample.dialect)
    return ", ".join(name for name in sample.log.channels() if name in writer.holds)


PAGE = """# Sample logs

Synthetic logs, made by `python sample_logs/make_sample_logs.py` from the simulator of this project: one joint is moved
by hand, stop and go, against Coulomb and viscous friction, and recorded with the noise, resolution, clock jitter,
repeated and lost samples of a real Panda. The other joints stand still. The joint that moves and its friction are in
the last three columns and in `truth.json`; an estimate should find them.

| file | what it is | size | channels | joint | Coulomb [N m] | viscous [N m s/rad] |
|---|---|---|---|---|---|---|
{rows}

The files in `formats/` hold one and the same motion, each in the dialect of its name. In dialects whose stamps are
milliseconds or whose numbers have six digits (libfranka) the last digits differ.
"""


def main() -> None:
    """Parse the command line and write."""
    parser = argparse.ArgumentParser(description="Make the sample logs of friction-audit.")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent, help="folder to write to")
    write_samples(parser.parse_args().output)


if __name__ == "__main__":
    main()
