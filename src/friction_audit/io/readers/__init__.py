"""A file -> JointLog: one reader per container format, one table of foreign names; every recording is checked."""

import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.errors import InputError, UsageError, few
from friction_audit.io.files import DATA_SET, METADATA, STORAGE_NAMES, Stamp, sha256_of, stamp_of, starts_with
from friction_audit.io.readers.arrays import ArrayTable, arrays_of_frame
from friction_audit.io.readers.channel_names import arm_of_log, torque_unit
from friction_audit.io.readers.join import join_recordings, refuse_without_torque
from friction_audit.io.readers.reader import TAKE_A_PART, Reader, ReadOptions, SeveralLogsError, Topic, refuse_pointer
from friction_audit.io.readers.table import read_table
from friction_audit.io.recording import Recording, WholeLogError
from friction_audit.joint_log import DERIVATIVE, TORQUE_CHANNELS, Finding, Joined, JointLog, LogInBlocks, Source
from friction_audit.joint_numbers import require_joints, write_joint_numbers
from friction_audit.presets import CURRENT, ESTIMATE, PRESETS, candidates

__all__ = ["READERS", "ReadOptions", "SeveralLogsError", "arm_of_log", "list_topics", "log_from_frame", "read_log"]

# CSV comes last: any text with separators looks like one.
READERS: tuple[Reader, ...] = (
    Reader("parquet", (".parquet", ".pq"), b"PAR1"),
    Reader("npz", (".npz",)),
    Reader("npy", (".npy",), b"\x93NUMPY", "arrays"),
    Reader("mat", (".mat",), b"MATLAB "),
    Reader("lerobot", ()),
    Reader("rosbag1", (".bag",), b"#ROSBAG V"),
    Reader("rosbag2", (".db3", ".zstd", ".zst")),
    Reader("mcap", (".mcap",), b"\x89MCAP0\r\n"),
    Reader("csv", (".csv", ".tsv", ".txt", ".dat", ".csv.gz", ".csv.zst")),
)
_FORMATS = ", ".join(f"{reader.name} ({' '.join(reader.suffixes) or 'directory'})" for reader in READERS)
# Endings of what is taken for a log in a folder: those of too much that is no log must be named by the user.
_ENDINGS = {*STORAGE_NAMES, *(one for reader in READERS for one in reader.suffixes)}
LOG_SUFFIXES = tuple(sorted(_ENDINGS - {".txt", ".dat", ".zstd", ".zst"}))
_PART = re.compile(r"_\d+\..*")  # of a ROS 2 bag: its number and endings
_DEFAULT = ReadOptions()
_FACTORS = {"torque_constant": "torque constant {} N m/A", "gear_ratio": "gear ratio {}", "torque_scale": "scale {}"}
# Of a source, as of its recording.
_AS_READ = ("path", "robot", "serial", "clock", "topic", "clock_windows", "findings")
Listen = Callable[[JointLog], Callable[..., None] | None]
_PACKED = {b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"\x28\xb5\x2f\xfd": "zstd"}


def read_log(path: str | Path, options: ReadOptions = _DEFAULT, listen: Listen = lambda _: None) -> JointLog:
    """Read a recorded joint log of any format, a file or the directory of a bag or data set, and check it.

    ``listen`` is given what is known of a log in blocks at its first block, and returns what takes every block (number
    of the first sample, time, channels) while it is checked, or None.
    """
    if options.in_blocks:
        with suppress(WholeLogError):
            return _read_log(path, options, listen)
        options = replace(options, in_blocks=False, hashed=True)
    return _read_log(path, options, listen)


def _read_log(path: str | Path, options: ReadOptions, listen: Listen) -> JointLog:
    files = [(file := Path(name), _stamp(file), choose_reader(file)) for name in (path, *options.join)]
    at, parts, asked = files[0], list[Recording](), _asked(options)
    # Files can be joined in memory alone.
    own = replace(asked, partial=bool(options.join), in_blocks=asked.in_blocks and not options.join)
    arm = (options.topic or "").partition("#")[2]
    with ThreadPoolExecutor(max_workers=1, thread_name_prefix="sha256") as pool:
        # hashlib gives the lock away: this costs no time on a second core.
        digests = [pool.submit(sha256_of, file) for file, *_ in files] if options.hashed else []
        try:
            for name, at in zip((path, *options.join), files, strict=True):
                part = replace(at[2].loaded.read(at[0], own), path=str(name))
                parts.append(part.with_findings(_suffix_mismatch(at[0], at[2])))
                # The part of the log and the topic that are asked for are those of the first file.
                own = replace(own, topic=f"#{arm}" if arm else None, t_start_s=None, t_end_s=None)
            at = files[0]
            recording = join_recordings(parts, asked.mapping) if options.join else parts[0]
            refuse_without_torque(recording, parts)
            recording = _checked(recording, options, listen)
            contents = [digest.result() for digest in digests] or [""] * len(files)
        except OSError as error:
            raise _unreadable(at[0], error) from error
        except MemoryError as error:
            raise InputError(f"{at[0]}: not enough memory for {at[1].size} bytes; {TAKE_A_PART}") from error
        except InputError as error:
            damage = (one for part in parts for one in part.findings if one.damaged)
            found = (_suffix_mismatch(at[0], at[2]), *damage)
            notes = [one.message for one in found if one and one.message not in str(error)]
            if _stamp(at[0]) != at[1]:
                notes.append("the file changed while it was read: read it again when it is finished")
            if not notes:
                raise
            raise type(error)("; ".join((str(error), *notes))) from error
    recording = recording.with_findings(*(_growth(before, _stamp(file)) for file, before, _ in files))
    others = zip(files[1:], contents[1:], strict=True)
    joined = tuple(Joined(path=str(file), sha256=sha, format=reader.name) for (file, _, reader), sha in others)
    return to_joint_log(recording, options, sha256=contents[0], format=files[0][2].name, joined=joined)


def _asked(options: ReadOptions) -> ReadOptions:
    """Return what is left for a reader to do: a velocity for ``--map dq=derivative`` is not looked for in a file."""
    return replace(options, mapping={c: name for c, name in options.mapping.items() if (c, name) != ("dq", DERIVATIVE)})


def log_from_frame(frame: Any, options: ReadOptions = _DEFAULT, *, name: str = "frame") -> JointLog:  # noqa: ANN401
    """Read a pandas, polars or Arrow table, or arrays of shape (n,) or (n, joints) by name, as a joint log; check it.

    Messages and results call it by the name. UsageError if it is no frame.
    """
    from hashlib import sha256

    arrays = arrays_of_frame(frame, name)
    recording = replace(read_table(ArrayTable(Path(name), arrays), _asked(options)), path=name)
    recording = _checked(recording, options, lambda _: None)
    digest = sha256()
    for column, array in arrays.items():
        digest.update(column.encode() + (str(array.tolist()).encode() if array.dtype == object else array.tobytes()))
    return to_joint_log(recording, options, sha256=digest.hexdigest(), format="frame")


def _checked(recording: Recording, options: ReadOptions, listen: Listen) -> Recording:
    """Return a recording with its torque converted, and its faults noticed and mended."""
    from friction_audit.io.checks import examine
    from friction_audit.io.checks.clock import leave_out_far

    if options.mapping.get("dq") == DERIVATIVE:  # made from q when its faults are mended
        channels = {channel: array for channel, array in recording.channels.items() if channel != "dq"}
        recording = replace(recording, channels=channels, mapping={**recording.mapping, "dq": DERIVATIVE})
    recording = _convert_torque(recording, options)
    row_bytes = np.float64().itemsize * (1 + sum(array.shape[1] for array in recording.channels.values()))
    if recording.blocks is not None and options.reads_part(recording.rows * row_bytes):
        recording = leave_out_far(recording, *options.window_of_clock())
    recording = examine(recording, options, lambda known: listen(to_joint_log(known, options)))
    return recording.with_findings(_doubt_current(recording))


def to_joint_log(
    recording: Recording,
    options: ReadOptions = _DEFAULT,
    *,
    sha256: str = "",
    format: str = "",  # noqa: A002
    joined: tuple[Joined, ...] = (),
) -> JointLog:
    """Make an examined recording a JointLog whose clock starts at 0, in memory or not."""
    blocks = recording.blocks
    first = float(recording.t[0]) if blocks is None else recording.first_s or 0.0
    torque = next(name for name in TORQUE_CHANNELS if name in recording.channels)
    source = Source(
        **{name: getattr(recording, name) for name in _AS_READ},
        sha256=sha256,
        format=format,
        start_s=None if recording.start_s is None else recording.start_s + first,
        channels=dict(recording.mapping),
        torque_unit=recording.torque_unit or torque_unit(recording.mapping.get(torque, "")),
        window=(options.t_start_s, options.t_end_s),
        skipped_s=first if options.has_window else 0.0,
        joined=joined,
    )
    held: dict[str, Any] = {**recording.channels, "joint_names": recording.joint_names, "source": source}
    if blocks is None:
        return JointLog(t=recording.t if first == 0.0 else recording.t - first, **held)
    again = partial(read_log, recording.path, replace(options, in_blocks=False, hashed=True))
    return LogInBlocks(t=recording.t, **held, **blocks.found, read=blocks.read, first=0, read_whole=again)


def list_topics(path: str | Path) -> tuple[str, tuple[Topic, ...]]:
    """Return the name of a file's format, and the topics or tables in it."""
    file = Path(path)
    _stamp(file)
    reader = choose_reader(file)
    try:
        return reader.name, reader.loaded.topics(file)
    except OSError as error:
        raise _unreadable(file, error) from error


def choose_reader(path: Path) -> Reader:
    """Return the reader that recognises a file by its content, else the one of its suffix."""
    by_suffix = [reader for reader in READERS if path.name.lower().endswith(reader.suffixes)]
    names = sorted(entry.name for entry in path.iterdir()) if path.is_dir() else []
    logs = [name for name in names if name.lower().endswith(LOG_SUFFIXES)]
    # Without metadata.yaml, storage files are one recording if their names differ in the number at the end alone.
    stored, parts = [name.lower().endswith(STORAGE_NAMES) for name in logs], {_PART.sub("", name) for name in logs}
    if not (METADATA in names or (path / DATA_SET).is_file() or (all(stored) and len(parts) <= 1)):
        what = f"a directory of logs ({', '.join(few(logs))}); expected one log, or parts of one (run_0.db3, run_1.db3)"
        raise InputError(f"{path}: {what}; give one of them, or the directory to batch-report")
    for reader in (*by_suffix, *READERS):
        if starts_with(path, reader.magic) if reader.magic else reader.loaded.recognises(path):
            return reader
    if packed := next((name for magic, name in _PACKED.items() if starts_with(path, magic)), ""):
        raise InputError(f"{path}: packed with {packed}; expected one that is not; unpack with `{packed} -d {path}`")
    what = "of no known format"
    if path.is_dir():
        what = f"a directory without the storage files of a bag or the {DATA_SET} of a LeRobot data set"
    elif by_suffix:
        return by_suffix[0]
    elif starts_with(path, b'{\n  "schema": "friction-audit/'):
        what = "a result of friction-audit, no log; give the log that it is of"
    raise InputError(f"{path}: {what}; what is read: {_FORMATS}; convert it, or choose a file inside")


def _stamp(path: Path) -> Stamp:
    """Return size and time of the last change, once it is sure that there is something to read."""
    try:
        if path.is_dir():
            choose_reader(path)  # before all files below it are looked at, which may be a whole disk
        elif path.is_file():
            path.open("rb").close()  # raises if it may not be read
            refuse_pointer(path)
        elif path.exists():
            raise InputError(f"{path}: a pipe or a device; expected a file; save its content to a file and read that")
        stamp = stamp_of(path)
    except OSError as error:
        raise _unreadable(path, error) from error
    if stamp.size == 0:
        what = "its files are empty" if path.is_dir() else "the file is empty"
        raise InputError(f"{path}: {what} (0 bytes); expected a joint log: {_FORMATS}; copy or record it again")
    return stamp


def _unreadable(path: Path, error: OSError) -> InputError:
    advice = {
        FileNotFoundError: "no such file or directory; check the path",
        PermissionError: "no permission to read it; change its mode or owner",
    }.get(type(error), f"cannot be read: {error.strerror or error}")
    return InputError(f"{path}: {advice}")


def _suffix_mismatch(path: Path, reader: Reader) -> Finding | None:
    others = [other.name for other in READERS if path.name.lower().endswith(other.suffixes)]
    if reader.name in others or not others:
        return None
    message = f"the name ends in {path.suffix}, as {others[0]} does; the content is {reader.name}, and was read as that"
    return Finding("suffix_mismatch", message)


def _growth(before: Stamp, after: Stamp) -> Finding | None:
    if before == after:
        return None
    how = f"{before.size} bytes before, {after.size} after" if before.size != after.size else "its size stayed"
    message = f"the file changed while it was read ({how}), and may be cut or mixed; read it again when it is finished"
    return Finding("file_grew", message, amount=float(after.size - before.size), damaged=True)


def _convert_torque(recording: Recording, options: ReadOptions) -> Recording:
    """Multiply the measured torque, tau_J where there is one, by constant, ratio and scale of each joint; in place."""
    factors = {name: values for name in _FACTORS if (values := getattr(options, name))}
    if not factors and not options.flip:
        return recording
    path, joints, parts = recording.path, len(recording.joint_names), list[str]()
    require_joints(options.flip, joints, f"{path}: --flip")
    channel = next(c for c in ("tau_J", *TORQUE_CHANNELS) if c in recording.channels)
    name = recording.mapping.get(channel, channel)
    unit, is_current = torque_unit(name), bool(options.torque_constant)
    total = np.where(np.isin(np.arange(1, joints + 1), options.flip), -1.0, 1.0)
    for one, values in factors.items():
        if len(values) not in (1, joints):
            option = one.replace("_", "-")
            raise UsageError(f"{path}: --{option}: {len(values)} numbers; expected one, or one per joint ({joints})")
        total = total * np.asarray(values)
        parts.append(_FACTORS[one].format(", ".join(f"{value:g}" for value in values)))
    recording = recording.scaled(channel, total * (1e-3 if is_current and unit == "mA" else 1.0))
    parts += [f"-1 in joint {write_joint_numbers(options.flip)}"] if options.flip else []
    message = f"{channel} is {name} times {' times '.join(parts)}"
    if is_current:
        message += "; a torque from a motor current: its friction is that of motor, gear and joint"
    recording = recording.with_findings(Finding("torque_converted", message))
    return replace(recording, torque_unit="N m" if is_current else unit)


def _doubt_current(recording: Recording) -> Finding | None:
    """Say where the arm by its name has no torque sensor: its effort is a current, or a torque made from one."""
    names = (recording.robot,) if recording.robot in PRESETS else candidates(recording.joint_names)
    kinds = {PRESETS[name].torque for name in names}
    name = recording.mapping.get("tau_J", "")
    if "tau_J" not in recording.channels or (recording.torque_unit or torque_unit(name)) != "N m":
        return None
    arm = PRESETS[names[0]].label if len(names) == 1 else "these arms"
    if kinds == {CURRENT} and "effort" in name.lower() and not recording.torque_unit:
        message = f"{name}: the ROS driver of {arm} gives the motor current [A] as effort; if so, --map tau_J=NAME:A"
        return Finding("effort_is_current", message)
    if kinds == {ESTIMATE}:
        message = f"{arm}: {name} is estimated from the motor current: its friction is that of motor, gear and joint"
        return Finding("torque_from_current", message)
    return None
