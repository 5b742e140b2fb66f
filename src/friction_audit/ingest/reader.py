"""What a reader is: one record per container format."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from math import inf
from pathlib import Path

from friction_audit.errors import UsageError
from friction_audit.joint_log import JOINT_CHANNELS, Finding, Float

MAPPABLE = ("t", *JOINT_CHANNELS)
"""What ``--map`` may name."""


class SeveralArmsError(UsageError):
    """A log holds several arms, and the user named none.

    Attributes:
        topics: What ``--topic`` may say, once for each arm.
    """

    def __init__(self, message: str, topics: Sequence[str]) -> None:
        super().__init__(message, tuple(topics))
        self.topics = tuple(topics)

    def __str__(self) -> str:
        """Return the message."""
        return str(self.args[0])


@dataclass(frozen=True, kw_only=True, slots=True)
class ReadOptions:
    """What the user says about how to read a log; the defaults leave every choice to the reader.

    Attributes:
        topic: Topic to read, for files that hold several; with several arms on it ``TOPIC#ARM``, in a table ``#ARM``.
        mapping: Channel (or ``"t"``) -> name in the file, ``{i}`` standing for the joint's index, or names
            separated by commas; wins over every guess.
        robot: Robot stated by the user, wins over the log's own names.
        time_scale: Factor on the log's clock, for a log whose clock is known to be stretched.
        allow_short: Read a log that looks like a libfranka exception log all the same.
    """

    topic: str | None = None
    mapping: Mapping[str, str] = field(default_factory=dict)
    robot: str | None = None
    time_scale: float = 1.0
    allow_short: bool = False

    def __post_init__(self) -> None:
        """Check the factor and the channels.

        Raises:
            UsageError: If the factor is no number above zero, or a channel does not exist.
        """
        wrong = [f"--map {c}: no such channel{_did_you_mean(c)}" for c in self.mapping if c not in MAPPABLE]
        if wrong:
            raise UsageError(f"{'; '.join(wrong)}; channels are {', '.join(MAPPABLE)}")
        if not inf > self.time_scale > 0.0:
            raise UsageError(f"--time-scale {self.time_scale:g}: expected a factor above zero, such as 0.5")


def _did_you_mean(channel: str) -> str:
    near = get_close_matches(channel, MAPPABLE, n=2)
    return f" (did you mean {' or '.join(near)}?)" if near else ""


@dataclass(eq=False, kw_only=True, slots=True)
class Recording:
    """What a reader hands over, names and units translated, before the recording is vetted.

    The arrays belong to the receiver, which may work in place.

    Attributes:
        t: Time since an origin of the reader's choice, shape (n,); any order, repeats allowed. [s]
        channels: Channel of JointLog -> array of shape (n, j), Fortran order, NaN where nothing was recorded.
        joint_names: One name per joint.
        clock: ``"robot_time"``, ``"header_stamp"``, ``"log_time"`` or ``"column"``.
        start_s: Unix time of t = 0, or None when the clock does not tell. [s]
        robot: Robot told by joint names or message types, or ``"unknown"``.
        serial: Serial number of the arm as the file states it, empty if it does not.
        topic: Topic read, or None.
        mapping: Channel -> name in the file, with ``{i}``.
        clock_windows: Windows of time on which the clock was checked against the motion.
        findings: What the reader itself noticed (a truncated file, a topic without content).
    """

    t: Float
    channels: dict[str, Float]
    joint_names: tuple[str, ...]
    clock: str = "column"
    start_s: float | None = None
    robot: str = "unknown"
    serial: str = ""
    topic: str | None = None
    mapping: Mapping[str, str] = field(default_factory=dict)
    clock_windows: int = 0
    findings: tuple[Finding, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class Topic:
    """A topic (or table) found in a file, for ``info`` and for messages."""

    name: str
    type: str
    messages: int | None
    readable: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class Reader:
    """A container format.

    Attributes:
        name: Name of the format, shown to people and stored in results.
        suffixes: File name endings, lower case, with the dot.
        recognises: True if this file (or directory) is of this format, from its content; never raises.
        read: Reads it.
        topics: Lists what is in it.
        summary: One line for the documentation.
    """

    name: str
    suffixes: tuple[str, ...]
    recognises: Callable[[Path], bool]
    read: Callable[[Path, ReadOptions], Recording]
    topics: Callable[[Path], tuple[Topic, ...]]
    summary: str
