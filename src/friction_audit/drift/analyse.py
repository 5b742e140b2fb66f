"""Sessions -> DriftReport: arm by arm, joint by joint."""

from collections.abc import Sequence
from dataclasses import replace

from friction_audit.drift.change_points import find_isolated, leave_outliers_out
from friction_audit.drift.change_test import Verdict, judge_family
from friction_audit.drift.coefficient import describe_series, too_few
from friction_audit.drift.covariates import choose_comparable, use_temperature, without_temperature
from friction_audit.drift.regression import baseline_columns
from friction_audit.drift.report import ArmDrift, CoefficientDrift, DriftReport, JointDrift
from friction_audit.drift.session import COEFFICIENTS, Order, Series, Session, make_series, put_in_order
from friction_audit.drift.settings import FEWEST_SESSIONS, DriftSettings
from friction_audit.joint_numbers import write_joint_numbers


def analyse_drift(sessions: Sequence[Session], settings: DriftSettings) -> DriftReport:
    """Find what changed between sessions of any arms, in any order, for each arm by itself."""
    return DriftReport(arms=tuple(analyse_arm(arm, settings) for arm in arms_of(sessions)))


def arms_of(sessions: Sequence[Session]) -> list[tuple[Session, ...]]:
    """Return the sessions of each arm, arms in the order of their names."""
    robots = sorted({session.robot for session in sessions})
    return [tuple(session for session in sessions if session.robot == robot) for robot in robots]


def analyse_arm(sessions: Sequence[Session], settings: DriftSettings) -> ArmDrift:
    """Find what changed between the sessions of one arm."""
    order = put_in_order(sessions)
    compared, left_out, limits = choose_comparable(order)
    reference, odd = choose_reference(compared, settings.baseline)
    family, warnings = _collect(order, compared)
    verdicts = _judge([series.counted() for series in family], settings)
    found: dict[int, list[CoefficientDrift]] = {}
    for series, verdict in zip(family, verdicts, strict=True):
        found.setdefault(series.joint, []).append(
            too_few(series, order.sessions)
            if verdict is None
            else describe_series(series, verdict, reference, order.sessions, settings)
        )
    names = {joint.joint: joint.name for session in reversed(order.sessions) for joint in session.joints}
    return ArmDrift(
        robot=order.sessions[0].robot,
        sessions=order.sessions,
        compared=compared,
        reference=reference,
        left_out=tuple(left_out.items()),
        joints=tuple(JointDrift(joint=n, name=names[n], coefficients=tuple(own)) for n, own in found.items()),
        ordered_by=order.by,
        autocorrelation=max((one.autocorrelation.first for one in verdicts if one is not None), default=0.0),
        warnings=(*limits, *odd, *warnings),
    )


def choose_reference(
    compared: tuple[int, ...], baseline: int | tuple[int, ...]
) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Return the sessions of the reference, and what is wrong with those asked for.

    They are so many first ones of those compared, at most half of them, or those with these indices.
    """
    if isinstance(baseline, int):
        return compared[: min(baseline, max(1, len(compared) // 2))], ()
    chosen = tuple(index for index in baseline if index in compared)
    missing = [str(index + 1) for index in baseline if index not in compared]
    if not chosen:
        first = choose_reference(compared, DriftSettings().baseline)[0]
        return first, ("none of the sessions asked for as the reference can be compared: the first ones are taken",)
    why = f"session {', '.join(missing)} of the reference cannot be compared"
    return chosen, (why,) if missing else ()


def _collect(order: Order, compared: tuple[int, ...]) -> tuple[list[Series], list[str]]:
    """Return each coefficient of each joint, isolated sessions and those without a temperature set aside."""
    joints = sorted({joint.joint for index in compared for joint in order.sessions[index].joints})
    family: list[Series] = []
    warnings: dict[str, set[int]] = {}
    for joint in joints:
        for coefficient in COEFFICIENTS:
            series = make_series(order.sessions, compared, joint, coefficient, by_start=order.by == "start")
            series = replace(series, kept=~find_isolated(series.y, series.y_error))
            like, warning = use_temperature(series, order.sessions)
            family.append(leave_outliers_out(like))
            warnings.setdefault(warning, set()).add(joint)
    warnings.pop("", None)
    said = []
    for text, some in warnings.items():
        which = f"joint{'s' * (len(some) > 1)} {write_joint_numbers(sorted(some))}: "
        said.append(text if len(some) == len(joints) else f"{which}{text}")
    return family, said


def _judge(family: Sequence[Series], settings: DriftSettings) -> list[Verdict | None]:
    """Test the coefficients of an arm, all of whose sessions count; None for those with too few sessions."""
    # One degree of freedom is left given level, temperature and one change.
    testable = {
        i: series
        for i, series in enumerate(family)
        if len(series.y) >= FEWEST_SESSIONS and len(series.y) > baseline_columns(series).shape[1] + 1
    }
    if not testable:
        return [None] * len(family)
    test = plain = judge_family([*testable.values()], settings)
    if any(series.temperature is not None for series in testable.values()):
        plain = judge_family([without_temperature(series) for series in testable.values()], settings)
    pairs = zip(testable, test, plain, strict=True)
    verdicts = {i: replace(found, p_without_temperature=bare.p_value) for i, found, bare in pairs}
    return [verdicts.get(i) for i in range(len(family))]
