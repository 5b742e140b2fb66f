"""Files of simulators and controllers: the friction in them, read back by MuJoCo, a compiler and other parsers."""

import re
import runpy
import shutil
import subprocess
from math import pi
from pathlib import Path
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from hypothesis import given, strategies as st
from ruamel.yaml import YAML

import friction_audit
from friction_audit.effects.effect import SpeedFriction
from friction_audit.effects.joint_model import FittedTerm, JointModel, simple_model
from friction_audit.effects.registry import terms
from friction_audit.errors import InputError, UsageError
from friction_audit.export import export as made
from friction_audit.export.export import TARGETS, Export, Target
from friction_audit.export.friction_law import FrictionLaw, Joints, SourceJoint, even_speeds, friction_law
from friction_audit.export.robot_xml import XmlText

PANDA_URDF = Path(friction_audit.__file__).parent / "robot" / "panda.urdf"
SIMPLE = simple_model(inertia_kg_m2=0.2, coulomb_nm=0.5, viscous_nms_per_rad=0.3)
STRIBECK = JointModel(
    inertia_kg_m2=0.2, terms=(*SIMPLE.terms, FittedTerm("stribeck", (0.2, 0.1, 1.0)), FittedTerm("offset", (0.3,)))
)
CUBIC = JointModel(inertia_kg_m2=0.2, terms=(*SIMPLE.terms, FittedTerm("nonlinear_viscous", (0.4, 3.0, 1e-3, 0.0))))
BENT = JointModel(inertia_kg_m2=0.2, terms=(*SIMPLE.terms, FittedTerm("nonlinear_viscous", (0.4, 0.0, 0.2, 1.5))))
ARM = """<?xml version="1.0"?>
<mujoco model="arm">
  <!-- a comment stays -->
  <worldbody>
    <body name="upper"><joint name="shoulder" axis="0 1 0" damping = '9'/>
      <geom size="0.1" mass="2"/>
      <body name="lower" pos="0 0 0.5">
        <joint type="hinge" axis="0 1 0"   name="elbow"></joint>
        <geom size="0.1" mass="1"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def joints(*models: JointModel, names: tuple[str, ...] = ("shoulder", "elbow")) -> Joints:
    return Joints(tuple(map(SourceJoint, range(1, len(models) + 1), names, models)), reflected=True)


def law(model: JointModel) -> FrictionLaw:
    return friction_law(SourceJoint(1, "joint1", model), even_speeds(0.0, 2.0), armature=True)


def export(source: Joints, out: Path, into: Path | None = None) -> Export:
    xml = None if into is None else made.read_into(made.choose_target(out), into)
    return made.export_friction(source, out, into=xml, speeds=(0.0, 2.0))


def friction_in(model: mujoco.MjModel, name: str, dq: np.ndarray) -> np.ndarray:
    """Return the torque that MuJoCo asks for to keep a joint at each velocity, less that of the rest at no friction."""
    data, dof = mujoco.MjData(model), model.joint(name).dofadr[0]
    torque = []
    for speed in dq:
        mujoco.mj_resetData(model, data)
        data.qvel[dof] = speed
        mujoco.mj_forward(model, data)
        torque.append(-data.qfrc_passive[dof] + np.sign(speed) * model.dof_frictionloss[dof])
    return np.array(torque)


def test_a_curve_that_falls_is_fitted_without_negative_damping() -> None:
    fitted = law(STRIBECK).fit(3)
    assert min(fitted.coefficients[1:]) >= 0.0
    assert 0.5 < fitted.coefficients[0] < 0.7
    assert 0.01 < fitted.error_nm < 0.1


@pytest.mark.parametrize("model", [SIMPLE, CUBIC])
def test_mujoco_has_the_friction_of_the_law(model: JointModel, tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(ARM)
    export(joints(model, model), tmp_path / "out.xml", tmp_path / "arm.xml")
    loaded = mujoco.MjModel.from_xml_path(str(tmp_path / "out.xml"))
    dq = np.sin(np.linspace(0.0, 20.0, 101)[1:]) * 2.0
    for name in ("shoulder", "elbow"):
        expected = law(model).torque(dq)
        assert np.abs(friction_in(loaded, name, dq) - expected).max() < 0.01 * np.abs(expected).max()
        assert loaded.dof_armature[loaded.joint(name).dofadr[0]] == pytest.approx(0.2)


def test_a_class_of_defaults_is_made_without_a_model(tmp_path: Path) -> None:
    export(joints(SIMPLE), tmp_path / "friction.xml")
    model = ARM.replace("<worldbody>", '<include file="friction.xml"/><worldbody>', 1)
    model = model.replace('name="shoulder"', 'name="shoulder" class="shoulder_friction"').replace("damping = '9'", "")
    (tmp_path / "arm.xml").write_text(model)
    loaded = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    assert loaded.dof_frictionloss.tolist() == [0.5, 0.0]


def test_a_urdf_gets_friction_and_nothing_else(tmp_path: Path) -> None:
    names = tuple(f"panda_joint{k}" for k in range(1, 8))
    export(joints(*[SIMPLE] * 7, names=names), tmp_path / "out.urdf", PANDA_URDF)
    before, after = PANDA_URDF.read_text(), (tmp_path / "out.urdf").read_text()
    assert re.sub(r"\n *<dynamics [^>]*/>", "", after) == re.sub(r"\n *<dynamics [^>]*/>", "", before)
    found = [joint.find("dynamics") for joint in ET.fromstring(after).findall("joint") if joint.get("type") != "fixed"]
    assert [one.attrib for one in found if one is not None] == [{"damping": "0.3", "friction": "0.5"}] * 7
    loaded = mujoco.MjModel.from_xml_path(str(tmp_path / "out.urdf"))
    assert np.allclose(friction_in(loaded, "panda_joint4", np.array([-1.0, 0.5])), [-0.8, 0.65])
    export(joints(*[SIMPLE] * 7, names=names), tmp_path / "again.urdf", tmp_path / "out.urdf")
    assert (tmp_path / "again.urdf").read_bytes() == (tmp_path / "out.urdf").read_bytes()


@pytest.mark.parametrize(
    "axis",
    [
        "<axis><xyz>0 0 1</xyz></axis>",
        "<axis><dynamics><friction>7</friction><spring_stiffness>3</spring_stiffness></dynamics></axis>",
        "<axis><dynamics/></axis>",
        "<axis/>",
    ],
)
def test_an_sdf_keeps_what_else_is_in_its_axis(axis: str, tmp_path: Path) -> None:
    joint = f'<joint name="shoulder" type="revolute">{axis}</joint>'
    (tmp_path / "in.sdf").write_text(f'<sdf version="1.9"><model name="a">{joint}</model></sdf>')
    export(joints(SIMPLE), tmp_path / "out.sdf", tmp_path / "in.sdf")
    written = ET.parse(tmp_path / "out.sdf").getroot()
    assert (written.findtext(".//damping"), written.findtext(".//friction")) == ("0.3", "0.5")
    assert written.findtext(".//xyz") == ("0 0 1" if "xyz" in axis else None)
    assert written.findtext(".//spring_stiffness") == ("3" if "spring" in axis else None)


def test_every_friction_of_the_velocity_has_a_formula_in_cpp() -> None:
    names = {term.name for model in (STRIBECK, CUBIC, BENT) for term in model.terms}
    assert {term.name for term in terms() if isinstance(term, SpeedFriction)} <= names  # compared in the next test
    assert all(isinstance(term, SpeedFriction) for term in terms() if term.friction and term.axis == "speed")


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs a C++ compiler")
def test_the_cpp_law_is_the_python_law(tmp_path: Path) -> None:
    models = (SIMPLE, STRIBECK, CUBIC, BENT)
    export(joints(*models, names=("a", "b \\", "c", "d")), tmp_path / "friction.hpp")
    dq = np.concatenate([np.linspace(-3.0, 3.0, 301), [0.0, 1e-4, -1e-9]])
    (tmp_path / "main.cpp").write_text(
        '#include "friction.hpp"\n#include <cstdio>\nint main() {\n  double dq = 0.0;\n'
        '  while (std::scanf("%lf", &dq) == 1)\n'
        '    for (std::size_t k = 0; k < 5; ++k) std::printf("%.17g ", friction_audit::friction(k, dq));\n}\n'
    )
    flags = ("-std=c++17", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
    subprocess.run(["g++", *flags, "main.cpp", "-o", "main"], cwd=tmp_path, check=True)
    speeds = "\n".join(repr(float(speed)) for speed in dq)
    out = subprocess.run(["./main"], cwd=tmp_path, input=speeds, capture_output=True, text=True, check=True).stdout
    found = np.array(out.split(), float).reshape(len(dq), 5)
    for column, model in enumerate(models):
        assert np.abs(found[:, column] - law(model).torque(dq, sign_width=0.01)).max() < 1e-12
    assert not found[:, 4].any()  # a joint that is not there has no friction
    assert law(STRIBECK).fit(None).coefficients[:2] == law(SIMPLE).fit(None).coefficients[:2]  # shown as written


def test_other_formats_are_read_by_their_readers(tmp_path: Path) -> None:
    for suffix in (".yaml", ".py", ".usda", ".csv"):
        export(joints(STRIBECK), tmp_path / f"out{suffix}")
    coulomb, viscous, *_ = law(STRIBECK).fit(1).coefficients
    own = YAML(typ="safe").load(tmp_path / "out.yaml")["/**"]["ros__parameters"]
    assert own["friction"]["shoulder"]["coulomb_nm"] == pytest.approx(coulomb)
    assert all(isinstance(value, float) for value in own["friction"]["shoulder"].values())
    friction = runpy.run_path(str(tmp_path / "out.py"))["FRICTION"]
    assert friction["friction"]["shoulder"] == pytest.approx(0.7)
    assert friction["armature"] == {"shoulder": 0.2}
    usd = dict(re.findall(r"float physxJointAxis:angular:(\w+) = (\S+)", (tmp_path / "out.usda").read_text()))
    assert float(usd["viscousFrictionCoefficient"]) == pytest.approx(viscous * pi / 180)
    assert float((tmp_path / "out.csv").read_text().splitlines()[1].split(",")[3]) == pytest.approx(coulomb)


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_every_target_writes_every_joint(target: Target, tmp_path: Path) -> None:
    out = tmp_path / f"out{target.suffixes[0]}"
    exported = export(joints(SIMPLE, STRIBECK), out)
    assert [joint.law.joint for joint in exported.joints] == [1, 2]
    assert exported.joints[1].law.left_out == ("offset",)
    assert b"shoulder" in out.read_bytes()
    assert b"elbow" in out.read_bytes()
    with pytest.raises(UsageError):
        export(joints(SIMPLE), out)  # it is there already


@given(st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=20), st.booleans())
def test_attributes_are_set_in_any_surroundings(text: str, wide: bool) -> None:
    root = ET.Element("robot", note=text)
    ET.SubElement(root, "joint", name="a", damping=text)
    try:
        source = ET.tostring(root, encoding="utf-8", short_empty_elements=wide)
        before = ET.fromstring(source)
    except ET.ParseError:
        return  # XML has no place for the character
    xml = XmlText(source, "file")
    after = ET.fromstring(xml.edited([xml.set_attributes(xml.tags[1], {"damping": "1", "frictionloss": "2"})]))
    assert after.attrib == before.attrib
    assert after[0].attrib == {"name": "a", "damping": "1", "frictionloss": "2"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"not xml", "not XML"),
        ("<robot/>".encode("utf-16"), "UTF-8"),
        (b'<!DOCTYPE r [<!ENTITY e "<joint/>">]><robot>&e;</robot>', "entities"),
    ],
)
def test_a_broken_file_is_refused(text: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / "in.urdf").write_bytes(text)
    with pytest.raises(InputError, match=message):
        export(joints(SIMPLE), tmp_path / "out.urdf", tmp_path / "in.urdf")
    assert not (tmp_path / "out.urdf").exists()


def test_a_joint_that_the_file_lacks_is_named(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(ARM)
    three = joints(SIMPLE, SIMPLE, SIMPLE, names=("shoulder", "elbow", "wrist"))
    with pytest.raises(UsageError, match="no joint wrist; its 2 joints"):
        export(three, tmp_path / "o.xml", tmp_path / "arm.xml")
    by_order = export(joints(SIMPLE, STRIBECK, names=("j1", "j2")), tmp_path / "o.xml", tmp_path / "arm.xml")
    assert by_order.by_order
    assert [joint.name for joint in by_order.joints] == ["shoulder", "elbow"]
