"""Which arm a session is of, and when it was: by manifest, by the log itself, by names; never mixed silently."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from friction_audit.batch.log_file import LogFile, ManifestRow
from friction_audit.batch.recorded import Recorded
from friction_audit.batch.start_time import holds_a_time, time_in_name
from friction_audit.drift.order import natural, put_in_order
from friction_audit.drift.session import Session

NOTHING_SAID = ManifestRow(path="")
UNKNOWN = "unknown"


@dataclass(frozen=True, kw_only=True, slots=True)
class Identified:
    """Sessions, each of a robot, in order, and what is to be said about that.

    Attributes:
        sessions: By robot, each robot's in the order of their starts, or of their names where starts are not known.
        warnings: One sentence each.
    """

    sessions: tuple[Session, ...]
    warnings: tuple[str, ...]


def identify(found: Sequence[tuple[LogFile, Recorded]]) -> Identified:
    """Say of every session which arm it is of and when it was."""
    named = [(recorded, _session(file, recorded)) for file, recorded in found]
    sessions: list[Session] = []
    warnings = list(_shared_names(found))
    for robot in sorted({session.robot for _, session in named}, key=natural):
        own = [(recorded, session) for recorded, session in named if session.robot == robot]
        groups = _alike(own)
        if len(groups) > 1:
            warnings.append(
                f"robot {robot}: its logs are of unlike arms ({'; '.join(groups)}), which are not compared with each "
                "other; name the robots in a manifest"
            )
        for kind, group in groups.items():
            name = f"{robot} ({kind})" if len(groups) > 1 else robot
            sessions += put_in_order([replace(session, robot=name) for session in group]).sessions
    return Identified(sessions=tuple(sessions), warnings=tuple(warnings))


def _session(file: LogFile, recorded: Recorded) -> Session:
    row = file.row or NOTHING_SAID
    session = recorded.session
    start_s, start_from = _start(file, row, session)
    return replace(
        session,
        path=name_of(file, recorded.topic),
        robot=_robot(file, row, recorded),
        start_s=start_s,
        start_from=start_from,
        conditions=replace(session.conditions, payload=row.payload),
        temperature_c=row.temperature_c,
        note=row.note,
    )


def name_of(file: LogFile, topic: str) -> str:
    """Return what people call an arm of a log; the topic is empty where the log holds one."""
    return f"{file.path} [{topic}]" if topic else file.path


def _robot(file: LogFile, row: ManifestRow, recorded: Recorded) -> str:
    """Return the robot's name, of manifest, log or folder; with the arm, where the log holds several."""
    told = recorded.session.robot
    if not recorded.topic:
        return row.robot or told or robot_folder(file.folders)
    arm = told or recorded.topic
    return f"{row.robot}/{arm}" if row.robot else arm


def robot_folder(folders: Sequence[str]) -> str:
    """Return the name of the nearest folder that is not called after a day."""
    names = [name for name in folders if name]
    return next((name for name in names if not holds_a_time(name)), names[-1] if names else "robot")


def _start(file: LogFile, row: ManifestRow, session: Session) -> tuple[float | None, str]:
    if row.start_s is not None:
        return row.start_s, "manifest"
    if session.start_s is not None:
        return session.start_s, "log"
    named = time_in_name((file.path.rstrip("/").rpartition("/")[2], *file.folders))
    return (named, "name") if named is not None else (None, "nothing")


def _alike(own: Iterable[tuple[Recorded, Session]]) -> dict[str, list[Session]]:
    """Group sessions by number of joints and by make; a log that does not tell its make is of the only one there is."""
    pairs = list(own)
    makes: dict[int, set[str]] = {}
    for recorded, session in pairs:
        makes.setdefault(len(session.joints), set()).add(recorded.kind)
    groups: dict[str, list[Session]] = {}
    for recorded, session in pairs:
        joints = len(session.joints)
        known = makes[joints] - {UNKNOWN}
        make = known.copy().pop() if len(known) == 1 else recorded.kind
        groups.setdefault(f"{joints} joint{'' if joints == 1 else 's'}, {make}", []).append(session)
    return dict(sorted(groups.items()))


def _shared_names(found: Sequence[tuple[LogFile, Recorded]]) -> list[str]:
    """Return a warning for each name that logs of several folders give their arm: there may be two called ``left``."""
    places: dict[str, set[str]] = {}
    for file, recorded in found:
        if recorded.session.robot and not (file.row and file.row.robot) and not recorded.named_by_serial:
            places.setdefault(recorded.session.robot, set()).add(robot_folder(file.folders))
    return [
        f"robot {name}: logs in {len(folders)} folders ({', '.join(sorted(folders, key=natural))}) call their arm "
        "so and are taken for the same arm; if they are not, name the robots in a manifest"
        for name, folders in sorted(places.items())
        if len(folders) > 1
    ]
