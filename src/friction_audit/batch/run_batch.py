"""A batch: work on what the ledger does not know, gather all sessions, find the drift of their arms."""

import fcntl
import os
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from operator import attrgetter
from pathlib import Path

from friction_audit.batch.executor import Executor, Lost
from friction_audit.batch.find_logs import LogFile
from friction_audit.batch.identity import FailedLog, Fault, Worked, identify, name_of, time_in_name
from friction_audit.batch.ledger import BatchSettings, Ledger
from friction_audit.batch.work import work_on
from friction_audit.drift.analyse import analyse_arm
from friction_audit.drift.report import ArmDrift, DriftSettings
from friction_audit.drift.session import Session
from friction_audit.errors import AnalysisError, few


def drift_of_arms(sessions: Sequence[Session], settings: DriftSettings, executor: Executor) -> tuple[ArmDrift, ...]:
    """Find what changed between the sessions of each arm; a single arm is analysed here, where its sessions are."""
    by_robot = attrgetter("robot")
    arms = [tuple(own) for _, own in groupby(sorted(sessions, key=by_robot), by_robot)]
    if len(arms) == 1:
        return (analyse_arm(arms[0], settings),)
    found: list[ArmDrift] = []
    for arm, drift in executor.run(partial(analyse_arm, settings=settings), arms):
        if isinstance(drift, Lost):
            raise AnalysisError(f"{arm[0].robot}: its drift cannot be analysed: {drift.message}")
        found.append(drift)
    return tuple(sorted(found, key=by_robot))


MOST_NAMED = 3  # copies that a warning names; more are counted
# Takes how many logs are finished, of those that were new, and how many of them failed.
Watch = Callable[[int, int, int], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class Standing:
    """How a batch stands once nothing new is left to be worked on."""

    logs: tuple[LogFile, ...]  # the logs, copies left out
    hashes: Mapping[str, str]  # hash of each log's content by its place; none of logs that could not be read
    passing: Mapping[str, tuple[Fault, ...]]  # what went wrong without being the log's fault, by the log's place
    new: int  # how many logs were worked on in this run
    known: int  # how many were known before
    warnings: tuple[str, ...]  # which logs are copies, one sentence each


def catch_up(
    logs: Sequence[LogFile],
    settings: BatchSettings,
    ledger: Ledger,
    executor: Executor,
    watch: Watch,
    *,
    backwards: bool = False,
) -> Standing:
    """Work on all logs that the ledger does not know; ``backwards``, so that another run is met halfway."""
    key = settings.key()
    hashes = ledger.hashes(logs)
    first, copies = _one_of_each(logs, hashes)
    broken = ledger.forget_broken(hashes.values(), key)
    warnings = [
        f"{log.path}: what {ledger.path} held of it was damaged or changed since; it was computed again"
        for log in first
        if hashes.get(log.place) in broken
    ]
    new = [log for log in first if log.place not in hashes or not ledger.is_done(hashes[log.place], key)]
    passing = _work_through(new[::-1] if backwards else new, settings, ledger, executor, watch)
    hashes |= ledger.known_hashes(new)
    first, late_copies = _one_of_each(first, hashes)
    named = [f"{path}: the same recording as {kept}" for path, kept in (copies | late_copies).items()]
    if named:
        warnings.append(f"{'; '.join(few(named, MOST_NAMED, ' copies'))}, byte for byte; each recording counts once")
    return Standing(
        logs=tuple(first),
        hashes=hashes,
        passing={place: faults for place, faults in passing.items() if faults},
        new=len(new),
        known=len(logs) - len(new) - len(copies),
        warnings=tuple(warnings),
    )


def gather(
    standing: Standing, settings: BatchSettings, ledger: Ledger
) -> tuple[tuple[Session, ...], tuple[FailedLog, ...], tuple[str, ...]]:
    """Return the sessions of a batch, each of its arm and with its start; logs without any; warnings about them all."""
    key, hashes = settings.key(), standing.hashes
    known, nothing = ledger.known(hashes.values(), key), Worked(sha256="")
    found = [(log, known.get(hashes.get(log.place, ""), nothing)) for log in standing.logs]
    faults = [(log, one) for log, worked in found for one in (*worked.faults, *standing.passing.get(log.place, ()))]
    failed = tuple(FailedLog(name_of(log, one.topic), one.message) for log, one in faults)
    sessions, warnings = identify([(log, one) for log, worked in found for one in worked.sessions])
    ledger.name_sessions(sessions, key)
    if cut := [session.path for session in sessions if session.damaged]:
        part = "damaged, part of it is left out; the rest counts as a session: copy it again, or take it out"
        warnings = (*warnings, f"{'; '.join(few(cut, MOST_NAMED, ' files'))}: {part}")
    return sessions, failed, (*standing.warnings, *warnings)


def _one_of_each(logs: Sequence[LogFile], hashes: Mapping[str, str]) -> tuple[list[LogFile], dict[str, str]]:
    """Return the logs without further copies of the same content, and by the path of each copy the log that is kept.

    Of copies the one is kept that the manifest names; else whose name is written as those of most other recordings;
    else whose name holds a date; else that was changed first. Another name might give the session another date.
    """
    content = {log.place: hashes.get(log.place, log.place) for log in logs}
    patterns = {log.place: re.sub(r"\d+", "#", log.path.rstrip("/").rpartition("/")[2]) for log in logs}  # of names
    alike = Counter(pattern for pattern, _ in {(patterns[log.place], content[log.place]) for log in logs})

    def fitness(log: LogFile) -> tuple[bool, int, bool, int]:
        changed = log.changed.partition(" ")[0]
        dated = time_in_name([log.path.rpartition("/")[2]]) is not None
        return log.row is None, -alike[patterns[log.place]], not dated, int(changed) if changed.isdecimal() else 0

    kept = {content[log.place]: log for log in sorted(logs, key=fitness, reverse=True)}
    copies = {log.path: kept[content[log.place]].path for log in logs if kept[content[log.place]] is not log}
    return [log for log in logs if log.path not in copies], copies


def _work_through(
    new: Sequence[LogFile], settings: BatchSettings, ledger: Ledger, executor: Executor, watch: Watch
) -> dict[str, tuple[Fault, ...]]:
    """Work on new logs and save what comes of each at once; return what went wrong without being the log's fault."""
    key = settings.key()
    done = failed = 0
    passing: dict[str, tuple[Fault, ...]] = {}
    watch(0, len(new), 0)

    def tasks() -> Iterator[LogFile]:
        nonlocal done
        for log in new:
            if any(ledger.is_done(sha256, key) for sha256 in ledger.known_hashes([log]).values()):  # by another run
                done += 1
            else:
                yield log

    with closing(executor.run(partial(work_on, settings), tasks())) as outcomes:
        for log, worked in outcomes:
            if isinstance(worked, Lost):
                worked = Worked(sha256="", faults=(Fault(message=worked.message, lasting=False),))  # noqa: PLW2901
            ledger.save(log, settings, worked)
            passing[log.place] = tuple(fault for fault in worked.faults if not fault.lasting)
            done, failed = done + 1, failed + bool(worked.faults)
            watch(done, len(new), failed)
    return passing


@contextmanager
def run_lock(folder: Path) -> Iterator[bool]:
    """Yield True if this is the only run in a folder, which has to be there, as far as its file system has locks."""
    handle, alone = os.open(folder, os.O_RDONLY), True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        alone = False
    except OSError:  # a file system without locks
        pass
    try:
        yield alone
    finally:
        os.close(handle)
