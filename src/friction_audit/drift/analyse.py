"""Sessions -> DriftReport: arm by arm, joint by joint."""

from collections.abc import Sequence
from importlib import import_module

from friction_audit.drift.change_points import find_isolated, leave_odd_out
from friction_audit.drift.covariates import (
    LikeTemperature,
    choose_comparable,
    counts,
    use_temperature,
    without_temperature,
)
from friction_audit.drift.describe import Verdict, describe_series, too_few
from friction_audit.drift.family import FamilyTest, judge_family
from friction_audit.drift.report import ArmDrift, CoefficientDrift, DriftReport, JointDrift
from friction_audit.drift.session import COEFFICIENTS, Order, Series, Session, make_series, put_in_order
from friction_audit.drift.settings import FEWEST_SESSIONS, DriftSettings
from friction_audit.drift.shapes import base_shapes, make_directions
from friction_audit.drift.words import describe_arm, describe_joint
from friction_audit.joint_numbers import write_joint_numbers


def analyse_drift(sessions: Sequence[Session], settings: DriftSettings) -> DriftReport:
    """Find what changed between sessions, for each arm by itself.

    Args:
        sessions: Of any arms, in any order.
        settings: How drift is looked for.
    """
    return DriftReport(arms=tuple(analyse_arm(arm, settings) for arm in arms_of(sessions)))


def arms_of(sessions: Sequence[Session]) -> list[tuple[Session, ...]]:
    """Return the sessions of each arm, arms in the order of their names."""
    robots = sorted({session.robot for session in sessions})
    return [tuple(session for session in sessions if session.robot == robot) for robot in robots]


def analyse_arm(sessions: Sequence[Session], settings: DriftSettings) -> ArmDrift:
    """Find what changed between the sessions of one arm."""
    order = put_in_order(sessions)
    alike = choose_comparable(order)
    reference, odd = choose_reference(alike.compared, settings.baseline)
    family, warnings = collect(order, alike.compared)
    verdicts = judge([series.counted() for series in family], settings)
    coefficients = [
        too_few(series, order.sessions)
        if verdict is None
        else describe_series(series, verdict, reference, order.sessions, settings)
        for series, verdict in zip(family, verdicts, strict=True)
    ]
    joints = by_joint(family, coefficients, order.sessions)
    robot = order.sessions[0].robot
    return ArmDrift(
        robot=robot,
        sessions=order.sessions,
        compared=alike.compared,
        reference=reference,
        left_out=alike.left_out,
        joints=joints,
        ordered_by=order.by,
        autocorrelation=max((verdict.memory.correlation for verdict in verdicts if verdict is not None), default=0.0),
        drift=any(joint.drift for joint in joints),
        message=describe_arm(robot, len(alike.compared), joints),
        warnings=(*alike.warnings, *odd, *warnings),
    )


def choose_reference(
    compared: tuple[int, ...], baseline: int | tuple[int, ...]
) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Return the sessions of the reference, and what is wrong with those asked for.

    Args:
        compared: Indices of the sessions that are compared.
        baseline: So many first ones, at most half of them; or indices.
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


def collect(order: Order, compared: tuple[int, ...]) -> tuple[list[Series], list[str]]:
    """Return each coefficient of each joint, isolated sessions and those without a temperature set aside."""
    joints = sorted({joint.joint for index in compared for joint in order.sessions[index].joints})
    family: list[Series] = []
    warnings: dict[str, list[int]] = {}
    for joint in joints:
        for coefficient in COEFFICIENTS:
            series = make_series(order.sessions, compared, joint, coefficient, by_start=order.by == "start")
            like = use_temperature(counts(series, find_isolated(series.y, series.y_error)))
            family.append(leave_odd_out(like.series))
            for text in _temperature_words(order, like):
                warnings.setdefault(text, []).append(joint)
    return family, [_of_joints(text, of, joints) for text, of in warnings.items()]


def _temperature_words(order: Order, like: LikeTemperature) -> list[str]:
    names = ", ".join(order.sessions[index].path for index in like.unknown)
    unknown = [f"not compared, since their temperature is not known: {names}"] if names else []
    return [*([like.warning] if like.warning else []), *unknown]


def _of_joints(text: str, of: Sequence[int], joints: Sequence[int]) -> str:
    some = sorted(set(of))
    return text if some == list(joints) else f"joint{'s' if len(some) > 1 else ''} {write_joint_numbers(some)}: {text}"


def judge(family: Sequence[Series], settings: DriftSettings) -> list[Verdict | None]:
    """Test the coefficients of an arm; None for those with too few sessions.

    Args:
        family: Series, all of whose sessions count.
        settings: How drift is looked for.
    """
    testable = [i for i, series in enumerate(family) if is_testable(series)]
    verdicts: list[Verdict | None] = [None] * len(family)
    if not testable:
        return verdicts
    chosen = [family[i] for i in testable]
    test = _test(chosen, settings)
    bare = [without_temperature(series) for series in chosen]
    plain = _test(bare, settings) if any(series.temperature is not None for series in chosen) else test
    for k, i in enumerate(testable):
        verdicts[i] = Verdict(
            p_value=float(test.p_value[k]),
            ramp_p_value=float(test.ramp_p_value[k]),
            p_without_temperature=float(plain.p_value[k]),
            critical=test.critical,
            memory=test.memory[k],
        )
    return verdicts


def is_testable(series: Series) -> bool:
    """Return whether so many sessions are left that a change may be told from scatter."""
    return len(series.y) >= FEWEST_SESSIONS and len(series.y) > base_shapes(series).shape[1] + 1


def _test(family: Sequence[Series], settings: DriftSettings) -> FamilyTest:
    return judge_family(
        [make_directions(series) for series in family],
        [series.place for series in family],
        [series.coefficient for series in family],
        alpha=settings.alpha,
        permutations=settings.permutations,
        seed=settings.seed,
    )


def by_joint(
    family: Sequence[Series], coefficients: Sequence[CoefficientDrift], sessions: Sequence[Session]
) -> tuple[JointDrift, ...]:
    """Put the coefficients of each joint together."""
    names = {joint.joint: joint.name for session in reversed(sessions) for joint in session.joints}
    joints = []
    for number in dict.fromkeys(series.joint for series in family):
        own = tuple(drift for series, drift in zip(family, coefficients, strict=True) if series.joint == number)
        drifts = any(drift.drift for drift in own)
        message = describe_joint(number, own)
        joints.append(JointDrift(joint=number, name=names[number], coefficients=own, drift=drifts, message=message))
    return tuple(joints)


HEAVY = (
    "scipy.optimize",
    "scipy.signal",
    "scipy.stats",
    "statsmodels.robust.robust_linear_model",
    "statsmodels.stats.multitest",
    "friction_audit.drift.analyse",
)


def load() -> None:
    """Import it."""
    for name in HEAVY:
        import_module(name)
