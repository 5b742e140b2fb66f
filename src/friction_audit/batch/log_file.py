"""LogFile: one log of a batch, before anybody has opened it."""

from dataclasses import dataclass

LEDGER = "ledger.sqlite"
"""Name of a ledger; a folder that holds one holds results, not logs."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ManifestRow:
    """What a manifest says of a log; None or empty where it says nothing.

    Attributes:
        path: The log.
        start_s: Unix time of the start. [s]
        robot: Which arm.
        temperature_c: Temperature of the session. [degC]
        payload: What the arm carried.
        note: For people.
    """

    path: str
    start_s: float | None = None
    robot: str = ""
    temperature_c: float | None = None
    payload: str = ""
    note: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class LogFile:
    """One log: a file, the directory of a ROS 2 bag, or the URL of either.

    Attributes:
        path: As found, for people: bytes of a name that are no UTF-8 are written out.
        place: Where a worker finds it: an absolute path, or a URL.
        folders: Names of the folders that it lies in, the innermost first, no further than what the user named.
        size: Bytes, of all files of a bag; -1 where nobody tells.
        changed: When it was last changed, in the words of its file system; empty where nobody tells.
        row: What the manifest says of it, or None.
    """

    path: str
    place: str
    folders: tuple[str, ...]
    size: int
    changed: str
    row: ManifestRow | None = None

    @property
    def is_remote(self) -> bool:
        """True if it is named by a URL."""
        return "://" in self.place


def as_text(name: str) -> str:
    r"""Return text that can be printed and stored as UTF-8: bytes of a name that are none are written as ``\udcff``."""
    return name.encode("utf-8", "backslashreplace").decode()
