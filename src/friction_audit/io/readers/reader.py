"""What a reader is given and what it returns, and the record of a container format."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from friction_audit.errors import InputError, UsageError, near_misses
from friction_audit.io.files import starts_with
from friction_audit.joint_log import JOINT_CHANNELS

MARGIN_S = 1.0  # read on both sides of a part, so that spikes and delays at its ends are judged by their neighbours
# Size of the arrays up to which a log is read whole although a part is asked for: units, signs and delays are then
# judged by all of the log. Beyond, a part is long enough to judge them by. [byte]
WHOLE_BYTES = 256 << 20
IN_BLOCKS_BYTES = 64 << 20  # larger arrays are read twice instead of kept [byte]
_MAPPABLE = ("t", *JOINT_CHANNELS)
OF_THE_COMMAND = ("partial", "hashed", "in_blocks", "largest_whole")  # of ReadOptions
_BOMB_BYTES, _BOMB_RATIO = 1 << 30, 100  # noise does not shrink to a hundredth when it is compressed
_GIGABYTE = 1e9
_GIT_LFS = b"version https://git-lfs.github.com/spec/"
TAKE_A_PART = "read a part of it with --t-start and --t-end, for example --t-start 0 --t-end 600"


def by_number(columns: int) -> str:
    """Return what to do about so many columns without names; as if they were time, q, dq and torque of some joints."""
    joints = min(max((columns - 1) // 3, 1), 7)  # of an arm; further columns are something else
    ends = ((name, 2 + k * joints, 1 + (k + 1) * joints) for k, name in enumerate(("q", "dq", "tau_J")))
    stated = " ".join(f"--map {name}=#{first}-#{last}" for name, first, last in ends)
    return f"expected names; give numbers, e.g. --map t=#1 {stated}"


def refuse_too_large(path: Path, needed: int, packed: int) -> None:
    """Refuse arrays before memory is asked for: the system hands out more than there is, and ends the program later."""
    refuse_bomb(path, needed, packed)
    try:
        memory = min(address_limit(), os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):  # Windows does not hand out more memory than it has
        return
    if needed > memory:
        size = f"{needed / _GIGABYTE:.3g} GB, more than the {memory / _GIGABYTE:.3g} GB of memory here"
        raise InputError(f"{path}: its numbers take {size}; {TAKE_A_PART}")


def refuse_bomb(path: Path, unpacked: int, packed: int) -> None:
    """Refuse more content than a recording can be packed to, both in bytes."""
    if unpacked > max(_BOMB_BYTES, _BOMB_RATIO * packed):
        size = f"{unpacked / _GIGABYTE:.3g} GB packed into {packed / _GIGABYTE:.3g} GB"
        raise InputError(f"{path}: {size}; expected at most {_BOMB_RATIO} times as much; it is damaged or no recording")


def refuse_pointer(path: Path) -> None:
    """Refuse a file that stands for one that Git has not fetched."""
    if starts_with(path, _GIT_LFS):
        raise InputError(f"{path}: a Git LFS pointer; expected the log itself; fetch it with `git lfs pull`")


def address_limit() -> float:
    """Return the limit on the addresses of this process, as ``ulimit -v`` sets it. [byte]"""
    try:
        import resource
    except ImportError:  # Windows
        return inf
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return inf if limit == resource.RLIM_INFINITY else limit


if address_limit() < inf:  # before Arrow is loaded
    # Its own allocator asks for a gigabyte of addresses at once, which the limit counts as if they were used.
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")


class SeveralLogsError(UsageError):
    """A log holds several arms, or a data set several episodes, and the user named none."""

    def __init__(self, message: str, topics: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.topics = tuple(topics)  # what --topic may say, once for each


@dataclass(frozen=True, kw_only=True, slots=True)
class ReadOptions:
    """What the user says about how to read a log; the defaults leave every choice to the reader."""

    topic: str | None = None  # topic to read of several; of several arms on it TOPIC#ARM, in a table #ARM
    # Channel (or "t") -> name in the file, {i} standing for the joint's index, or names separated by commas.
    mapping: Mapping[str, str] = field(default_factory=dict)
    robot: str | None = None  # robot stated by the user, wins over the log's own names
    time_scale: float = 1.0  # factor on the log's clock, for a log whose clock is known to be stretched
    allow_short: bool = False  # read a log that looks like a libfranka exception log all the same
    t_start_s: float | None = None  # start of the part to read, from the log's first sample, or None [s]
    t_end_s: float | None = None  # end of that part, or None [s]
    # Of the motors, one number or one per joint; the torque column is then a motor current. [N m/A]
    torque_constant: tuple[float, ...] = ()
    gear_ratio: tuple[float, ...] = ()  # turns of the motor per turn of the joint, likewise
    torque_scale: tuple[float, ...] = ()  # factor on the measured torque, likewise
    flip: tuple[int, ...] = ()  # numbers (1..n) of joints whose measured torque has the other sign
    join: tuple[str, ...] = ()  # further files of the log, whose channels are interpolated at the stamps of the first

    # What a command knows and no user says: OF_THE_COMMAND.
    partial: bool = False  # True for a file that may lack channels, since other files of the same log have them
    hashed: bool = True  # False for a result that does not show the hash of the file
    in_blocks: bool = False  # True to read a large table block by block, each time that it is needed: it is not kept
    largest_whole: float = inf  # what is read whole although a part is asked for, if that is less [byte]

    def __post_init__(self) -> None:
        """Raise UsageError if the factor is not above zero, a channel does not exist, or the part holds no time."""
        join = (self.join,) if isinstance(self.join, str | Path) else self.join
        object.__setattr__(self, "join", tuple(map(str, join)))
        if wrong := [channel for channel in self.mapping if channel not in _MAPPABLE]:
            hints = (f"--map {channel}: no such channel{near_misses(channel, _MAPPABLE)}" for channel in wrong)
            raise UsageError(f"{'; '.join(hints)}; channels are {', '.join(_MAPPABLE)}")
        if not inf > self.time_scale > 0.0:
            raise UsageError(f"--time-scale {self.time_scale:g}: expected a factor above zero, such as 0.5")
        for name in ("torque_constant", "gear_ratio", "torque_scale"):
            if not all(0.0 < value < inf for value in getattr(self, name)):
                option = name.replace("_", "-")
                raise UsageError(f"--{option}: expected numbers above zero; a sign is turned with --flip")
        if self.gear_ratio and not self.torque_constant:
            raise UsageError("--gear-ratio without --torque-constant: expected both, or --torque-scale for a torque")
        if self.t_start_s is not None and self.t_end_s is not None and not self.t_start_s < self.t_end_s:
            raise UsageError(f"--t-start {self.t_start_s:g} --t-end {self.t_end_s:g}: expected an end after the start")

    @property
    def has_window(self) -> bool:
        """True if a part of the log is asked for."""
        return self.t_start_s is not None or self.t_end_s is not None

    def reads_part(self, whole_bytes: float) -> bool:
        """Return True if a reader leaves out what lies outside the part: the log is large and a part is asked for."""
        return self.has_window and whole_bytes > min(WHOLE_BYTES, self.largest_whole)

    def window_of_clock(self) -> tuple[float, float]:
        """Return what a reader has to read, margins included, in seconds since the first sample on the log's clock."""
        start = -inf if self.t_start_s is None else self.t_start_s / self.time_scale - MARGIN_S
        return start, inf if self.t_end_s is None else self.t_end_s / self.time_scale + MARGIN_S


@dataclass(frozen=True, kw_only=True, slots=True)
class Topic:
    """A topic (or table) found in a file, for ``info`` and for messages."""

    name: str
    type: str
    messages: int | None
    readable: bool

    def __str__(self) -> str:
        return f"{self.name} ({self.type}, {self.messages} messages)"


class Reader(NamedTuple):
    """A container format; its module is loaded when a file may be of it."""

    name: str  # shown to people and stored in results
    suffixes: tuple[str, ...]  # file name endings, lower case, with the dot
    magic: bytes = b""  # what each file begins with; without it the module says what is of this format
    module: str = ""  # if it is not called as the format is

    @property
    def loaded(self) -> Any:  # noqa: ANN401 - a module
        """Its module, with ``read(path, options) -> Recording`` and ``topics(path) -> tuple[Topic, ...]``.

        Without magic bytes it also has ``recognises(path) -> bool``, which never raises.
        """
        return import_module(f"{__package__}.{self.module or self.name}")


_SERIAL_KEYS = {f"{whose}serial{what}" for whose in ("", "robot_", "arm_") for what in ("", "_number")}


def serial_in(notes: Mapping[str, str]) -> str:
    """Return the serial number among notes by name, or nothing; case and dashes of names do not matter."""
    found = {key.strip().lower().replace("-", "_").replace(" ", "_"): value.strip() for key, value in notes.items()}
    return next((found[key] for key in sorted(_SERIAL_KEYS & found.keys()) if found[key]), "")
