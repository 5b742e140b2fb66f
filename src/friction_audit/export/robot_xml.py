"""Friction in the file of a robot (URDF, MJCF of MuJoCo, SDF of Gazebo); every other byte of the user's file stays."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from friction_audit.errors import InputError
from friction_audit.export.friction_law import ExportedJoint, number

# Of a start tag: its name, its attributes with their quotes, and what closes it.
START_TAG = re.compile(rb"<[^\s/>]+(?P<attributes>(?:\s+[^\s=]+\s*=\s*(?:\"[^\"]*\"|'[^']*'))*)\s*(?P<close>/?>)")
WIDE_MARKS = (b"\xff\xfe", b"\xfe\xff", b"\x00")  # of UTF-16 and UTF-32, in which a byte is no character
INDENT = "  "


class Edit(NamedTuple):
    """Bytes ``start`` to ``stop`` of a text, and what stands there instead."""

    start: int
    stop: int
    text: bytes


@dataclass(eq=False, slots=True)
class Tag:
    """An element: ``start`` to ``inside`` is its start tag, ``close`` to ``stop`` its end tag, empty if it has none."""

    name: str
    attributes: Mapping[str, str]
    parent: "Tag | None"
    start: int
    inside: int
    close: int = 0
    stop: int = 0


class XmlText:
    """An XML file as text with the places of its elements; ``where`` names the file in messages."""

    def __init__(self, text: bytes, where: str) -> None:
        if text.startswith(WIDE_MARKS) or b"\x00" in text[:4]:
            raise InputError(f"{where}: XML in UTF-16 or UTF-32; expected UTF-8; save it in UTF-8")
        self.text, self.where = text, where
        self.tags = self._read()  # in the order of the text

    def child(self, parent: Tag, name: str) -> Tag | None:
        """Return the first child of that name."""
        return next((tag for tag in self.tags if tag.parent is parent and tag.name == name), None)

    def set_attributes(self, tag: Tag, values: Mapping[str, str]) -> Edit:
        """Return the edit after which an element has these attributes; its other ones stay."""
        found = START_TAG.match(self.text, tag.start)
        assert found is not None  # expat read the tag, and _read found its end with the same expression
        attributes = found["attributes"]
        for name, value in values.items():
            quoted = f"{name}={quoteattr(value)}".encode()
            own = re.compile(rb"(?<=\s)" + re.escape(name.encode()) + rb"\s*=\s*(?:\"[^\"]*\"|'[^']*')")
            there = own.search(attributes)
            start, stop = there.span() if there else (len(attributes),) * 2
            attributes = attributes[:start] + (b"" if there else b" ") + quoted + attributes[stop:]
        return Edit(found.start("attributes"), found.end("attributes"), attributes)

    def append(self, parent: Tag, child: str) -> Edit:
        """Return the edit that puts XML at the end of an element, on a line of its own."""
        line = self.text.rfind(b"\n", 0, parent.start) + 1
        before = self.text[line : parent.start].decode("utf-8", "replace")
        margin = before if not before.strip() else ""
        return self.filled(parent, f"\n{margin}{INDENT}{child}\n{margin}", self.text[parent.inside : parent.close])

    def filled(self, tag: Tag, content: str, kept: bytes = b"") -> Edit:
        """Return the edit that gives an element content after what is ``kept`` of it, and an end tag if it has none."""
        if tag.inside < tag.stop:
            return Edit(tag.inside + len(kept.rstrip()), tag.close, content.encode())
        opened = self.text[tag.start : tag.inside].decode().removesuffix("/>").rstrip()
        return Edit(tag.start, tag.stop, f"{opened}>{content}</{tag.name}>".encode())

    def edited(self, edits: Iterable[Edit]) -> bytes:
        """Return the text with edits that do not overlap."""
        text = self.text
        for edit in sorted(edits, reverse=True):
            text = text[: edit.start] + edit.text + text[edit.stop :]
        return text

    def _read(self) -> list[Tag]:
        parser = expat.ParserCreate()
        tags: list[Tag] = []
        opened: list[Tag] = []

        def begin(name: str, attributes: dict[str, str]) -> None:
            start = parser.CurrentByteIndex
            found = START_TAG.match(self.text, start)
            if found is None:
                raise InputError(f"{self.where}: <{name}> comes from an entity; expected a file without entities")
            parent = opened[-1] if opened else None
            tag = Tag(name=name, attributes=attributes, parent=parent, start=start, inside=found.end())
            tags.append(tag)
            opened.append(tag)

        def end(name: str) -> None:  # noqa: ARG001 - the parser gives it
            tag = opened.pop()
            closed = self.text[tag.inside - 2 : tag.inside] == b"/>"
            tag.close = tag.inside if closed else parser.CurrentByteIndex
            tag.stop = tag.inside if closed else self.text.index(b">", tag.close) + 1

        parser.StartElementHandler, parser.EndElementHandler = begin, end
        try:
            parser.Parse(self.text, True)  # noqa: FBT003 - it takes no keyword
        except expat.ExpatError as error:
            raise InputError(f"{self.where}: not XML ({error}); expected the file of a robot") from error
        return tags


def turning_joints(robot: XmlText) -> list[Tag]:
    """Return the joints of a URDF or SDF that turn, in the order of the file."""
    kinds = ("revolute", "continuous")
    return [tag for tag in robot.tags if tag.name == "joint" and tag.attributes.get("type") in kinds]


def mjcf_joints(mjcf: XmlText) -> list[Tag]:
    """Return the named hinges of the bodies, in the order of the file; a joint without a type is one."""
    joints = (tag for tag in mjcf.tags if tag.name == "joint" and tag.attributes.get("type", "hinge") == "hinge")
    return [tag for tag in joints if "name" in tag.attributes and tag.parent and tag.parent.name == "body"]


def edit_urdf(robot: XmlText, tag: Tag, joint: ExportedJoint) -> Iterator[Edit]:
    """Set ``<dynamics>`` of a joint."""
    coulomb, viscous, *_ = map(number, joint.fitted.coefficients)
    values, there = {"damping": viscous, "friction": coulomb}, robot.child(tag, "dynamics")
    attributes = " ".join(f'{key}="{value}"' for key, value in values.items())
    yield robot.set_attributes(there, values) if there else robot.append(tag, f"<dynamics {attributes}/>")


def edit_mjcf(mjcf: XmlText, tag: Tag, joint: ExportedJoint) -> Iterator[Edit]:
    """Set the attributes of a joint."""
    damping, inertia = " ".join(map(number, joint.damping)), joint.law.inertia_kg_m2
    values = {"frictionloss": number(joint.fitted.coefficients[0]), "damping": damping}
    yield mjcf.set_attributes(tag, values if inertia is None else values | {"armature": number(inertia)})


def edit_sdf(sdf: XmlText, tag: Tag, joint: ExportedJoint) -> Iterator[Edit]:
    """Set ``<dynamics>`` of the axis of a joint."""
    coulomb, viscous, *_ = map(number, joint.fitted.coefficients)
    axis, values = sdf.child(tag, "axis"), {"damping": viscous, "friction": coulomb}
    if axis is None:
        raise InputError(f"{sdf.where}: joint {joint.name} has no <axis>; expected one; repair the file")
    dynamics = sdf.child(axis, "dynamics")
    there = {name: own for name in values if dynamics and (own := sdf.child(dynamics, name))}
    yield from (sdf.filled(own, values[name]) for name, own in there.items())
    lacking = "".join(f"<{key}>{value}</{key}>" for key, value in values.items() if key not in there)
    if dynamics is None:
        yield sdf.append(axis, f"<dynamics>{lacking}</dynamics>")
    elif lacking:
        yield sdf.append(dynamics, lacking)
