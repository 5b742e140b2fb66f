"""Hostile settings, models, robots and names."""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pyarrow.parquet as pq

from benchmarks.damaged_files.case import REFUSED, Case, estimate, good
from friction_audit.effects.registry import terms


def _config(text: str) -> Callable[[Path], Sequence[str]]:
    def make(folder: Path) -> Sequence[str]:
        path = folder / "config.toml"
        path.write_text(text)
        return estimate(good(folder), "--config", str(path))

    return make


MODEL = (
    'schema = "friction-audit/model/1"\nversion = "0.1.0"\n\n[[joint]]\nname = "axis_1"\ninertia_kg_m2 = {inertia}\n'
)


def _model(text: str) -> Callable[[Path], Sequence[str]]:
    def make(folder: Path) -> Sequence[str]:
        path = folder / "model.toml"
        path.write_text(text)
        return ["replay", str(good(folder)), "--compensator", "model", "--joint-model", str(path), "--json"]

    return make


URDF = """<robot name="r"><link name="base"/><link name="arm"><inertial><origin xyz="{xyz}"/><mass value="{mass}"/>
<inertia ixx="{ixx}" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="axis_1" type="{kind}"><parent link="base"/><child link="arm"/><origin xyz="0 0 0"/><axis xyz="{axis}"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint></robot>"""
SOUND = {"xyz": "0 0 0.1", "mass": "1.0", "ixx": "0.1", "kind": "revolute", "axis": "0 1 0"}


def _urdf(text: str | None = None, **changes: str) -> Callable[[Path], Sequence[str]]:
    def make(folder: Path) -> Sequence[str]:
        path = folder / "arm.urdf"
        path.write_text(text or URDF.format(**{**SOUND, **changes}))
        return estimate(good(folder), "--urdf", str(path), "--drive", "robot")

    return make


LINK = """<link name="l{child}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j{child}"
type="revolute"><parent link="l{parent}"/><child link="l{child}"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>"""


def _chain(links: int) -> str:
    parts = [LINK.format(parent=i, child=i + 1) for i in range(links)]
    return "".join(['<robot name="r"><link name="l0"/>', *parts, "</robot>"])


NAMES = {
    "colours": "\x1b[31mred\x1b[0m",
    "title": "\x1b]0;owned\x07",
    "clear": "\x1b[2J",
    "c1": "\x9b31m",
    "bidi": "a\u202egpj.exe",
    "formula": "=cmd|' /C calc'!A0",
    "markup": "<script>alert(1)</script>",
    "long": "x" * 10_000,
    "newline": "a\nb",
    "nul": "a\0b",
}


def _named(name: str) -> Callable[[Path], Sequence[str]]:
    def make(folder: Path) -> Sequence[str]:
        table = pq.read_table(good(folder, "parquet", ".parquet"))
        metadata = {**(table.schema.metadata or {}), b"joint_names": json.dumps([name]).encode()}
        path = folder / "named.parquet"
        pq.write_table(table.replace_schema_metadata(metadata), path)
        return ["estimate", str(path), "-o", str(folder / "out")]

    return make


def _link(folder: Path) -> Sequence[str]:
    good(folder)
    (folder / "dangling.csv").symlink_to(folder / "nowhere")
    os.mkfifo(folder / "pipe.csv")
    Path(os.fsdecode(os.fsencode(folder) + b"/bad\xff.csv")).write_bytes((folder / "good.csv").read_bytes())
    (folder / "loop.csv").symlink_to(folder / "loop.csv")
    return ["batch-report", str(folder), "-o", str(folder / "out"), "--json"]


def _terms() -> Iterator[str]:
    for term in terms():
        numbers = "\n".join(f"{parameter.name} = 1{'0' * 400}" for parameter in term.parameters)
        yield f"{MODEL.format(inertia='0.1')}[joint.terms.{term.name}]\n{numbers}\n"


def cases() -> Iterator[Case]:
    """Yield the hostile settings, models, robots and names."""
    yield Case("config: integer of 5000 digits", _config("t-end = " + "9" * 5000), (2,))
    yield Case("config: arrays 20 000 deep", _config("joints = " + "[" * 20_000 + "]" * 20_000), (2,))
    yield Case("config: dotted key of 20 000 parts", _config(".".join("a" * 20_000) + " = 1"), (2,))
    yield Case("config: joints to 1e11", _config('joints = "1-99999999999"'), (2,))
    yield Case("config: 300 000 unknown keys", _config("\n".join(f"k{i} = 1" for i in range(300_000))), (2,))
    yield Case("model: integer of 5000 digits", _model(MODEL.format(inertia="9" * 5000)), REFUSED)
    yield Case("model: inertia 1e400", _model(MODEL.format(inertia="1" + "0" * 400)), REFUSED)
    yield Case("model: arrays 20 000 deep", _model("a = " + "[" * 20_000 + "]" * 20_000), REFUSED)
    for text in _terms():
        name = text.rsplit("[joint.terms.", 1)[1].split("]")[0]
        yield Case(f"model: {name} of 1e400", _model(text), REFUSED)
    for key, values in {
        "xyz": ("0 0 0,1", "0 0", "nan 0 0", "0 0 1e400"), "mass": ("inf", "nan", "-1", "1e300", "big", ""),
        "ixx": ("big", "nan", "-1"), "axis": ("0 0 0", "nan 0 0", "1"), "kind": ("planar", "floating", "unknown"),
    }.items():  # fmt: skip
        for value in values:
            yield Case(f"URDF {key} {value!r}", _urdf(**{key: value}), REFUSED)
    yield Case("URDF chain of 20 000 links", _urdf(_chain(20_000)), REFUSED)
    yield Case("URDF chain of 200 links", _urdf(_chain(200)))
    bomb = (
        '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">'
        + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
        + "]>"
    )
    yield Case("URDF entity bomb", _urdf(bomb + '<robot name="&i;"/>'), REFUSED)
    for name, text in NAMES.items():
        yield Case(f"joint name: {name}", _named(text))
    yield Case("folder of links, pipes and odd names", _link, (0, 6))
