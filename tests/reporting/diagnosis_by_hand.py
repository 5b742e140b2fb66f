"""A diagnosis made by hand: six joints, a verdict each, with the samples that its figures draw."""

from dataclasses import replace
from typing import Any

import numpy as np

from friction_audit.diagnosis import result as r
from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.preprocessing.interaction import Caution, quoted
from tests.reporting.batch_by_hand import number
from tests.reporting.conftest import build_estimate

coefficient = number
NAN = float("nan")
LOCKED = 9
LIMIT = "0.4 s of standstill: an offset of the sensor cannot be separated from uneven friction"
FAULT = "dq differs from the derivative of q by 12%"
ALONE = "no other joint moves: move the neighbours"
UNTESTABLE = {"load_dependent_friction": Caution("unknown_load")}
UNTESTABLE |= dict.fromkeys(("torque_crosstalk", "inertial_coupling"), Caution("still_neighbours"))
CYCLES, ROWS, STEP_S = 30, 40, 0.01
LEFT_OUT = 3
"""Samples at the beginning of a cycle that are not there."""
NOISE_NM, MISSING_NM = 0.02, 0.3


def coefficients(coulomb: float, viscous: float, inertia: float) -> dict[str, Coefficient]:
    values = {"coulomb_nm": coulomb, "viscous_nms_per_rad": viscous, "inertia_kg_m2": inertia}
    return {name: coefficient(value, 0.004) for name, value in values.items()}


DECLARED, GROWN = coefficients(0.33, 0.055, 0.301), coefficients(0.30, 0.07, 0.3)


def profile(axis: str, share: float) -> r.Profile:
    return r.Profile(
        axis=axis, label=f"{axis} [unit]", share=share, p_value=0.001,
        edges=np.array([0.05, 0.15, 0.25, 0.35]), centre=np.array([0.1, 0.2, 0.3]),
        forwards=np.array([0.05, 0.0, NAN]), backwards=np.array([-0.05, 0.0, 0.01]),
        forwards_se=np.array([0.01, 0.01, NAN]), backwards_se=np.array([0.01, 0.01, 0.01]),
    )  # fmt: skip


def traces(cycles: int, **own: Any) -> r.Traces:
    """Return three samples per cycle, at rest, or other ones."""
    rows, empty = np.repeat(np.arange(cycles), 3), np.zeros(3 * cycles)
    every: dict[str, Any] = dict.fromkeys(("t", "q", "dq", "measured", "before", "after"), empty)
    every |= {"cycle": rows, "held_out": rows < LOCKED, "along": {"speed": empty, "time": empty}, "corner_hz": 17.0}
    return r.Traces(**every | own)


def moving_traces() -> r.Traces:
    """Return samples in which the nominal model misses MISSING_NM in the direction of motion."""
    place = np.arange(CYCLES * ROWS)
    place = place[place % ROWS >= LEFT_OUT]
    cycle, t = place // ROWS, np.asarray(STEP_S * place, np.float64)
    sign = np.where(cycle % 2, -1.0, 1.0)
    speed: Float = 0.05 + 0.3 * np.sin(np.pi * (place % ROWS) / ROWS)
    after = sign * (0.4 + speed)
    return traces(
        CYCLES, t=t, q=sign * speed, dq=sign * speed, cycle=cycle, held_out=cycle % 3 == 1,
        measured=after + NOISE_NM * np.random.default_rng(0).standard_normal(len(place)),
        before=after - MISSING_NM * sign, after=after, along={"speed": speed, "time": t},
    )  # fmt: skip


TRACES = moving_traces()


def moved() -> r.SimulationGap:
    """Return a motion simulated on the held-out cycles, NaN between them."""
    pieces = [np.append(np.arange(c * ROWS, (c + 1) * ROWS) * STEP_S, np.nan) for c in range(1, CYCLES, 3)]
    t = np.concatenate(pieces)[:-1]
    return r.SimulationGap(before=0.052, after=0.013, t=t, measured=np.sin(t), nominal=0.9 * t, augmented=t)


STRIBECK = r.NamedEffect(
    name="stribeck", label="what stribeck does", alternatives=(), p_value=0.0004, axis="speed",
    parameters={
        "stribeck_excess_nm": coefficient(0.15, 0.01),
        "stribeck_speed_rad_s": coefficient(0.1, 0.01),
        "stribeck_exponent": Coefficient(value=2.0, low=NAN, high=NAN),
    },
    gap_before_nm=0.061, gap_after_nm=0.021, torque=MISSING_NM * np.sign(TRACES.dq), curve=profile("speed", 0.7),
    evidence=(r.Evidence(name="warm_up", two_ln_bayes_factor=41.3, correlation=0.31),),
    size_nm=0.031, friction_share=0.09, residual_share=0.9, grade="minor", folds=5, chosen_in=5,
)  # fmt: skip
BIAS = replace(
    STRIBECK, name="torque_bias", label="what torque_bias does", alternatives=("asymmetric_coulomb",),
    parameters={"factor_1_nm": coefficient(0.1, 0.02)},
)  # fmt: skip


def gap(before: float, after: float, floor: float) -> r.Gap:
    shrink = (before - after) / (before - floor) if before > floor else NAN
    more = {"shrink": shrink, "shrink_se": 0.01, "over_floor": after / floor}
    return r.Gap(before=before, after=after, floor=floor, cycles=LOCKED, **more)


def finding(code: str, verdict: str, value: float = 0.4) -> DataFinding:
    numbers = {"value": value, "case": "scaled"}
    return DataFinding(code=code, numbers=numbers, value=value, unit="s", bound=2.0, verdict=verdict)


NONE = r.JointDiagnosis(
    joint=3, name="panda_joint3", verdict="adequate", nominal=DECLARED, augmented=DECLARED, gap=gap(0.02, 0.02, 0.02),
    omnibus_p=0.7, remaining_p=0.7, detection_limit_nm=0.0048, traces=TRACES,
    profiles=(profile("time", 0.0),), remaining=(profile("time", 0.0),),
    ladder=(("nominal model", 0.02), ("noise floor", 0.02)),
)  # fmt: skip
NAMED = replace(
    NONE, joint=1, name="panda_joint1", verdict="named", effects=(STRIBECK,), augmented=GROWN,
    from_energy=DECLARED | {"viscous_nms_per_rad": coefficient(NAN, NAN)}, gap=gap(0.061, 0.021, 0.020),
    simulation=moved(), detection_limit_nm=0.0043, profiles=(profile("speed", 0.8), profile("time", 0.1)),
    ladder=(("nominal model", 0.061), ("+ stribeck", 0.021), ("noise floor", 0.020)), untestable=UNTESTABLE,
    findings=(finding("dq_noise", "fine"), finding("standstill", "limit")),
)  # fmt: skip
AMBIGUOUS = replace(
    NONE, joint=2, name="panda_joint2", verdict="ambiguous", effects=(BIAS,), augmented=GROWN,
    gap=gap(0.12, 0.03, 0.03), findings=(finding("standstill", "limit"),),
)  # fmt: skip
UNEXPLAINED = replace(
    NONE, joint=4, name="panda_joint4", verdict="unexplained", gap=gap(0.08, 0.08, 0.02), detection_limit_nm=NAN,
    profiles=(profile("speed", 0.6),), remainder_share=0.3,
    checks=(r.ResidualCheck(code="line", along="time", share=0.3, frequency=13.0),),
)  # fmt: skip
NOT_TESTABLE = r.JointDiagnosis(
    joint=5, name="panda_joint5", verdict="not_testable",
    reason=(Caution("too_few_cycles", numbers={"cycles": 0, "fewest": 10, "lacking": ()}),),
)  # fmt: skip
WRONG = (finding("dq_scale", "fault", 0.12),)
DATA_FAULT = r.JointDiagnosis(joint=6, name="panda_joint6", verdict="data_fault", reason=WRONG, findings=WRONG)
FAILED = r.JointDiagnosis(
    joint=6, name="panda_joint6", verdict="failed", traceback="ZeroDivisionError: float division by zero\n",
    reason=quoted("the diagnosis failed with ZeroDivisionError: float division by zero; this is a bug"),
)  # fmt: skip
VERDICTS_BY_HAND = (NAMED, AMBIGUOUS, NONE, UNEXPLAINED, NOT_TESTABLE, DATA_FAULT)


def diagnosis(*joints: r.JointDiagnosis, settings: DiagnosisSettings | None = None) -> Diagnosis:
    found = joints or VERDICTS_BY_HAND
    return Diagnosis(estimate=build_estimate(6), joints=found, settings=settings or DiagnosisSettings())


ALL = diagnosis()
