"""Write a log in any format; of the writers that share an ending, the first is its default.

A format is added by writing one file and naming its records in WRITERS.
"""

from difflib import get_close_matches
from pathlib import Path

from friction_audit.errors import UsageError
from friction_audit.io.files import whole_file
from friction_audit.io.writers.arrays import NPZ, PARQUET, PARQUET_LISTS
from friction_audit.io.writers.csv import CSV_DIALECTS
from friction_audit.io.writers.mcap import MCAP_DIALECTS
from friction_audit.io.writers.ros_messages import BAGS
from friction_audit.io.writers.tables import Writer
from friction_audit.joint_log import JointLog

WRITERS: tuple[Writer, ...] = (PARQUET, PARQUET_LISTS, *CSV_DIALECTS, NPZ, *BAGS, *MCAP_DIALECTS)


def write_log(log: JointLog, path: Path, *, dialect: str | None = None, overwrite: bool = False) -> Writer:
    """Write a log whole or not at all.

    Args:
        log: The log.
        path: Where to; a directory for ROS 2 bags.
        dialect: Name of a writer, or None for the default of the file name's ending.
        overwrite: Replace what is there.

    Returns:
        The writer that was used; its ``left_out`` names the channels that it had no place for.

    Raises:
        UsageError: If the dialect is unknown, contradicts the ending or cannot hold the log, or something is there.
    """
    writer = choose_writer(path, dialect)
    check_fit(log, writer)
    with whole_file(path, overwrite=overwrite) as draft:
        writer.write(log, draft)
    return writer


def choose_writer(path: Path, dialect: str | None = None) -> Writer:
    """Return the writer of a dialect, or the first one of the file name's ending.

    Raises:
        UsageError: If there is none, or the two contradict each other.
    """
    suffix = path.suffix.lower()
    if dialect is None:
        found = next((writer for writer in WRITERS if writer.suffix and writer.suffix == suffix), None)
        if found is None:
            endings = ", ".join(dict.fromkeys(writer.suffix for writer in WRITERS if writer.suffix))
            raise UsageError(f"{path}: ending {suffix or 'missing'}: expected one of {endings}, or name a --dialect")
        return found
    named = next((writer for writer in WRITERS if writer.name == dialect), None)
    if named is None:
        names = [writer.name for writer in WRITERS]
        near = get_close_matches(dialect, names, n=2, cutoff=0.5)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise UsageError(f"--dialect {dialect}: expected one of {', '.join(names)}{hint}")
    if named.suffix and named.suffix != suffix:
        raise UsageError(
            f"{path}: ending {suffix or 'missing'}: the dialect {dialect} writes {named.suffix}; rename it"
        )
    return named


def check_fit(log: JointLog, writer: Writer) -> None:
    """Refuse what the dialect cannot hold and say which dialects can.

    Raises:
        UsageError: Naming what the log lacks.
    """
    channels, joints = log.channels(), len(log.joint_names)
    missing = [name for name in writer.needs if name not in channels]
    lacks = [f"{', '.join(missing)} (the log has {', '.join(channels)})"] if missing else []
    if writer.joints not in (None, joints):
        lacks.append(f"{writer.joints} joints (the log has {joints})")
    if not lacks:
        return
    able = [other.name for other in WRITERS if set(other.needs) <= set(channels) and other.joints in (None, joints)]
    raise UsageError(
        f"{log.source.path}: the dialect {writer.name} needs {' and '.join(lacks)}; choose one that can hold the log: "
        f"{', '.join(able)}"
    )
