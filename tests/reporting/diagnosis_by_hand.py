"""A diagnosis made by hand: six joints, a verdict each."""

import numpy as np

from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.diagnosis.result import (
    Discrepancy,
    Evidence,
    Gap,
    JointDiagnosis,
    NamedEffect,
    Profile,
    ResidualCheck,
    SimulationGap,
    Traces,
)
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.friction.history import Coefficient
from friction_audit.pipeline import Diagnosis
from tests.reporting.conftest import build_estimate

NAN = float("nan")
LOCKED = 9
LIMIT = "0.4 s of standstill: an offset of the sensor cannot be separated from uneven friction"
FAULT = "dq differs from the derivative of q by 12%"
NO_LOAD = "the load is not known: log gravity"
ALONE = "no other joint moves: move the neighbours"


def coefficient(value: float, half: float) -> Coefficient:
    return Coefficient(value=value, low=value - half, high=value + half)


DECLARED = {
    "coulomb_nm": coefficient(0.33, 0.01),
    "viscous_nms_per_rad": coefficient(0.055, 0.01),
    "inertia_kg_m2": coefficient(0.301, 0.004),
}
GROWN = {
    "coulomb_nm": coefficient(0.30, 0.004),
    "viscous_nms_per_rad": coefficient(0.07, 0.003),
    "inertia_kg_m2": coefficient(0.3, 0.002),
}


def profile(axis: str, share: float) -> Profile:
    return Profile(
        axis=axis,
        label=f"{axis} [unit]",
        edges=np.array([0.05, 0.15, 0.25, 0.35]),
        centre=np.array([0.1, 0.2, 0.3]),
        forwards=np.array([0.05, 0.0, NAN]),
        backwards=np.array([-0.05, 0.0, 0.01]),
        forwards_se=np.array([0.01, 0.01, NAN]),
        backwards_se=np.array([0.01, 0.01, 0.01]),
        share=share,
        p_value=0.001,
    )


def effect(
    name: str, parameters: dict[str, Coefficient], *, alternatives: tuple[str, ...] = (), before: float, after: float
) -> NamedEffect:
    return NamedEffect(
        name=name,
        label=f"what {name} does",
        alternatives=alternatives,
        parameters=parameters,
        p_value=0.0004,
        axis="speed",
        gap_before_nm=before,
        gap_after_nm=after,
        torque=np.zeros(4),
        evidence=(
            Evidence(name=name, two_ln_bayes_factor=0.0, correlation=1.0),
            Evidence(name="warm_up", two_ln_bayes_factor=41.3, correlation=0.31),
        ),
        curve=profile("speed", 0.7),
        size_nm=0.031,
        friction_share=0.09,
        residual_share=0.9,
        grade="minor",
        folds=5,
        chosen_in=5,
    )


STRIBECK = effect(
    "stribeck",
    {
        "stribeck_excess_nm": coefficient(0.15, 0.01),
        "stribeck_speed_rad_s": coefficient(0.1, 0.01),
        "stribeck_exponent": Coefficient(value=2.0, low=NAN, high=NAN),
    },
    before=0.061,
    after=0.021,
)
BIAS = effect(
    "torque_bias",
    {"factor_1_nm": coefficient(0.1, 0.02)},
    alternatives=("asymmetric_coulomb",),
    before=0.12,
    after=0.03,
)


def gap(before: float, after: float, floor: float) -> Gap:
    shrink = (before - after) / (before - floor) if before > floor else NAN
    return Gap(
        before=before, after=after, floor=floor, shrink=shrink, shrink_se=0.01, over_floor=after / floor, cycles=LOCKED
    )


def finding(code: str, verdict: str, message: str) -> DataFinding:
    return DataFinding(code=code, value=0.4, unit="s", bound=2.0, verdict=verdict, message=message)


def traces(cycles: int) -> Traces:
    rows, empty = np.repeat(np.arange(cycles), 3), np.zeros(3 * cycles)
    return Traces(
        t=empty,
        q=empty,
        dq=empty,
        displacement=empty,
        cycle=rows,
        held_out=rows < LOCKED,
        measured=empty,
        before=empty,
        after=empty,
        along={"speed": empty, "time": empty},
        corner_hz=25.0,
    )


NAMED = JointDiagnosis(
    joint=1,
    name="panda_joint1",
    verdict="named",
    effects=(STRIBECK,),
    nominal=DECLARED,
    augmented=GROWN,
    from_energy=DECLARED | {"viscous_nms_per_rad": coefficient(NAN, NAN)},
    gap=gap(0.061, 0.021, 0.020),
    simulation=SimulationGap(
        before=0.052,
        after=0.013,
        unit="rad/s",
        t=np.zeros(2),
        measured=np.zeros(2),
        nominal=np.zeros(2),
        augmented=np.zeros(2),
    ),
    ladder=(("nominal model", 0.061), ("+ stribeck", 0.021), ("noise floor", 0.020)),
    omnibus_p=0.001,
    remaining_p=0.4,
    detection_limit_nm=0.0043,
    profiles=(profile("speed", 0.8), profile("time", 0.1)),
    remaining=(profile("time", 0.0),),
    untestable={"load_dependent_friction": NO_LOAD, "torque_crosstalk": ALONE, "inertial_coupling": ALONE},
    findings=(finding("dq_noise", "fine", ""), finding("standstill", "limit", LIMIT)),
    traces=traces(30),
)
AMBIGUOUS = JointDiagnosis(
    joint=2,
    name="panda_joint2",
    verdict="ambiguous",
    effects=(BIAS,),
    nominal=DECLARED,
    augmented=GROWN,
    gap=gap(0.12, 0.03, 0.03),
    omnibus_p=0.001,
    remaining_p=0.6,
    detection_limit_nm=0.004,
    findings=(finding("standstill", "limit", LIMIT),),
)
NONE = JointDiagnosis(
    joint=3,
    name="panda_joint3",
    verdict="adequate",
    nominal=DECLARED,
    augmented=DECLARED,
    gap=gap(0.02, 0.02, 0.02),
    omnibus_p=0.7,
    remaining_p=0.7,
    detection_limit_nm=0.0048,
)
UNEXPLAINED = JointDiagnosis(
    joint=4,
    name="panda_joint4",
    verdict="unexplained",
    nominal=DECLARED,
    augmented=DECLARED,
    gap=gap(0.08, 0.08, 0.02),
    omnibus_p=0.001,
    remaining_p=0.001,
    profiles=(profile("speed", 0.6),),
    checks=(ResidualCheck(code="line", along="time", share=0.3, frequency=13.0),),
    remainder_share=0.3,
)
NOT_TESTABLE = JointDiagnosis(
    joint=5,
    name="panda_joint5",
    verdict="not_testable",
    reason="0 energy cycles with motion; at least 10 are needed: move the joint back and forth",
)
DATA_FAULT = JointDiagnosis(
    joint=6, name="panda_joint6", verdict="data_fault", reason=FAULT, findings=(finding("dq_scale", "fault", FAULT),)
)
FAILED = JointDiagnosis(
    joint=6,
    name="panda_joint6",
    verdict="failed",
    reason="the diagnosis failed with ZeroDivisionError: float division by zero; this is a bug, please report it",
    traceback="ZeroDivisionError: float division by zero\n",
)
VERDICTS_BY_HAND = (NAMED, AMBIGUOUS, NONE, UNEXPLAINED, NOT_TESTABLE, DATA_FAULT)


def diagnosis(
    joints: tuple[JointDiagnosis, ...] = VERDICTS_BY_HAND, settings: DiagnosisSettings | None = None
) -> Diagnosis:
    return Diagnosis(
        estimate=build_estimate(6), discrepancy=Discrepancy(joints=joints), settings=settings or DiagnosisSettings()
    )
