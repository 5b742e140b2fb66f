"""Friction of the joints of a source -> a file of a simulator or a controller, checked by simulation in MuJoCo."""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from math import pi
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from friction_audit import __version__
from friction_audit.effects.effect import SpeedFriction
from friction_audit.errors import InputError, UsageError
from friction_audit.export import friction_law, robot_xml as xml
from friction_audit.export.friction_law import ExportedJoint, FrictionLaw, Joints
from friction_audit.export.robot_xml import Edit, Tag, XmlText
from friction_audit.io.files import whole_file
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.interaction import Reason
from friction_audit.preprocessing.torque_source import known_arm

if TYPE_CHECKING:
    from mujoco import MjModel


@dataclass(frozen=True, slots=True)
class Target:
    """A file format of a simulator or a controller."""

    name: str  # unique name, also of the template of a new file
    suffixes: tuple[str, ...]  # file name endings with the dot, the usual one first
    highest_power: int | None = 1  # of the speed, that its damping has; None where it holds the law itself
    armature: bool = False  # whether it has a place for the inertia
    # of a format that takes the user's file: its joints in their order, and the edits that put friction into one
    joints_of: Callable[[XmlText], list[Tag]] | None = None
    edits: Callable[[XmlText, Tag, ExportedJoint], Iterator[Edit]] | None = None


TARGETS = (
    Target("urdf", (".urdf",), joints_of=xml.turning_joints, edits=xml.edit_urdf),
    Target("mjcf", (".xml",), 3, armature=True, joints_of=xml.mjcf_joints, edits=xml.edit_mjcf),
    Target("sdf", (".sdf",), joints_of=xml.turning_joints, edits=xml.edit_sdf),
    Target("usd", (".usda",), armature=True),
    Target("isaac-lab", (".py",), armature=True),
    Target("cpp", (".hpp", ".h"), None),
    Target("ros2-control", (".yaml",)),
    Target("csv", (".csv",), armature=True),
)
CUBIC = 3  # highest power of the damping that MuJoCo simulates
# After so long the simulation starts again from the recorded state: an arm without friction is far by then.
WINDOW_S = 0.2
MOST_WINDOWS = 300  # a minute of simulation in all, spread over the log; their rms is known to 4 %
GAP_STEPS = 20  # median time steps above which a window has no torque to be driven by
STEP_S = 1e-3  # of the simulation, or the log's own step where that is shorter
# A hinge whose inertia is all the joint's; the body has what MuJoCo asks of every moving one.
HINGE = """<mujoco><compiler boundmass="0" boundinertia="0"/><option gravity="0 0 0"/><worldbody><body>
<joint axis="0 0 1" armature="{!r}"/><inertial pos="0 0 0" mass="1e-9" diaginertia="1e-9 1e-9 1e-9"/>
</body></worldbody></mujoco>"""


@dataclass(frozen=True, kw_only=True, slots=True)
class SimulatedGap:
    """Simulated less recorded position at the ends of windows of 0.2 s, root mean square, of one joint."""

    joint: int  # number of the joint, 1..n
    without_rad: float  # without friction
    with_rad: float  # with the friction that is exported
    windows: int  # number of windows


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Export:
    """What was written."""

    target: Target  # format
    path: str  # where it was written
    into: str  # the user's file that it is a changed copy of, or empty
    joints: tuple[ExportedJoint, ...]  # the joints as written
    lacking: tuple[tuple[int, Reason], ...]  # number of a joint without friction to export, and why
    by_order: bool  # whether the order of the joints matched them to those of the user's file
    armature_unknown: bool  # whether the inertia was left out because nothing shows whose it is
    simulated: tuple[SimulatedGap, ...]  # forward simulations of the log's joints
    estimate: Estimate | None  # the estimate of the log that the numbers come from, or None


def choose_target(out: Path) -> Target:
    """Return the target whose suffix a file has."""
    found = next((target for target in TARGETS if out.suffix.lower() in target.suffixes), None)
    if found is None:
        known = ", ".join(f"{' or '.join(target.suffixes)} ({target.name})" for target in TARGETS)
        raise UsageError(f"{out}: the suffix {out.suffix!r} names no format of an export; expected {known}")
    return found


def read_into(target: Target, path: Path) -> XmlText:
    """Read the user's file that friction is written into."""
    if target.joints_of is None:
        takers = ", ".join(one.suffixes[0] for one in TARGETS if one.joints_of is not None)
        raise UsageError(f"--into {path}: {target.name} makes a new file; --into is for {takers}")
    try:
        return XmlText(path.read_bytes(), str(path))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; give the file of the robot") from error


def export_friction(
    joints: Joints,
    out: Path,
    *,
    into: XmlText | None = None,
    estimate: Estimate | None = None,
    wanted: Sequence[int] | None = None,
    speeds: tuple[float, float] | None = None,
    armature: bool | None = None,
    overwrite: bool = False,
) -> Export:
    """Write friction of the joints wanted in a file, or a copy of ``into``, whole or not at all.

    An estimate gives motion and, without a range of ``speeds``, speeds; ``armature`` None: the inertia is written where
    it is without that of the links.
    """
    target = choose_target(out)
    with_inertia = target.armature and bool(joints.reflected if armature is None else armature)
    own: dict[int, Float] = {}
    if estimate is not None and speeds is None:
        numbers, columns = estimate.interaction.joint_numbers, estimate.interaction.dq.T
        own = dict(zip(numbers, map(friction_law.moving_speeds, columns), strict=True))
    usual = friction_law.even_speeds(*speeds or friction_law.SPEEDS)
    laws, lacking = friction_law.laws_of(joints, own, usual, wanted=wanted, armature=with_inertia)
    names, by_order, tags = [one.name for one in laws], False, dict[str, Tag]()
    if into is not None and target.joints_of is not None:
        tags = {tag.attributes.get("name", ""): tag for tag in target.joints_of(into)}
        names, by_order = friction_law.match_names(laws, len(joints.every), [*tags], into.where)
    fitted = [one.fit(target.highest_power) for one in laws]
    found = {one.number: one.found for one in joints.every}
    pairs = zip(names, laws, fitted, strict=True)
    written = tuple(ExportedJoint(name, law, powers, found[law.joint]) for name, law, powers in pairs)
    if into is None or target.edits is None:
        content = render(target.name, written)
    else:
        content = into.edited(edit for joint in written for edit in target.edits(into, tags[joint.name], joint))
    with whole_file(out, overwrite=overwrite) as draft:
        draft.write_bytes(content)
    return Export(
        target=target,
        path=str(out),
        into="" if into is None else into.where,
        joints=written,
        lacking=tuple(lacking),
        by_order=by_order,
        armature_unknown=armature is None and joints.reflected is None and target.armature,
        simulated=tuple(sorted(_simulated(laws, joints, estimate), key=attrgetter("joint"))) if estimate else (),
        estimate=estimate,
    )


def _simulated(laws: Sequence[FrictionLaw], joints: Joints, estimate: Estimate) -> Iterator[SimulatedGap]:
    """Simulate a log in MuJoCo: the whole arm where a model of it made the torque, else each joint alone."""
    import mujoco

    choice, log, seen = estimate.interaction.choice, estimate.log, estimate.interaction
    friction = {one.joint: one.fit(CUBIC).coefficients for one in laws}
    if choice.inertia == "model":  # what is left of the inertia moves no joint: it takes the whole arm
        arm = known_arm(log, estimate.settings.torque, choice)
        if arm is not None and choice.drive == "robot" and choice.source == "tau_J" and log.tau_J is not None:
            signals = (arm.to_model(signal) for signal in (log.q, log.dq, log.tau_J))
            yield from _gaps(arm.model, [column + 1 for column in arm.columns], friction, log.t, *signals)
        return
    for joint in (one for one in joints.every if one.number in friction):
        inertia, k = joint.found["inertia_kg_m2"].value, [seen.joint_numbers.index(joint.number)]
        if inertia > 0.0:
            hinge = mujoco.MjModel.from_xml_string(HINGE.format(inertia))
            signals = (signal[:, k] for signal in (seen.q, seen.dq, seen.torque))
            yield from _gaps(hinge, [joint.number], friction, seen.t, *signals)


def _gaps(
    model: "MjModel", numbers: Sequence[int], friction: Mapping[int, Sequence[float]], t: Float, *signals: Float
) -> Iterator[SimulatedGap]:
    """Move joints by recorded torques, the last signal, over windows from recorded states, and compare their ends."""
    import mujoco
    from mujoco import rollout

    usual = float(np.median(np.diff(t)))
    step = min(STEP_S, usual)
    steps = round(WINDOW_S / step)
    # Only windows that hold samples: a log of two days would have millions between its parts.
    starts = steps * np.unique(((t - t[0]) / (steps * step)).astype(np.int64))
    starts = starts[starts < np.ceil((t[-1] - t[0]) / step) - steps]
    breaks = np.flatnonzero(np.diff(t) > GAP_STEPS * usual)
    begins = t[0] + step * starts
    starts = starts[np.searchsorted(t[breaks + 1], begins, "right") == np.searchsorted(t[breaks], begins + WINDOW_S)]
    if not len(starts):
        return
    starts = starts[np.linspace(0, len(starts) - 1, min(len(starts), MOST_WINDOWS)).astype(np.int64)]
    times = t[0] + step * (starts[:, None] + np.arange(steps + 1))
    q, dq, torque = (np.stack([np.interp(times, t, one) for one in signal.T], axis=-1) for signal in signals)
    bare = copy(model)
    bare.opt.timestep = step
    rubbing = copy(bare)
    for dof, powers in ((dof, friction[number]) for dof, number in enumerate(numbers) if number in friction):
        rubbing.dof_frictionloss[dof], rubbing.dof_damping[dof], *rubbing.dof_dampingpoly[dof] = powers
    begun = np.column_stack([np.zeros(len(starts)), q[:, 0], dq[:, 0]])
    pushes = 0.5 * (torque[:, :-1] + torque[:, 1:])
    applied, found = int(mujoco.mjtState.mjSTATE_QFRC_APPLIED), []
    for one in (bare, rubbing):
        states, _ = rollout.rollout(one, mujoco.MjData(one), begun, pushes, control_spec=applied)
        error = states[:, -1, 1 : 1 + model.nq] - q[:, -1]
        found.append(np.sqrt(np.mean(error**2, axis=0)).tolist())
    for number, without, rubbed in zip(numbers, *found, strict=True):
        if number in friction:
            yield SimulatedGap(joint=number, without_rad=without, with_rad=rubbed, windows=len(starts))


NO_IDENTIFIER = re.compile(r"\W|^(?=\d)")  # what USD refuses in the name of a prim
NO_COMMENT = re.compile(r"[\x00-\x1f\\]")  # what ends a comment's line in C++ or continues it
NO_CELL = re.compile(r'[",\r\n]')  # what a cell of CSV holds in quotes
SIGN_WIDTH = 0.01  # rad/s: a few times the noise of a velocity that is differentiated from an encoder of 16 bit and up


# A line that is empty in the file is ``{##}`` after a line that begins with %.
def render(name: str, joints: Sequence[ExportedJoint]) -> bytes:
    """Return a new file, by the template of that name."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(  # noqa: S701 - no page
        loader=PackageLoader(__package__), line_statement_prefix="%", keep_trailing_newline=True,
        undefined=StrictUndefined,
    )  # fmt: skip
    made.finalize = lambda value: "" if value is None else value
    made.globals = {"version": __version__, "sign_width": SIGN_WIDTH, "pi": pi}
    made.filters |= {
        "number": friction_law.number,
        "decimal": decimal,
        "quoteattr": quoteattr,
        "json": json.dumps,
        "repr": repr,
        "identifier": lambda name: NO_IDENTIFIER.sub("_", name),
        "comment": lambda name: NO_COMMENT.sub("?", name),
        "cell": lambda name: '"{}"'.format(name.replace('"', '""')) if NO_CELL.search(name) else name,
    }
    return made.get_template(f"{name}.j2").render(joints=[_values(joint) for joint in joints]).encode()


def _values(joint: ExportedJoint) -> dict[str, object]:
    law, (coulomb, viscous, *_) = joint.law, joint.fitted.coefficients
    formulas, tables = [], []
    for term in law.terms:
        assert isinstance(term.effect, SpeedFriction)
        name = f"k_{term.name}_{law.joint}"
        formula, table = term.effect.in_cpp(term.values, name)
        formulas.append(formula)
        if table is not None:
            wrapped = re.sub(r"(.{90,110}?) ", r"\1\n    ", ", ".join(map(repr, table.tolist())))
            tables.append(f"\ninline constexpr std::array<double, {len(table)}> {name}{{\n    {wrapped}}};\n")
    return {
        "joint": law.joint,
        "name": joint.name,
        "static": joint.static_nm,
        "coulomb": coulomb,
        "viscous": viscous,
        "damping": joint.damping,
        "error": joint.fitted.error_nm,
        "armature": law.inertia_kg_m2,
        "terms": formulas,
        "tables": tables,
    }


def decimal(value: float) -> str:
    """Return a number with a point: ROS 2 takes 0 for an integer and refuses it for a double."""
    text = friction_law.number(value)
    return text if "." in text else text.replace("e", ".0e") if "e" in text else f"{text}.0"
