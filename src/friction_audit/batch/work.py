"""What a worker, here or on another machine, does with one log: all that goes in and comes out can be pickled."""

import socket
from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from friction_audit.batch.find_logs import LogFile, fetched, local_log
from friction_audit.batch.identity import Fault, Worked
from friction_audit.batch.ledger import BatchSettings
from friction_audit.drift.regression import relative_change
from friction_audit.drift.session import BY_REGRESSION, COEFFICIENTS, Conditions, JointSummary, Session, SpeedCurve
from friction_audit.errors import FrictionAuditError, InputError, encodable
from friction_audit.friction.history import NAN, UNDETERMINED, Coefficient, JointFriction
from friction_audit.friction.settings import FEWEST_CYCLES
from friction_audit.friction.weighted import fit_windows, normal_equations
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import SeveralLogsError, arm_of_log, read_log
from friction_audit.joint_log import Float
from friction_audit.parallel import one_joint_at_a_time
from friction_audit.pipeline import Estimate, diagnose_estimate, estimate_log
from friction_audit.preprocessing.energy_cycles import KEPT, EnergyCycles
from friction_audit.preprocessing.interaction import Caution, quoted

if TYPE_CHECKING:
    from friction_audit.diagnosis.result import JointDiagnosis

READINGS = 2  # a log that changes while it is read (a link to it made, a copy not finished) is read once more
QUARTERS = (0.25, 0.5, 0.75)
BINS = 40  # of speed, in the curve; both directions of motion together
FEWEST_SAMPLES = 20  # a mean of fewer samples is no point of the curve
OUTERMOST = 0.002  # share of the samples beyond each end of the curve: single glitches of the velocity would stretch it


def work_on(settings: BatchSettings, log: LogFile) -> Worked:
    """Estimate every arm of a log; a fault of the log, or of the program, is part of the result."""
    try:
        with fetched(log.place) if "://" in log.place else _at_hand(log.place) as path, one_joint_at_a_time():
            for _ in range(READINGS):  # what comes of a log is kept by its content, which has to stay what it is
                before, worked = local_log(str(path)), _arms(settings, path)
                if local_log(str(path)) == before:
                    return _renamed(worked, str(path), log.path)
        raise InputError("the file changed while it was read; run the same command again when it is finished")
    except FrictionAuditError as error:
        message = encodable(str(error).replace(log.place, log.path)).removeprefix(f"{log.path}: ")
        return Worked(sha256="", faults=(Fault(message=message, lasting=False),))


def _at_hand(place: str) -> "nullcontext[Path]":
    """Return the place of a log on this machine for a block; refuse what cannot be seen from here."""
    path = Path(place)
    if path.is_symlink() and not path.exists():
        raise InputError(f"{path}: a link to {path.readlink()}, where there is nothing to be read; repair or remove it")
    if not path.exists():
        here = f"not to be found on {socket.gethostname()}, where it should be read"
        raise InputError(f"{path}: {here}; give a path that every worker sees")
    return nullcontext(path)


def _arms(settings: BatchSettings, path: Path, topic: str = "") -> Worked:
    """Estimate one arm of a log, or all of them if the topic is empty."""
    try:
        log = read_log(path, replace(settings.reading, topic=topic) if topic else settings.reading)
        estimate = estimate_log(log, settings.audit)
        asked = settings.diagnosis
        session = session_of(estimate, () if asked is None else diagnose_estimate(estimate, asked).joints)
        return Worked(sha256=session.sha256, sessions=(replace(session, topic=topic),))
    except SeveralLogsError as several:
        arms = [_arms(settings, path, one) for one in several.topics]
        sessions, faults = [one for arm in arms for one in arm.sessions], [one for arm in arms for one in arm.faults]
        return Worked(sha256=arms[0].sha256, sessions=tuple(sessions), faults=tuple(faults))
    except FrictionAuditError as error:
        fault = Fault(message=str(error), topic=topic)
    except MemoryError:
        fault = Fault(message="not enough memory to work on it; use fewer workers", topic=topic, lasting=False)
    except Exception as error:  # noqa: BLE001 - a bug that one log shows must not cost the others
        message = f"a bug of friction-audit, please report it: {type(error).__name__}: {error}"
        fault = Fault(message=message, topic=topic, lasting=False)
    with suppress(OSError):
        return Worked(sha256=sha256_of(path), faults=(fault,))
    return Worked(sha256="", faults=(replace(fault, lasting=False),))  # a log that cannot even be read


def session_of(estimate: Estimate, diagnoses: "Sequence[JointDiagnosis]" = ()) -> Session:
    """Return what is kept of an estimate."""
    log, interaction, source = estimate.log, estimate.interaction, estimate.log.source
    choice = interaction.choice
    codes = [one.code for one in source.findings]
    codes += [one.code for one in (*interaction.warnings, *estimate.friction.warnings)]
    unit = () if source.torque_unit == "N m" else ("torque_in_ampere",)
    findings = [Caution("quoted", one.joint, {"text": one.message}) for one in source.findings]
    made = {name: getattr(choice, name) for name in ("drive", "gravity", "inertia")}
    payload = ", ".join(f"{number:g}" for number in estimate.settings.torque.payload or ())
    return Session(
        path=source.path,
        sha256=source.sha256,
        robot=arm_of_log(source, log.joint_names),
        start_s=source.start_s,
        duration_s=log.duration_s,
        conditions=Conditions(**made, torque=choice.source, payload=payload, rate_hz=log.rate_hz),
        joints=_summaries(estimate, diagnoses),
        warnings=(*findings, *interaction.warnings),
        codes=tuple(dict.fromkeys((*unit, *codes))),
        damaged=any(finding.damaged for finding in source.findings),
        kind=source.robot,
        named_by_serial=bool(source.serial),
        log_joints=len(log.joint_names),
        torque_unit=source.torque_unit,
        method=f"{estimate.settings.friction.model} ({estimate.friction.estimator})",
    )


def _summaries(estimate: Estimate, diagnoses: "Sequence[JointDiagnosis]") -> tuple[JointSummary, ...]:
    """Return a few numbers per joint that was estimated, instead of a million samples."""
    interaction, cycles, temperature = estimate.interaction, estimate.cycles, estimate.log.temperature
    by_joint = {one.joint: one for one in diagnoses}
    found = []
    for column, joint in enumerate(estimate.friction.joints):
        moving = np.flatnonzero(np.abs(interaction.dq[:, column]) > cycles[column].standstill_rad_s)
        velocity = interaction.dq[moving, column]
        low, median, high = np.quantile(np.abs(velocity), QUARTERS).tolist() if len(moving) else [NAN] * 3
        diagnosed = by_joint.get(joint.joint)
        by_energy = joint.method == "energy"
        coefficients = (joint.coulomb, joint.viscous) if by_energy else (UNDETERMINED, UNDETERMINED)
        found.append(
            JointSummary(
                joint=joint.joint,
                name=joint.name,
                coefficients=dict(zip(COEFFICIENTS, coefficients, strict=True)),
                cycles=joint.cycles,
                moving_s=joint.moving_s,
                speed_rad_s=(low, median, high),
                temperature_c=None if temperature is None else float(temperature[:, joint.joint - 1].mean()),
                within=_change_within(cycles[column], joint),
                curve=bin_torque(velocity, interaction.driving(column, moving)),
                reason=joint.reason if by_energy else BY_REGRESSION,
                verdict=None if diagnosed is None else diagnosed.verdict,
                effects=() if diagnosed is None else tuple(effect.name for effect in diagnosed.effects),
                correlation=joint.correlation,
            )
        )
    return tuple(found)


def bin_torque(velocity: Float, torque: Float) -> SpeedCurve:
    """Return mean and spread of the torque (n,) in equally wide bins of the velocity in motion (n,). [N m, rad/s]"""
    if len(velocity) < FEWEST_SAMPLES:
        return SpeedCurve()
    low, high = np.quantile(velocity, (OUTERMOST, 1.0 - OUTERMOST))
    histogram, centre = partial(np.histogram, velocity, BINS, (low, high)), float(np.mean(torque))
    count = histogram()[0]
    kept = count >= FEWEST_SAMPLES
    moments = (velocity, torque - centre, (torque - centre) ** 2)
    speed, mean, square = (histogram(weights=one)[0][kept] / count[kept] for one in moments)
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))
    return SpeedCurve(speed_rad_s=speed.tolist(), torque_nm=(centre + mean).tolist(), spread_nm=spread.tolist())


def _change_within(own: EnergyCycles, joint: JointFriction) -> dict[str, Coefficient]:
    """Return the relative change of each coefficient from the first third of the cycles to the last one."""
    kept = own.rows(own.reason == KEPT)
    third, found = len(kept.start) // 3, dict.fromkeys(COEFFICIENTS, UNDETERMINED)
    if not joint.reason and third >= FEWEST_CYCLES:
        fit = fit_windows(normal_equations(kept, joint.model), third)  # apart, for points of the history share cycles
        for key, name in zip(COEFFICIENTS, ("coulomb", "viscous"), strict=True):
            first, last = (fit.coefficient(name, end) for end in (0, -1))
            found[key] = relative_change(first, last) if first.low > 0.0 else UNDETERMINED
    return found


def _renamed(worked: Worked, here: str, name: str) -> Worked:
    """Call the log what the user calls it: names that only the worker knows help nowhere else."""
    warnings = [tuple(warning.renamed(here, name) for warning in one.warnings) for one in worked.sessions]
    sessions = [replace(one, path=name, warnings=own) for one, own in zip(worked.sessions, warnings, strict=True)]
    messages = [encodable(one.message.replace(here, name)).removeprefix(f"{name}: ") for one in worked.faults]
    faults = [replace(one, message=text) for one, text in zip(worked.faults, messages, strict=True)]
    return replace(worked, sessions=tuple(sessions), faults=tuple(faults))


def session_of_document(document: Mapping[str, Any], path: Path, wanted: tuple[int, ...] | None) -> Session:
    """Return what a document of ``estimate`` holds, which has no curves, speeds and temperatures."""
    try:
        source, settings = document["source"], document["settings"]
        chosen, friction = settings["torque_chosen"], settings["friction"]
        conditions = Conditions(
            **{name: str(chosen[name]) for name in ("drive", "gravity", "inertia")},
            torque=str(chosen["source"]),
            payload=", ".join(f"{number:g}" for number in settings["torque"]["payload"] or ()),
            rate_hz=float(source["rate_hz"]),
        )
        return Session(
            path=str(path),
            sha256=str(source["sha256"]),
            robot=str(source["robot"]),
            start_s=None if source["start_s"] is None else float(source["start_s"]),
            duration_s=float(source["duration_s"]),
            conditions=conditions,
            joints=tuple(_joint(one) for one in document["joints"] if wanted is None or one["joint"] in wanted),
            codes=tuple(str(one["code"]) for one in document.get("warnings", ())),
            log_joints=int(source["joints"]),
            torque_unit=str(source["torque_unit"]),
            method=f"{friction['model']} ({friction['estimator']})",
        )
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(f"{path}: is no whole document of `estimate` ({error!r}); write it again") from error


def _joint(found: Mapping[str, Any]) -> JointSummary:
    by_energy = found["method"] == "energy"
    return JointSummary(
        joint=int(found["joint"]),
        name=str(found["name"]),
        coefficients={name: Coefficient.read(found[name] if by_energy else None) for name in COEFFICIENTS},
        cycles=int(found["cycles"]),
        moving_s=float(found["moving_s"]),
        speed_rad_s=(NAN, NAN, NAN),
        reason=quoted(str(found["reason"] or "")) if by_energy else BY_REGRESSION,
        correlation=Coefficient.read(found["correlation"]).value,
    )
