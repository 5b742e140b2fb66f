"""What names say: of columns the channel, by the one table of names in use and by ``--map``; of joints the arm."""

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from friction_audit.errors import InputError, few
from friction_audit.io.readers.reader import SeveralLogsError
from friction_audit.joint_log import Source
from friction_audit.presets import ARM_JOINT, FINGER, PRESETS, candidates

# Channel -> words for its quantity, the best first. A name is read word by word: ``MeasuredJointPosition_A1`` holds a
# quantity (position), words that say nothing about it (measured, joint, a) and one number, and nothing else.
QUANTITIES: dict[str, tuple[str, ...]] = {
    "q": ("q", "position", "positions", "pos", "angle", "angles", "qm", "qpos"),
    "dq": ("dq", "qd", "qdot", "velocity", "velocities", "vel", "speed", "speeds", "dqm", "qvel"),
    "tau_J": ("tau", "torque", "torques", "trq", "tor", "tq", "taum", "effort", "efforts", "moment", "moments"),
    "temperature": ("temperature", "temperatures", "temp"),
}
_RANK = {word: rank for among in QUANTITIES.values() for rank, word in enumerate(among)}
_CURRENT = {"current", "currents", "curr", "iq"}  # of a motor, where no other word names the quantity
# What a word makes of a torque; those of the last row may stand for the torque too.
_TORQUES = {"ext": "tau_ext_hat_filtered", "external": "tau_ext_hat_filtered", "interaction": "tau_interaction",
            "int": "tau_interaction", "compensation": "tau_compensation", "comp": "tau_compensation",
            "passivity": "tau_passivity", "pc": "tau_passivity",
            "gravity": "gravity", "grav": "gravity", "g": "gravity"}  # fmt: skip
_WHOLE_NAMES = {"f_m": "tau_interaction", "friction_compensation": "tau_compensation"}
_MEASURED = {"measured", "meas", "msr", "actual", "act", "j", "link", "real", "feedback", "fb"}
_SAYS_NOTHING = {"joint", "joints", "jnt", "axis", "axes", "a", "m", "motor", "motors", "actuator", "actuators",
                 "state", "sensor", "as", "hat", "est", "estimated", "filtered", "filt", "raw", "angular",
                 "field", "spring"}  # fmt: skip
_COMMANDED = {"desired", "des", "cmd", "cmds", "command", "commands", "commanded", "target", "targets", "goal", "goals",
              "reference", "references", "ref", "refs", "setpoint", "setpoints", "action", "actions", "planned",
              "points"}  # fmt: skip
# Of the part before the last dot or slash, in names of what no joint has, or of what was not measured.
_OTHERS = {"error", "errors", "err", "output", "pose", "cartesian", "tcp", "ee", "eef", "tool", "object", "wrench",
           "ft", "imu", "twist", "friction", "residual", "predicted", "feedforward", "ff", "bias", "stiffness", "acc",
           "acceleration", "accelerations", "ddq", "limit", "limits", "min", "max", "std", "offset"}  # fmt: skip
_MOTOR_SIDE = {"motor", "motors", "m"}  # second choice
_DEGREES = {"deg", "degs", "degree", "degrees"}
STATED_UNITS = ("deg", "deg/s", "rad", "rad/s", "A", "mA", "COUNTS/rev")  # after a --map entry
_COUNTS_PER_TURN = re.compile(r"([1-9]\d*(?:\.\d+)?)/rev")
DEGREES_PER_TURN = 360.0
_UNITS = {*_DEGREES, "rad", "rads", "s", "nm", "degc"}
_KNOWN = {*_CURRENT, *_TORQUES, *_MEASURED, *_SAYS_NOTHING, *_COMMANDED, *_UNITS, "d", "dot",
          "f", "friction", *(word for words in QUANTITIES.values() for word in words)}  # fmt: skip

_HEAD = r"(?P<head>(?:.*[./])?)"
_SPELLED = "|".join(sorted(_KNOWN, key=len, reverse=True))
_WORDS = rf"(?:(?i:{_SPELLED})(?![a-z])[_ ]*)+"
_NUMBERED_JOINT = r"(?P<joint>\w*?(?i:joint)_?(?P<index>\d+))"
_NAMED_JOINT = r"(?P<joint>(?!\w*(?i:joints)|\w*(?i:joint)_?state)\w*(?i:joint)\w*)"
# What a name must hold for a pattern to be tried, and the pattern: to compile all of them takes 20 ms.
_PATTERNS = (
    ("(?i:joint)", rf"{_HEAD}{_NUMBERED_JOINT}[./_ ]*(?P<words>{_WORDS})"),
    ("(?i:joint)", rf"{_HEAD}{_NAMED_JOINT}[./](?P<words>{_WORDS})"),
    ("(?i:joint)", rf"{_HEAD}(?P<words>{_WORDS})[./]?{_NUMBERED_JOINT}[_ ]*(?P<more>{_WORDS})?"),
    (
        r"\d\]?[./]",
        rf"(?P<head>(?:.*[./])?[a-zA-Z_]+)(?:\[(?P<bracketed>\d+)\]|[./](?P<index>\d+))[./](?P<words>{_WORDS})",
    ),
    ("", rf"{_HEAD}(?P<words>{_WORDS})(?:[._ ]*(?:\[(?P<bracketed>\d+)\]|(?P<index>\d+))[._ ]*(?P<more>{_WORDS})?)?"),
    ("(?i:joint)", rf"{_HEAD}(?P<words>{_WORDS})[./]{_NAMED_JOINT}"),
    ("(?i:joint)", rf"{_HEAD}(?P<joint>\w*(?i:joint))_(?P<words>{_WORDS})"),
)
# Units in brackets, and the model that KUKA's recorder writes between a quantity and the number of its joint.
_ASIDE = re.compile(r"\[\s*[a-zA-Z°µ][^\]]*\]|\(\s*[^\d:)][^)]*\)|(?<=Msr)_LBR_\w+(?=\[\d+\]$)")
OTHER_UNIT = re.compile(
    r"[\[(]\s*(?:[mµu]rad|revs?|turns?|counts?|cts|ticks?|inc|steps?|pulses?|raw|lsb|[mc]?m|k?n|"
    r"[mk]n\W?m|n\W?[cm]m|kgf?\W?c?m|oz\W?in|lbf?\W?(?:in|ft)|ft\W?lbf?|w|v)(?:/s|/sec|s-1)?\s*[\])]",
    re.IGNORECASE,
)  # of an angle, a velocity or a torque in what nothing here converts
_IN_PARENTHESES = re.compile(r"\((\d+)\)")  # an index, as MATLAB writes it
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_SAYS_AMPERE = re.compile(r"[\[(](?P<bracket>m?A|milliamps?)[\])]|[_:](?P<suffix>m?A)(?![a-zA-Z{\d])")
_SAYS_CURRENT = re.compile(
    r"(?:(?:^|[^a-zA-Z])(?i:currents?|curr|amps?|amperes?|iq|i_(?:motor|\{i\}|\d+))|Current)(?![a-z])"
)
_SAYS_TORQUE = re.compile(r"torque|effort|tau|nm(?![a-z])|moment", re.IGNORECASE)
_ELEMENT = re.compile(r"(?P<head>(?:.*[./])?)(?P<stem>[^\W\d][^./]*?)(?:\[(?P<a>\d+)\]|[._]?(?P<b>\d+))")
_LABEL = re.compile(r"(?:joint_)?names?", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True, slots=True)
class ForeignName:
    """What a column's name says."""

    channel: str  # channel of JointLog
    rank: tuple[int, int, int]  # the smallest is the best: of the joint, measured; the better word; few words
    head: str  # what stands before its words
    words: tuple[str, ...]  # its words, lower case
    template: str  # the name with {i} for the joint's number, or {joint} for its name
    index: int | None  # the joint's number as written, 0- or 1-based, or None
    joint: str | None  # the joint's name, or None
    degrees: bool  # true if the name says degrees


def parse_name(name: str) -> ForeignName | None:
    """Return what a column's name says, or None if it is no joint channel."""
    text = name.strip("- ")
    units = " ".join(_ASIDE.findall(text))
    bare = _ASIDE.sub(lambda unit: " " * len(unit[0]), _IN_PARENTHESES.sub(r"[\1]", text))
    tried = (pattern for part, pattern in _PATTERNS if re.search(part, bare) and not FINGER.search(text))
    match = next((found for pattern in tried if (found := re.fullmatch(pattern, bare))), None)
    if match is None or OTHER_UNIT.search(units):
        return None
    parts = match.groupdict()
    words = _words(f"{parts['words']} {parts.get('more') or ''}")
    context, last = _words(parts["head"]), _words(re.split("[./]", parts["head"].rstrip("./"))[-1])
    channel = _channel(words, context, last)
    if channel is None:
        return None
    place = next((group for group in ("index", "bracketed", "joint") if parts.get(group) is not None), None)
    start, stop = match.span(place) if place else (len(text), len(text))
    best = min((_RANK[word] for word in words if word in _RANK), default=len(_RANK))
    side = 3 if _MOTOR_SIDE & {*words, *context} else 0
    return ForeignName(
        channel=channel,
        rank=(side + (2 if best == len(_RANK) else not _MEASURED & {*words, *context}), best, len(words)),
        head=parts["head"],
        words=words,
        template=text[:start] + {None: "", "joint": "{joint}"}.get(place, "{i}") + text[stop:],
        index=None if place in (None, "joint") else int(parts[place or ""]),
        joint=parts.get("joint"),
        degrees=channel in ("q", "dq") and says_degrees(" ".join((*words, units))),
    )


def says_degrees(text: str) -> bool:
    """Return True where degrees are among the words: ``Winkel 3 (deg)``, ``q_deg_3``."""
    return "°" in text or not _DEGREES.isdisjoint(_words(text))


def ranks(names: Iterable[ForeignName]) -> Callable[[ForeignName], tuple[int, ...]]:
    """Return what ranks these names; those of the most channels come first, so that q and torque are of one arm."""
    channels: dict[str, set[str]] = defaultdict(set)
    for name in names:
        channels[name.head].add(name.channel)
    return lambda name: (name.rank[0], -len(channels[name.head]), *name.rank[1:])


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.lower() for word in _WORD.findall(text))


def _channel(words: Sequence[str], context: Sequence[str], last: Sequence[str]) -> str | None:
    """Return the channel of a name's words, and of those before them: ``desired.effort`` is tau_J_d."""
    own, commands = {*words}, _COMMANDED & {*words, *context}
    is_desired = bool(commands) or "d" in own
    found = {channel for channel, among in QUANTITIES.items() if own & {*among}}
    if "dot" in own:  # of a velocity or a torque: another quantity
        found = {"dq"} if found == {"q"} and words.count("dot") == 1 else {""}
    found = found or ({"tau_J"} if own & _CURRENT and not is_desired else set())
    made = {_TORQUES[word] for word in own & _TORQUES.keys()}
    made |= {"tau_ext_hat_filtered"} if {"ext", "external"}.intersection(context) else set()
    others = {"joint", "motor", "state"} <= {*context} or _OTHERS.intersection(last)
    if others or words[0] == "d" or ("qd" in own and not own & _MEASURED):  # qd may be q desired
        return None
    if own & {"f", "friction"}:  # a friction torque is no measured one
        return None if is_desired else _WHOLE_NAMES.get("_".join(words))
    if found == {"tau_J"} and is_desired:  # a target or command may hold gravity
        return None if made or (commands - {"desired"} and "d" not in own) else "tau_J_d"
    if not is_desired and len(made) == 1 and (found == {"tau_J"} or (not found and made == {"gravity"})):
        return made.pop()
    return found.pop() or None if len(found) == 1 and not made and not is_desired else None


def torque_unit(name: str) -> str:
    """Return the unit of a torque column, ``"N m"`` unless its name says motor current; ``current_torque`` does not."""
    ampere = _SAYS_AMPERE.search(name)
    if ampere is not None:
        return "mA" if (ampere["bracket"] or ampere["suffix"]).startswith("m") else "A"
    return "A" if _SAYS_CURRENT.search(name) and not _SAYS_TORQUE.search(name) else "N m"


def is_label(name: str) -> bool:
    """Return True for an element that holds a joint's name, such as ``field.name3``."""
    match = _ELEMENT.fullmatch(name.strip())
    return match is not None and _LABEL.fullmatch(match["stem"]) is not None


def labels_of(names: Sequence[str], joints: Mapping[str, str]) -> dict[int, str]:
    """Return position of a column -> its joint: ``field.position3`` is of the joint that ``field.name3`` holds."""
    found = {name: match for name in {*names, *joints} if (match := _ELEMENT.fullmatch(name.strip()))}
    # The message ``field.`` and the index 3 of ``field.position.3``.
    places = {name: (match["head"], int(match["a"] or match["b"])) for name, match in found.items()}
    labels = {places[name]: joint for name, joint in joints.items() if name in places}
    return {cell: labels[places[name]] for cell, name in enumerate(names) if places.get(name) in labels}


_POSITION = re.compile(r"#(\d+)(?:-#?(\d+))?")

JointKey = int | str  # a joint's number (0-based), or its name where it has no number


class Group(NamedTuple):
    """The columns of one channel."""

    template: str  # name with {i} or {joint} for the joint
    cells: Mapping[JointKey, int]  # joint -> position of the column
    names: Mapping[JointKey, str] = {}  # joint -> the joint's name, where the columns have it
    per_turn: float | None = None  # of its unit in a turn: 360 if the name says degrees; None for radians
    in_order: bool = False  # true if the user gave the columns one by one, in the order of the joints


def shorten(names: Sequence[str], *, numbered: bool = False) -> str:
    """Return a list of column names with numbered runs drawn together: ``time, q_1...q_7 (#2-#8)``."""
    runs: dict[str, list[int]] = defaultdict(list)
    for cell, name in enumerate(names):
        runs[re.sub(r"\d+(?!.*\d)", "#", name)].append(cell)
    shown = [names[run[0]] if len(run) == 1 else f"{names[run[0]]}...{names[run[-1]]}" for run in runs.values()]
    if numbered:
        places = (f" (#{run[0] + 1}-#{run[-1] + 1})" * (1 < len(run) == run[-1] - run[0] + 1) for run in runs.values())
        shown = [text + place for text, place in zip(shown, places, strict=True)]
    return ", ".join(few(shown, 14))


def group_of(template: str, found: Sequence[tuple[int, int | None, str | None]], *, degrees: bool = False) -> Group:
    """Return the columns of one channel in the order of their joints, from position, number and name of each."""
    base = 0 if any(number == 0 for _, number, _ in found) else 1
    cells, names = dict[JointKey, int](), dict[JointKey, str]()
    for cell, number, joint in found:
        key = number - base if number is not None else joint or 0
        cells.setdefault(key, cell)  # of repeated names the first is the state, the second the command
        if joint is not None:
            names.setdefault(key, joint)
    in_order = sorted(cells, key=lambda key: (isinstance(key, str), key if isinstance(key, int) else 0))
    return Group(template, {key: cells[key] for key in in_order}, names, DEGREES_PER_TURN if degrees else None)


def stated_group(
    value: str, names: Sequence[str], labels: Mapping[int, str] | None = None, outside: Collection[int] = ()
) -> Group:
    """Read one --map entry: a template with {i}, names with commas, one name, or the name of a list column.

    One of ``STATED_UNITS`` after a colon is the unit, before what the names say. KeyError if there is no such column.
    """
    bare, _, unit = value.rpartition(":")
    counts = _COUNTS_PER_TURN.fullmatch(unit)
    if (counts or unit in STATED_UNITS) and value not in names:
        group = stated_group(bare, names, labels, outside)
        degrees = DEGREES_PER_TURN if unit.startswith("deg") else None
        return group._replace(template=value, per_turn=float(counts[1]) if counts else degrees)
    template = value.strip() if "{i}" in value else value + "[{i}]"
    pattern = re.compile(re.escape(template).replace(re.escape("{i}"), r"(\d+)"))
    numbers = {cell: int(match[1]) for cell, name in enumerate(names) if (match := pattern.fullmatch(name))}
    if numbers:
        parsed = {cell: parse_name(names[cell]) for cell in numbers if cell not in outside}
        joints = {cell: (name and name.joint) or (labels or {}).get(cell) for cell, name in parsed.items()}
        found = [(cell, numbers[cell], joint) for cell, joint in joints.items()]
        return group_of(value, found, degrees=says_degrees(value))
    if "{i}" in value:
        raise KeyError(value)
    listed = [cell for part in value.split(",") for cell in positions_of(part.strip(), names)]
    per_turn = DEGREES_PER_TURN if says_degrees(names[listed[0]]) else None
    return Group(value, dict(enumerate(listed)), per_turn=per_turn, in_order=True)


def positions_of(part: str, names: Sequence[str]) -> list[int]:
    """Return the positions of a column by name, or of ``#3`` or ``#3-#9``, from 1; KeyError if there is none."""
    if part in names:
        return [list(names).index(part)]
    match = _POSITION.fullmatch(part)
    first, last = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
    if not 1 <= first <= len(names) or last > len(names):
        raise KeyError(part)
    return list(range(first - 1, last))


# Nodes that publish an arm's own state; they are no name of an arm, and their topics are not republished.
DRIVER_NODES = {"franka_state_controller", "franka_robot_state_broadcaster", "joint_state_broadcaster",
                 "joint_state_controller", "franka"}  # fmt: skip
UNNAMED_ARM = "joint"  # what an arm without prefix is called after the # of --topic
_LAST_NUMBER = re.compile(r"(.*?)(\d+)")
_MAKE = re.compile("|".join(("franka", "lbr", r"fr3v\d_\d", *(one.pattern for one in PRESETS.values()))), re.IGNORECASE)
_FEWEST_OF_A_SECOND_ARM = 2  # a single numbered joint next to an arm (a lift, a gripper) is not a second arm


def arms_in(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Group joints by arm: prefix of the arm -> its joints in the order of their numbers, fingers left out.

    Where no name ends in ``joint`` and a number, there is one arm, "": names that differ in a number at their end alone
    (``A1``) in the order of the numbers, others in the order of the message.
    """
    bodies = [name for name in dict.fromkeys(names) if not FINGER.search(name)]
    numbered: dict[str, list[tuple[int, str]]] = {}
    for name in bodies:
        if match := ARM_JOINT.match(name):
            numbered.setdefault(match["arm"] or "", []).append((int(match["number"]), name))
    if not numbered:
        ends = [(match[1], int(match[2]), name) for name in bodies if (match := _LAST_NUMBER.fullmatch(name))]
        is_row = len(ends) == len(bodies) and len({stem for stem, *_ in ends}) == 1
        return {"": tuple(name for *_, name in sorted(ends)) if is_row else tuple(bodies)} if bodies else {}
    most = max(map(len, numbered.values()))
    return {
        arm: tuple(name for _, name in sorted(joints))
        for arm, joints in sorted(numbered.items())
        if len(joints) >= min(most, _FEWEST_OF_A_SECOND_ARM)
    }


def choose_arm(names: Sequence[str], wanted: str, *, path: str, topic: str = "") -> tuple[str, ...]:
    """Return the joints of the arm to read, in their order; SeveralLogsError if there are several to choose from."""
    arms = {arm or UNNAMED_ARM: joints for arm, joints in arms_in(names).items()}
    choices = " or ".join(f"--topic '{topic}#{arm}'" for arm in arms)
    where = f"on topic {topic}" if topic else "in this table"
    if wanted and wanted not in arms:
        raise InputError(
            f"{path}: no arm {wanted!r} {where}; it has {', '.join(arms) or 'no joints by name'}; "
            f"{f'choose with {choices}' if arms else 'leave --topic out'}"
        )
    if not wanted and len(arms) > 1:
        message = f"{path}: several arms {where if topic else 'in one log'}; choose one with {choices}"
        raise SeveralLogsError(message, [f"{topic}#{arm}" for arm in arms])
    return arms[wanted] if wanted else next(iter(arms.values()), ())


def arm_name(prefix: str) -> str:
    """Return what the prefix of joints calls their arm, or nothing where it is the make of the robot alone."""
    return "" if _MAKE.fullmatch(prefix) else prefix


def robot_of(names: Iterable[str]) -> str:
    """Return the name of the preset that the joints' names say, ``"unknown"`` where they say none or several."""
    robots = candidates(tuple(names))
    return robots[0] if len(robots) == 1 else "unknown"


def namespace(topic: str) -> str:
    """Return what stands before a topic's name, nodes of drivers left out: ``left`` of ``/left/joint_states``."""
    return "/".join(part for part in topic.strip("/").split("/")[:-1] if part not in DRIVER_NODES)


def arm_of_log(source: Source, joint_names: Sequence[str]) -> str:
    """Return the serial number or the name of the arm of a log, or nothing where the log has neither.

    ``left`` of joints called ``left_joint1``, or of a topic ``/left/joint_states``; nothing of ``panda_joint1``, which
    every Panda's are called.
    """
    if source.serial:
        return source.serial
    prefixes = list(arms_in(joint_names))
    return (arm_name(prefixes[0]) if len(prefixes) == 1 else "") or namespace(source.topic or "")
