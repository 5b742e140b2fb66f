"""What came of a log, from its content alone; then its arm and its moment, also by a manifest, a CSV table."""

import csv
import io
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

from friction_audit.batch.find_logs import LogFile, ManifestRow
from friction_audit.drift.session import Session, natural, put_in_order, restore_joints
from friction_audit.errors import InputError

# Columns that are read; "path" has to be there. Others may be there, and are left alone.
COLUMNS = ("path", "start", "robot", "temperature", "payload", "note")
_EPISODE = re.compile(r"^episode_\d+")  # of a data set: its episodes are of the same arm or arms


@dataclass(frozen=True, kw_only=True, slots=True)
class Fault:
    """One arm of a log, or the whole of it, that no summary could be made of."""

    message: str  # why; printed after the name of the log
    topic: str = ""  # which arm, as in ``Session``
    lasting: bool = True  # True if the log itself is to blame: the same log with the same settings will fail again


@dataclass(frozen=True, kw_only=True, slots=True)
class Worked:
    """What came of a log."""

    sha256: str  # hash of its content; empty where it could not be read at all
    sessions: tuple[Session, ...] = ()  # its arms, each from the content alone: with the log's own name and start
    faults: tuple[Fault, ...] = ()  # arms without a summary


class FailedLog(NamedTuple):
    """A log, or an arm of one, that gave no session: its path, and what was wrong with it and what to do."""

    path: str
    message: str


_DATE = r"(?P<year>(?:19|20)\d\d)(?P<s>[-_.]?)(?P<month>0[1-9]|1[0-2])(?P=s)(?P<day>0[1-9]|[12]\d|3[01])"
_CLOCK = r"(?P<hour>[01]\d|2[0-3])(?P<c>[-_.:]?)(?P<minute>[0-5]\d)(?:(?P=c)(?P<second>[0-5]\d)(?:[.,](?P<part>\d+))?)?"
_ZONE = r"(?P<zone>Z|[+-]\d\d:?\d\d)?"
_TIME = re.compile(rf"(?<!\d){_DATE}(?:[T _.-]+{_CLOCK}{_ZONE})?(?!\d)", re.IGNORECASE)
# Seconds since 1970, from 2001 to 2033, as they are or in thousandths, millionths or billionths.
_EPOCH = re.compile(r"(?<!\d)(1\d{9})(?:(\d{3}|\d{6}|\d{9})|\.(\d+))?(?!\d)")


def parse_time(text: str) -> float | None:
    """Return the Unix time of a cell: a date, a date and time (UTC if no zone is stated), or seconds; else None."""
    if found := _TIME.fullmatch(text) or _EPOCH.fullmatch(text):
        return _unix_time(found)
    return float(text) if re.fullmatch(r"\d{9,}(?:\.\d+)?", text) else None


def time_in_name(names: Iterable[str]) -> float | None:
    """Return the Unix time in the first of the names that holds one, taken as UTC without a zone. [s]"""
    written = (found for name in names for form in (_TIME, _EPOCH) if (found := form.search(name)))
    return next((time for one in written if (time := _unix_time(one)) is not None), None)


def _unix_time(found: re.Match[str]) -> float | None:
    if found.re is _EPOCH:
        whole, finer, decimals = found.groups()
        return int(whole) + int(finer) / 10.0 ** len(finer) if finer else float(f"{whole}.{decimals or 0}")
    date = f"{found['year']}-{found['month']}-{found['day']}"
    clock = f"{found['hour'] or '00'}:{found['minute'] or '00'}:{found['second'] or '00'}"
    try:
        time = datetime.fromisoformat(f"{date}T{clock}{(found['zone'] or 'Z').upper()}")
    except ValueError:  # 30 February
        return None
    return time.timestamp() + float(f"0.{found['part'] or 0}")


def identify(found: Sequence[tuple[LogFile, Session]]) -> tuple[tuple[Session, ...], tuple[str, ...]]:
    """Return sessions with arm and start, by robot, each in the order of ``put_in_order``; and warnings."""
    named: dict[str, list[Session]] = {}
    for session in (_session(file, session) for file, session in found):
        named.setdefault(session.robot, []).append(session)
    sessions: list[Session] = []
    warnings = _shared_names(found)
    for robot in sorted(named, key=natural):
        groups = _alike_arms(restore_joints(named[robot]))
        if len(groups) > 1:
            warnings.append(
                f"robot {robot}: its logs are of unlike arms ({'; '.join(groups)}), which are not compared with each "
                "other; name the robots in a manifest"
            )
        for kind, group in groups.items():
            name = f"{robot} ({kind})" if len(groups) > 1 else robot
            sessions += put_in_order([replace(session, robot=name) for session in group]).sessions
    return tuple(sessions), tuple(warnings)


def _session(file: LogFile, session: Session) -> Session:
    row, known = file.row or ManifestRow(path=""), session.robot
    dated = time_in_name((file.path.rstrip("/").rpartition("/")[2], *file.folders))
    starts = ((row.start_s, "manifest"), (session.start_s, "log"), (dated, "name"))
    start_s, start_from = next((one for one in starts if one[0] is not None), (None, "nothing"))
    if arm := _EPISODE.sub("", session.topic):  # one of several arms of a log
        robot = f"{row.robot}/{known or arm}" if row.robot else known or arm
    else:
        robot = row.robot or known or robot_folder(file.folders)
    return replace(
        session,
        path=name_of(file, session.topic),
        robot=robot,
        start_s=start_s,
        start_from=start_from,
        conditions=replace(session.conditions, payload=row.payload),
        temperature_c=row.temperature_c,
        note=row.note,
    )


def name_of(file: LogFile, topic: str) -> str:
    """Return what people call an arm of a log; the topic is empty where the log holds one."""
    return f"{file.path} [{topic}]" if topic else file.path


def robot_folder(folders: Sequence[str]) -> str:
    """Return the name of the nearest folder that is not called after a day."""
    names = [name for name in folders if name]
    others = (name for name in names if not (_TIME.search(name) or _EPOCH.search(name)))
    return next(others, names[-1] if names else "robot")


def _alike_arms(sessions: Sequence[Session]) -> dict[str, list[Session]]:
    """Group sessions by number of joints and make; a log without its make is of the only one that is known."""
    makes: dict[int, set[str]] = {}
    for session in sessions:
        makes.setdefault(session.log_joints, set()).add(session.kind)
    groups: dict[str, list[Session]] = {}
    for session in sessions:
        joints = session.log_joints
        known = makes[joints] - {"unknown"}
        make = next(iter(known)) if len(known) == 1 else session.kind
        groups.setdefault(f"{joints} joint{'' if joints == 1 else 's'}, {make}", []).append(session)
    return dict(sorted(groups.items()))


def _shared_names(found: Sequence[tuple[LogFile, Session]]) -> list[str]:
    """Warn of each name that logs of several folders give their arm: there may be two called ``left``."""
    places: dict[str, set[str]] = {}
    for file, session in found:
        if session.robot and not (file.row and file.row.robot) and not session.named_by_serial:
            places.setdefault(session.robot, set()).add(robot_folder(file.folders))
    return [
        f"robot {name}: logs in {len(folders)} folders ({', '.join(sorted(folders, key=natural))}) call their arm "
        "so and are taken for the same arm; if they are not, name the robots in a manifest"
        for name, folders in sorted(places.items())
        if len(folders) > 1
    ]


def read_manifest(manifest: Path) -> dict[str, ManifestRow]:
    """Return the rows of a manifest by the place of their log: an absolute path, or a URL."""
    lines = csv.reader(io.StringIO(_text(manifest)), skipinitialspace=True)
    header = [name.strip().lower() for name in next(lines, [])]
    _check_header(manifest, header)
    wrong: list[str] = []
    rows: dict[str, ManifestRow] = {}
    seen: dict[str, int] = {}
    for cells in ([cell.strip() for cell in row] for row in lines):
        if not any(cells):
            continue
        row, faults = _row(dict.fromkeys(COLUMNS, "") | dict(zip(header, cells, strict=False)), manifest.parent)
        if len(cells) > len(header):
            faults = [f"{len(cells)} cells under {len(header)} columns; put text with commas in quotes"]
        place = row.path if "://" in row.path else os.path.normpath((manifest.parent / row.path).absolute())
        if row.path and seen.setdefault(place, lines.line_num) != lines.line_num:
            faults.append(f"{row.path} comes twice, first in line {seen[place]}")
        wrong += [f"line {lines.line_num}: {fault}" for fault in faults]
        rows[place] = row
    if wrong:
        raise InputError(f"{manifest}: " + "; ".join(wrong))
    if not rows:
        raise InputError(f"{manifest}: no rows below the header; expected one row per log")
    return rows


def _text(manifest: Path) -> str:
    try:
        return manifest.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{manifest}: cannot be read: {error.strerror}; check the path") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{manifest}: is not text in UTF-8 ({error.reason}); save it as CSV in UTF-8") from error


def _check_header(manifest: Path, header: list[str]) -> None:
    wrong = [f"no column {'path' if header else 'at all'}"] if "path" not in header else []
    for name in header:
        near = get_close_matches(name, COLUMNS, n=1, cutoff=0.75)
        if name not in COLUMNS and near and near[0] not in header:
            wrong.append(f"column {name}: did you mean {near[0]}?")
    wrong += [f"column {name} comes twice" for name in COLUMNS if header.count(name) > 1]
    if wrong:
        found = ", ".join(header) or "an empty file"
        raise InputError(f"{manifest}: {'; '.join(wrong)}; found {found}; expected {', '.join(COLUMNS)}")


def _row(values: Mapping[str, str], folder: Path) -> tuple[ManifestRow, list[str]]:
    """Return what a row says, and what is wrong with it."""
    path, start, temperature = values["path"], values["start"], values["temperature"]
    start_s, temperature_c, faults = parse_time(start), math.nan, list[str]()
    with suppress(ValueError):
        temperature_c = float(temperature or "nan")
    if not path:
        faults.append("no path")
    elif "://" not in path and not (folder / path).exists():
        faults.append(f"{path}: no such file or directory in the folder of the manifest")
    if start and start_s is None:
        faults.append(f"start {start}: expected a date and time such as 2026-03-01T14:30:00 or seconds since 1970")
    if temperature and not math.isfinite(temperature_c):
        faults.append(f"temperature {temperature}: expected degrees Celsius, such as 23.5")
    own = {name: values[name] for name in ("path", "robot", "payload", "note")}
    return ManifestRow(**own, start_s=start_s, temperature_c=temperature_c if temperature else None), faults
