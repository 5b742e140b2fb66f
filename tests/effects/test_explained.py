"""Torques by hand: each is explained by its own effect, and not by those that resemble it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.dynamics.motion import RigidBody
from friction_audit.effects.joint_data import JointData, mean_sign
from friction_audit.effects.load import OWN_ANGLE, SEVERAL, independent
from friction_audit.effects.neighbours import AFTER, ALL, BEFORE, BOTH
from friction_audit.effects.registry import effect_of
from friction_audit.joint_log import Float
from friction_audit.reporting.notices import sentence_of
from tests.diagnosis.toy_effects import altered
from tests.each_case import thorough
from tests.effects.joint_data_by_hand import STEP_S, baseline, joint_data, share_explained, two_sines

DATA = two_sines()
SHORT = two_sines(30.0)
Q_S, SIGN_S = SHORT.q, np.sign(SHORT.dq)
COLD = replace(DATA, temperature=None)
HEAT = np.sin(DATA.t / 9.0)
HEATED = replace(DATA, temperature=25.0 + 10.0 * HEAT)
T, Q, V, S = DATA.t, DATA.q, DATA.dq, np.sign(DATA.dq)
WEIGHT = 8.0 * np.sin(Q + 0.4)
LOADED = replace(DATA, load=WEIGHT)
BORNE = WEIGHT + baseline(DATA).torque
ORDERS = [at["ripple_order"] for at in effect_of("torque_ripple").grid(DATA)]


def lugre(reach_rad: float, damping_s: float) -> Float:
    """Euler steps of Canudas de Wit's equations at a constant level of 1."""
    z, substeps, torque = 0.0, 20, np.zeros(len(SHORT.q))
    for k, v in enumerate(SHORT.dq.tolist()):
        for _ in range(substeps):
            rate = v - abs(v) * z / reach_rad
            z += rate * STEP_S / substeps
        torque[k] = (z + damping_s * rate) / reach_rad
    return torque


def sliders(reach_rad: float) -> Float:
    """Springs of equal strength that slip at their reaches."""
    reaches = reach_rad * np.array([0.3, 0.6, 1.0, 1.5])
    bent, torque = np.zeros(len(reaches)), np.zeros(len(SHORT.q))
    for k in range(1, len(SHORT.q)):
        bent = np.clip(bent + SHORT.q[k] - SHORT.q[k - 1], -reaches, reaches)
        torque[k] = np.mean(bent / reaches)
    return torque


def an_arm(*weight: Float, links: Sequence[int] = (2, 3, 7)) -> JointData:
    """A joint with what a model says of it: weights of links, shape (n, 4) each."""
    tilt = np.zeros((len(T), 2))
    body = RigidBody(t=T, links=(*links,), weight=np.stack(weight, axis=1), tilt=tilt, inertial=None, tip=None)
    return replace(DATA, rigid=body)


def four(*columns: Float) -> Float:
    """Columns of a link, zeros after them."""
    return np.column_stack([*columns, *([np.zeros(len(T))] * (4 - len(columns)))])


ANGLES = Q, Q + 1.3 * np.sin(0.7 * T), Q - 0.9 * np.sin(1.1 * T)
OWN, NEXT, LAST = (9.81 * four(np.cos(angle), np.sin(angle)) for angle in ANGLES)
A_LINK = an_arm(four(np.cos(Q + 1.3 * np.sin(0.7 * T))), links=(2,))

CURVED = ("stribeck", "nonlinear_viscous")  # each leaves at most a third of what the other leaves
# Effect, joint, torque, least share that it explains, and bounds on what other effects do, which is always less.
Row = tuple[str, JointData, Float, float, dict[str, float]]
ROWS: list[Row] = [
    *(
        ("stribeck", DATA, S * falling, 0.97, {"nonlinear_viscous": 1.0})
        for falling in (np.exp(-np.abs(V) / 0.1), 1.0 / (1.0 + (V / 0.1) ** 2), np.maximum(1.0 - np.abs(V) / 0.2, 0.0))
    ),
    *(
        ("nonlinear_viscous", DATA, S * rising, 0.98, {"stribeck": 1.0})
        for rising in (np.abs(V) ** 0.5, V**2, np.abs(V) ** 3, np.arcsinh(np.abs(V) / 0.2), np.tanh(np.abs(V) / 0.1),
                       np.arctan(np.abs(V) / 0.1))
    ),
    ("cable_spring", DATA, 0.4 * (Q - 0.3), 0.9, {"joint_limit_stop": 1.0}),
    ("cable_spring", DATA, 0.2 * Q + 0.3 * Q**3, 0.9, {"joint_limit_stop": 1.0}),
    ("cable_spring", DATA, np.sign(Q) * np.maximum(np.abs(Q) - 0.25, 0.0), 0.9, {"joint_limit_stop": 1.0}),
    ("cable_spring", DATA, np.maximum(Q - 0.1, 0.0), 0.99, {"joint_limit_stop": 1.0}),
    ("joint_limit_stop", DATA, 20.0 * (np.maximum(Q - 0.9, 0.0) - np.maximum(-0.95 - Q, 0.0)), 0.95,
     {"cable_spring": 1.0}),
    ("joint_limit_stop", DATA, 20.0 * np.maximum(Q - 0.85, 0.0), 0.95, {"cable_spring": 1.0}),
    ("joint_limit_stop", DATA, -20.0 * np.maximum(-0.9 - Q, 0.0), 0.95, {"cable_spring": 1.0}),
    ("joint_limit_stop", DATA, 100.0 * np.maximum(Q - 0.8, 0.0) ** 2, 0.95, {}),  # a tether that hardens is one too
    ("joint_limit_stop", DATA, (20.0 * (Q - 0.85) + 0.4 * V) * (Q > 0.85), 0.95, {"cable_spring": 1.0}),
    *(
        ("position_dependent_friction", SHORT, SIGN_S * np.cos(order * Q_S + phase), 0.85, {"torque_ripple": 0.05})
        for order in (1.5, 4.4, 11.0)
        for phase in (0.0, 1.0)
    ),
    *(
        ("position_dependent_friction", SHORT, SIGN_S * np.maximum(1.0 - np.abs(Q_S - centre) / width, 0.0), 0.7, {})
        for centre in (-0.6, -0.11, 0.23, 0.5)
        for width in (0.1, 0.2, 0.4)
    ),
    *(
        ("torque_ripple", DATA, np.sin((ORDERS[at] + part * (ORDERS[1] - ORDERS[0])) * Q + 0.4), 0.55, {})
        for at in (0, 20, 60)
        for part in (0.0, 0.25, 0.5)
    ),
    *(
        ("warm_up", COLD, (S + viscous * V) * np.exp(-T / tau), 0.98, {"friction_step": 0.97, "torque_drift": 0.97})
        for tau in (6.0, 15.0, 40.0, 120.0)
        for viscous in (0.0, 0.5)
    ),
    *(
        ("friction_step", COLD, (0.2 * S + 0.1 * V) * np.clip((T - time) / max(length, 1e-6), 0.0, 1.0), 0.95,
         {"warm_up": 0.9, "torque_drift": 0.9})
        for time in (9.3, 30.0, 41.7)
        for length in (0.0, 5.0)
    ),
    *(
        ("torque_drift", COLD, drift, 0.95, {"warm_up": 0.1, "friction_step": 0.1})
        for drift in (T / T[-1], 1.0 - np.exp(-T / 10.0), np.sin(T / 12.0))
    ),
    ("warm_up", HEATED, S * np.exp(-0.5 * HEAT), 0.95, {}),
    *(
        ("load_dependent_friction", LOADED, 0.02 * S * size, 0.999, {})
        for size in (np.abs(WEIGHT), np.abs(BORNE), BORNE**2, np.abs(BORNE) * (1.0 + 0.4 * np.sign(BORNE * V)))
    ),
    ("gravity_error", A_LINK, 0.3 * np.cos(ANGLES[1]), 0.99, {}),
    ("gravity_error", an_arm(OWN, NEXT, LAST), NEXT @ [0.03, 0, 0, 0] + LAST @ [0.02, -0.04, 0, 0], 0.999, {}),
    ("torque_crosstalk", DATA, 0.05 * DATA.others.sensed[:, 2], 0.99, {"inertial_coupling": 0.1}),
    ("inertial_coupling", DATA, 0.05 * DATA.others.ddq[:, 0], 0.99, {"torque_crosstalk": 0.1}),
    ("unlogged_compensation", DATA, -0.2 * np.tanh(V / 0.2), 0.99, {}),
    *(
        ("presliding", SHORT, torque, 0.9, {"backlash": 0.8, "time_delay": 0.8})
        for reach in (0.003, 0.02)
        for torque in (lugre(reach, 0.0), lugre(reach, 0.01), sliders(reach))
    ),
]  # fmt: skip
TURNED = {"cable_spring": 0.7, "joint_limit_stop": 0.5, "load_dependent_friction": 0.5, "unlogged_compensation": 0.5}
# The same torques turned around, or on a joint of which less is known: not explained.
AGAINST: list[tuple[str, JointData, Float, float]] = [
    *((name, data, -torque, most) for name, most in TURNED.items() for row, data, torque, _, _ in ROWS if row == name),
    ("torque_ripple", DATA, np.sin(2.0 * np.pi * 12.0 * T), 0.05),  # a vibration
    ("warm_up", COLD, S * np.exp(-0.5 * HEAT), 0.5),
    ("gravity_error", DATA, 0.3 * np.cos(ANGLES[1]), 0.8),
]
FIRST = {row[0]: row for row in reversed(AGAINST)}
GRIDS = ("position_dependent_friction", "torque_ripple", "warm_up", "friction_step", "presliding")
SECOND = [row for name in GRIDS for row in [row for row in ROWS if row[0] == name][1::2]]  # of numbers of one formula
FEWER = [*(row for row in ROWS if not any(row is one for one in SECOND)), *thorough(SECOND)]


@pytest.mark.parametrize(("name", "data", "torque", "least", "others"), FEWER)
def test_a_torque_is_explained_by_its_own_effect(
    name: str, data: JointData, torque: Float, least: float, others: dict[str, float]
) -> None:
    own = share_explained(effect_of(name), data, torque)
    assert own > least
    found = {other: share_explained(effect_of(other), data, torque) for other in others}
    assert {other: share for other, share in found.items() if share >= min(others[other], own)} == {}
    assert name not in CURVED or 1.0 - max(found.values()) > 3.0 * (1.0 - own)


@pytest.mark.parametrize(
    ("name", "data", "torque", "most"), [*FIRST.values(), *thorough(row for row in AGAINST if row is not FIRST[row[0]])]
)
def test_the_opposite_of_a_torque_is_not_explained(name: str, data: JointData, torque: Float, most: float) -> None:
    assert share_explained(effect_of(name), data, torque) < most


def values(name: str, parameter: str, data: JointData = DATA) -> list[float]:
    return [at[parameter] for at in effect_of(name).grid(data) if at]


def test_grids_scale_with_the_motion() -> None:
    speeds, fast = values("stribeck", "stribeck_speed_rad_s"), float(np.percentile(np.abs(V[DATA.used]), 95))
    assert (min(speeds), max(speeds)) == pytest.approx((0.01 * fast, 0.4 * fast))
    small = joint_data(0.1 * Q, 0.1 * V, 0.1 * DATA.ddq)
    wide = values("presliding", "reach_rad")
    assert values("presliding", "reach_rad", small) == pytest.approx([0.1 * one for one in wide])
    assert ORDERS[0] * np.ptp(Q[DATA.used]) == pytest.approx(4.0 * np.pi)
    assert np.ptp(np.diff(ORDERS)) < 1e-9
    assert (ORDERS[1] - ORDERS[0]) * float(np.std(Q[DATA.used])) <= 1.4 + 1e-9
    flat = replace(DATA, temperature=np.full(len(T), 30.0))
    assert effect_of("warm_up").grid(flat) == effect_of("warm_up").grid(COLD)


def test_a_free_stretch_can_be_refined_and_a_straight_spring_has_none() -> None:
    """Values of the grid that differ by rounding only would leave no room between neighbours."""
    for name in ("cable_centre_rad", "cable_free_rad"):
        assert np.diff(np.unique(values("cable_spring", name))).min() > 1e-3
    assert {} in effect_of("cable_spring").grid(DATA)
    columns = effect_of("cable_spring").regressor(DATA, baseline(DATA), {})
    np.testing.assert_allclose(columns @ [0.4, 0.0, -0.12], 0.4 * (Q - 0.3), atol=1e-12)


@pytest.mark.parametrize(
    ("name", "parameter", "data", "tried"),
    [
        ("torque_crosstalk", "crosstalk_side", replace(DATA, others=replace(DATA.others, joint=0)), [1.0]),
        ("torque_crosstalk", "crosstalk_side", replace(DATA, others=replace(DATA.others, joint=2)), [-1.0]),
        ("inertial_coupling", "coupling_source", DATA, [BEFORE, AFTER, BOTH, ALL]),
        ("inertial_coupling", "coupling_source", replace(DATA, cycle=np.minimum(DATA.cycle, 6)), [BEFORE, AFTER, BOTH]),
        ("gravity_error", "gravity_error_source", DATA, [OWN_ANGLE]),
    ],
)
def test_sources_are_those_that_there_are(name: str, parameter: str, data: JointData, tried: list[int]) -> None:
    assert values(name, parameter, data) == tried


# Several links

SEVERAL_LINKS = {"gravity_error_source": float(SEVERAL)}
GRAVITY = effect_of("gravity_error")
A_KILOGRAM = np.eye(16)[5]


def test_two_links_that_are_wrong_at_once_are_reported_with_their_numbers() -> None:
    data, torque = an_arm(OWN, NEXT, LAST), NEXT @ [0.03, 0, 0, 0] + LAST @ [0.02, -0.04, 0, 0]
    grid = GRAVITY.grid(data)
    assert SEVERAL_LINKS in grid
    found = np.linalg.lstsq(GRAVITY.regressor(data, baseline(data), SEVERAL_LINKS), torque)[0]
    named = {p.name: f for p, f in zip(GRAVITY.coefficients, found, strict=True) if abs(f) > 1e-9}
    names = ["next_link_moment_x_kg_m", "last_link_moment_x_kg_m", "last_link_moment_y_kg_m"]
    assert named == pytest.approx(dict(zip(names, [0.03, 0.02, -0.04], strict=True)))
    one_by_one = altered(GRAVITY, grid=tuple(at for at in grid if at != SEVERAL_LINKS))
    assert share_explained(one_by_one, data, torque) < 0.9


def test_columns_that_depend_on_others_are_left_out() -> None:
    nearly = OWN[:, 0] + 1e-3 * LAST[:, 0]
    data = an_arm(OWN, four(OWN[:, 1], nearly, NEXT[:, 0]), LAST)
    kept, columns = independent(data), GRAVITY.regressor(data, baseline(data), SEVERAL_LINKS)
    assert np.count_nonzero(kept) == np.count_nonzero(columns.any(axis=0)) == 5
    assert kept[[6, 8, 9]].all()
    assert (kept[0], kept[1]) != (kept[5], kept[4])
    left = columns[:, columns.any(axis=0)]
    assert np.linalg.cond(left) < 100.0
    assert np.abs(left @ np.linalg.lstsq(left, OWN)[0] - OWN).max() < 0.02 * 9.81


@pytest.mark.parametrize(
    "weight",
    [(OWN, four(OWN[:, 1]), four(OWN[:, 0])), (OWN, four(), four()), (1e-12 * OWN, 1e-12 * NEXT, 1e-12 * LAST)],
    ids=["the same weight three times", "one link", "rounding"],
)
def test_what_pulls_like_one_link_is_not_several(weight: Sequence[Float]) -> None:
    assert SEVERAL_LINKS not in GRAVITY.grid(an_arm(*weight))


@pytest.mark.parametrize(
    ("name", "at", "possible", "impossible"),
    [
        ("stribeck", {"stribeck_speed_rad_s": 0.1, "stribeck_exponent": 1.0}, 0.1, -0.1),
        ("nonlinear_viscous", {"curved_viscous_exponent": 0.5, "curved_viscous_speed_rad_s": 0.01}, 0.1, -0.1),
        ("nonlinear_viscous", {"curved_viscous_exponent": 2.0, "curved_viscous_speed_rad_s": 0.01}, -0.1, None),
        ("presliding", {}, 0.1, -0.1),
        ("frictional_lag", {}, 0.5, -0.5),
        ("time_delay", {"delay_step_s": 0.01}, 0.009, 0.002),
        ("time_delay", {"delay_step_s": 0.01}, 0.009, -0.01),
        ("joint_elasticity", {"spring_nm_per_rad": 1e3}, 1.1e-3, 1e-4),
        ("backlash", {}, 0.9, 0.1),
        ("gravity_error", SEVERAL_LINKS, A_KILOGRAM, 12.0 * A_KILOGRAM),  # no arm carries so much
    ],
)
def test_coefficients_agree_with_what_the_column_was_built_for(
    name: str, at: dict[str, float], possible: float | Float, impossible: float | Float | None
) -> None:
    assert effect_of(name).possible(np.atleast_1d(possible), at)
    assert impossible is None or not effect_of(name).possible(np.atleast_1d(impossible), at)


ONCE = joint_data(Q[:400], V[:400], DATA.ddq[:400])
FEW = replace(DATA, cycle=DATA.cycle * 7 // (DATA.cycle.max() + 1))


@pytest.mark.parametrize(
    ("name", "data", "lacking"),
    [
        ("stribeck", DATA, None),
        ("presliding", ONCE, "reversals"),
        ("backlash", ONCE, "reversals"),
        ("backlash", DATA, None),
        ("warm_up", two_sines(20.0), "record more than 30 s"),
        ("torque_drift", DATA, None),
        ("torque_drift", two_sines(29.0), "drift"),
        ("torque_drift", FEW, "7 cycles"),
        ("load_dependent_friction", DATA, "not known"),
        ("load_dependent_friction", replace(DATA, load=np.full(len(T), 5.0)), "from 5 to 5 N m"),
        ("load_dependent_friction", replace(DATA, load=10.0 + 2.0 * np.sin(Q)), None),
        ("load_dependent_friction", LOADED, None),
        ("inertia_error", DATA, "inertia_kg_m2"),
        *((name, replace(DATA, unknown_gravity=True), "gravity") for name in ("cable_spring", "torque_bias")),
        ("unlogged_compensation", DATA, 'held = ["coulomb"]'),
    ],
)
def test_what_a_log_lacks_is_named(name: str, data: JointData, lacking: str | None) -> None:
    found = effect_of(name).not_identifiable(data, baseline(data))
    assert str(lacking) in (sentence_of(found) if found else "None")


@pytest.mark.parametrize(("at_s", "expected"), [(0.0, 0.0), (0.002, -0.4), (-0.002, 0.4), (0.005, -1.0), (0.02, -1.0)])
def test_a_reversal_inside_the_cell_counts_for_its_part(at_s: float, expected: float) -> None:
    """Forwards after ``at_s``: of a cell of 10 ms, 5 ms - at_s are forwards."""
    t: Float = np.arange(5, dtype=np.float64) * 0.01
    assert mean_sign(t, np.full(5, -3.0 * at_s), np.full(5, 3.0))[2] == pytest.approx(expected)
    sharp = np.array([1.0, -1.0, 0.5, -0.2, 0.0])
    np.testing.assert_array_equal(mean_sign(t, sharp, np.zeros(5)), np.sign(sharp))
    assert mean_sign(np.zeros(1), np.array([-0.3]), np.array([9.0])) == pytest.approx([-1.0])
