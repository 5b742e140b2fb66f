"""The diagnosis by hand with the samples of its joints: what the figures of a diagnosis draw."""

from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.result import JointDiagnosis, NamedEffect, SimulationGap, Traces
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from tests.reporting import diagnosis_by_hand as by_hand

CYCLES, ROWS, STEP_S = 30, 40, 0.01
LEFT_OUT = 3
"""Samples at the beginning of a cycle that are not there."""
NOISE_NM, MISSING_NM = 0.02, 0.3


def _traces() -> Traces:
    """Return samples in which the nominal model misses MISSING_NM in the direction of motion."""
    rng = np.random.default_rng(0)
    place = np.arange(CYCLES * ROWS)
    place = place[place % ROWS >= LEFT_OUT]
    cycle = place // ROWS
    direction = np.where(cycle % 2, -1.0, 1.0)
    t = np.asarray(STEP_S * place, np.float64)
    speed: Float = 0.05 + 0.3 * np.sin(np.pi * (place % ROWS) / ROWS)
    after = direction * (0.4 + speed)
    return Traces(
        t=t,
        q=direction * speed,
        dq=direction * speed,
        displacement=speed,
        cycle=cycle,
        held_out=cycle % 3 == 1,
        measured=after + NOISE_NM * rng.standard_normal(len(place)),
        before=after - MISSING_NM * direction,
        after=after,
        along={"speed": speed, "time": t},
        corner_hz=17.0,
    )


TRACES = _traces()


def effect_of(effect: NamedEffect) -> NamedEffect:
    return replace(effect, torque=MISSING_NM * np.sign(TRACES.dq))


def _with_rows(joint: JointDiagnosis) -> JointDiagnosis:
    """Return the joint with samples, where it was diagnosed."""
    if joint.gap is None:
        return joint
    return replace(
        joint,
        traces=TRACES,
        effects=tuple(effect_of(effect) for effect in joint.effects),
        profiles=joint.profiles or (by_hand.profile("time", 0.0),),
        remaining=joint.remaining or (by_hand.profile("time", 0.0),),
        simulation=None,
        ladder=joint.ladder or (("nominal model", joint.gap.before), ("noise floor", joint.gap.floor)),
    )


def moved() -> SimulationGap:
    """Return a motion simulated on the held-out cycles, NaN between them."""
    pieces = [np.append(np.arange(c * ROWS, (c + 1) * ROWS) * STEP_S, np.nan) for c in range(1, CYCLES, 3)]
    t = np.concatenate(pieces)[:-1]
    return SimulationGap(before=0.1, after=0.01, unit="rad/s", t=t, measured=np.sin(t), nominal=0.9 * t, augmented=t)


NAMED, AMBIGUOUS, NONE, UNEXPLAINED, NOT_TESTABLE, DATA_FAULT = map(_with_rows, by_hand.VERDICTS_BY_HAND)
NAMED = replace(NAMED, simulation=moved())
ALL = by_hand.diagnosis((NAMED, AMBIGUOUS, NONE, UNEXPLAINED, NOT_TESTABLE, DATA_FAULT))


def of(*joints: JointDiagnosis) -> Diagnosis:
    return by_hand.diagnosis(joints)
