"""An estimate, or its document -> a recording that is compared with others."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from friction_audit.batch.work import session_of
from friction_audit.drift.covariates import Recording
from friction_audit.drift.session import COEFFICIENTS, Conditions, JointSummary, Session
from friction_audit.drift.summarise import BY_REGRESSION
from friction_audit.errors import InputError
from friction_audit.friction.history import NAN, UNDETERMINED, Coefficient
from friction_audit.pipeline import Estimate


def recording_of(estimate: Estimate) -> Recording:
    """Return what is compared of an estimate."""
    session, payload, friction = session_of(estimate), estimate.settings.torque.payload, estimate.settings.friction
    held = replace(session.conditions, payload=_payload(payload))
    return Recording(
        session=replace(session, conditions=held),
        joints=len(estimate.log.joint_names),
        unit=estimate.log.source.torque_unit,
        method=f"{friction.model} ({friction.estimator})",
        correlation={joint.joint: joint.correlation for joint in estimate.friction.joints},
    )


def recording_of_document(document: Mapping[str, Any], path: Path) -> Recording:
    """Return what is compared of a document of ``estimate``; it holds no curves, speeds and temperatures.

    Raises:
        InputError: If a key is missing or holds something else.
    """
    try:
        source, settings = document["source"], document["settings"]
        chosen, friction = settings["torque_chosen"], settings["friction"]
        conditions = Conditions(
            drive=str(chosen["drive"]),
            torque=str(chosen["source"]),
            gravity=str(chosen["gravity"]),
            inertia=str(chosen["inertia"]),
            payload=_payload(settings["torque"]["payload"]),
            rate_hz=float(source["rate_hz"]),
        )
        session = Session(
            path=str(path),
            sha256=str(source["sha256"]),
            robot=str(source["robot"]),
            start_s=None if source["start_s"] is None else float(source["start_s"]),
            start_from="nothing" if source["start_s"] is None else "log",
            duration_s=float(source["duration_s"]),
            conditions=conditions,
            joints=tuple(_joint(one) for one in document["joints"]),
            codes=tuple(str(one["code"]) for one in document.get("warnings", ())),
        )
        return Recording(
            session=session,
            joints=int(source["joints"]),
            unit=str(source["torque_unit"]),
            method=f"{friction['model']} ({friction['estimator']})",
            correlation={int(one["joint"]): _number(one["correlation"]) for one in document["joints"]},
        )
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(f"{path}: is no whole document of `estimate` ({error!r}); write it again") from error


def _joint(found: Mapping[str, Any]) -> JointSummary:
    by_energy = found["method"] == "energy"
    values = (_coefficient(found[name]) for name in COEFFICIENTS)
    return JointSummary(
        joint=int(found["joint"]),
        name=str(found["name"]),
        coefficients=dict(zip(COEFFICIENTS, values if by_energy else (UNDETERMINED, UNDETERMINED), strict=True)),
        cycles=int(found["cycles"]),
        moving_s=float(found["moving_s"]),
        speed_rad_s=(NAN, NAN, NAN),
        reason=str(found["reason"] or "") if by_energy else BY_REGRESSION,
    )


def _coefficient(found: Mapping[str, Any] | None) -> Coefficient:
    if found is None:
        return UNDETERMINED
    low, high = (_number(end) for end in found["ci95"])
    return Coefficient(value=float(found["value"]), low=low, high=high)


def _number(found: float | None) -> float:
    number = NAN if found is None else float(found)
    if math.isinf(number):
        raise ValueError(number)
    return number


def _payload(found: Iterable[float] | None) -> str:
    return "" if found is None else ", ".join(f"{number:g}" for number in found)
