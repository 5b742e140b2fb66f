"""Samples of a regression: the filter by hand, what counts, and how high the corner may stand."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis import samples as s
from friction_audit.diagnosis.samples import NominalModel, least_squares, make_samples
from friction_audit.effects.joint_data import CORNER_HZ
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.errors import AnalysisError
from friction_audit.preprocessing.even_grid import LowPass
from tests.effects.joint_data_by_hand import (
    COULOMB_NM,
    EXCESS_NM,
    INERTIA_KG_M2,
    RISE_NM_PER_S,
    TRUTH,
    moved_joint,
    started_and_stopped,
)

DATA = moved_joint(duration_s=20.0)


@pytest.mark.parametrize(("frequency", "gain"), [(4.0, 1.0), (13.0, 1.0), (25.0, 0.5), (45.0, 0.0)])
def test_a_sine_passes_without_delay_up_to_the_corner(frequency: float, gain: float) -> None:
    samples = make_samples(DATA)
    sine = np.sin(2 * np.pi * frequency * DATA.t)
    assert samples.of(sine) == pytest.approx(gain * np.sin(2 * np.pi * frequency * samples.t), abs=0.01)


def test_no_sample_sees_a_sample_that_is_not_valid() -> None:
    valid = DATA.valid.copy()
    valid[4001:4003] = False
    samples = make_samples(replace(DATA, valid=valid))
    half_s = len(samples.kernel) // 2 / 400
    seen = samples.t[:, None] - DATA.t[~valid]
    assert np.abs(seen).min() > half_s
    assert np.diff(samples.t).max() == pytest.approx(2 * half_s + 0.01, abs=0.011)


def test_a_short_doubt_about_the_direction_costs_only_the_samples_that_weigh_it() -> None:
    moving = DATA.moving.copy()
    moving[4000:4040] = False
    samples = make_samples(replace(DATA, moving=moving))
    inside = (samples.t >= DATA.t[4000]) & (samples.t < DATA.t[4040])
    assert not inside.any()
    lost = len(make_samples(DATA).t) - len(samples.t)
    assert 10 < lost < 10 + 2 * len(samples.kernel) // 2 / samples.every


def test_a_slow_grid_keeps_its_own_rate_and_a_quarter_as_corner() -> None:
    slow = DATA.t[::8]
    thin = {name: getattr(DATA, name)[::8] for name in ("q", "dq", "ddq", "torque", "cycle", "moving", "valid")}
    samples = make_samples(replace(DATA, t=slow, **thin))
    assert (samples.every, samples.corner_hz) == (1, 12.5)


@pytest.mark.parametrize(
    ("source", "crossing_hz", "removed"),
    [("q", 5.0, 0.0), ("q", 10.0, 0.0), ("q", 16.0, 0.0), ("q", 60.0, 0.0), ("dq", 15.0, 0.0), ("dq", 15.0, 1.0)],
)
def test_the_corner_is_where_the_noise_of_inertia_is_half_of_that_of_the_torque(
    source: str, crossing_hz: float, removed: float
) -> None:
    """Of a position, of a velocity that was logged, and of links whose inertia a model took away."""
    rng, t = np.random.default_rng(0), np.arange(0, 60, 1e-3)
    low_pass = LowPass.for_stamps(t)
    # J (2 pi f)^2 sigma_q, or J 2 pi f sigma_dq, is sigma_torque / 2 at the crossing, both white at the same rate.
    sigma = s.QUIET_SHARE * 0.05 / (0.2 * (2 * np.pi * crossing_hz) ** (2 if source == "q" else 1))
    torque = low_pass.of(t, 0.05 * rng.standard_normal(len(t)))
    signal, slope = low_pass.with_slope(t, sigma * rng.standard_normal(len(t)))
    dq, ddq = (slope, np.gradient(slope, low_pass.t)) if source == "q" else (signal, slope)
    links = removed * 0.2 * ddq
    noisy = replace(DATA, t=low_pass.t, dq=dq, ddq=ddq, torque=torque - links, load=links, derived_from=source)
    # The difference quotient passes only three quarters at 80 Hz, so that the acceleration seems quieter than it is.
    expected = np.clip(crossing_hz, s.LOWEST_CORNER_HZ, CORNER_HZ)
    assert s.corner_for(noisy, 0.2 * (1.0 - removed))[0] == pytest.approx(expected, rel=0.15 if source == "q" else 0.1)


def test_a_joint_that_breaks_away_has_a_sample_for_it_next_to_those_of_its_motion() -> None:
    data = started_and_stopped()
    samples = make_samples(data)
    broke = samples.breakaway
    assert broke.sum() == 20
    assert samples.t[broke] % 1.0 == pytest.approx(0.5, abs=0.011)
    assert np.abs(samples.y[~broke]) == pytest.approx(COULOMB_NM, abs=0.01)
    assert samples.of(np.sign(data.dq))[broke] == pytest.approx(samples.weight[broke] * np.sign(samples.y[broke]))
    early_nm = RISE_NM_PER_S * 0.015  # with stiction the onset is told too early
    excess = np.abs(samples.y / samples.weight)[broke] - COULOMB_NM
    assert np.all((excess > EXCESS_NM - early_nm) & (excess <= EXCESS_NM + 1e-9))
    assert samples.of(data.ddq)[broke] == pytest.approx(0.0)


def test_a_sample_of_break_away_is_as_noisy_as_the_others() -> None:
    quiet, noisy = (make_samples(started_and_stopped(noise, starts=400)) for noise in (0.0, 0.01))
    left = noisy.y - quiet.y
    broke = noisy.weight < 1.0
    assert np.std(left[broke]) == pytest.approx(np.std(left[~broke]), rel=0.15)


def test_a_break_away_next_to_a_hole_or_outside_of_cycles_is_no_row() -> None:
    data = started_and_stopped()
    holed, outside = data.valid.copy(), data.cycle.copy()
    holed[4 * 400 + 180] = False  # in the standstill before the fifth start
    outside[10 * 400 : 11 * 400] = -1
    t = make_samples(replace(data, valid=holed, cycle=outside)).t
    assert not np.any((np.abs(t - 4.5) < 0.02) | (np.abs(t - 10.5) < 0.02))
    assert np.any(np.abs(t - 5.5) < 0.02)


# The nominal model: exact on exact data, numbers of a model file.

EXACT = moved_joint(duration_s=30.0)
SIMPLE = (FittedTerm("coulomb", (9.0,)), FittedTerm("viscous", (9.0,)))


def test_exact_data_give_the_exact_coefficients() -> None:
    nominal = NominalModel.build(EXACT, make_samples(EXACT), None)
    values = least_squares(nominal.columns.T, nominal.y)
    assert dict(zip(nominal.names, values, strict=True)) == pytest.approx(TRUTH, rel=1e-9)
    baseline = nominal.baseline(values)
    assert baseline.torque == pytest.approx(EXACT.torque)
    assert (baseline.coulomb_nm, baseline.viscous_nms_per_rad, baseline.inertia_kg_m2) == pytest.approx(
        (0.3, 0.07, 0.2)
    )
    assert baseline.declared == frozenset()


def test_a_term_that_is_held_is_stated_and_no_column() -> None:
    held = JointModel(inertia_kg_m2=INERTIA_KG_M2, terms=(FittedTerm("coulomb", (0.4,)), SIMPLE[1]), held=("coulomb",))
    nominal = NominalModel.build(EXACT, make_samples(EXACT), held)
    assert nominal.names == ("viscous_nms_per_rad",)
    assert nominal.stated == pytest.approx(INERTIA_KG_M2 * EXACT.ddq + 0.4 * EXACT.motion().direction)
    baseline = nominal.baseline(np.array([0.07]))
    assert (baseline.coulomb_nm, baseline.viscous_nms_per_rad) == (0.4, 0.07)
    assert baseline.torque == pytest.approx(EXACT.torque + (0.4 - COULOMB_NM) * EXACT.motion().direction)
    assert baseline.declared == {"inertia_kg_m2", "coulomb_nm"}


def test_a_model_that_holds_everything_leaves_nothing_to_fit() -> None:
    held = JointModel(inertia_kg_m2=INERTIA_KG_M2, terms=SIMPLE, held=("coulomb", "viscous"))
    with pytest.raises(AnalysisError, match="all_held"):
        NominalModel.build(EXACT, make_samples(EXACT), held)


def test_numbers_that_a_model_file_lacks_are_no_columns() -> None:
    of_angle = FittedTerm("gravity_error", (0.3, 0.1, *([0.0] * 15)))
    nominal = NominalModel.build(EXACT, make_samples(EXACT), JointModel(inertia_kg_m2=0.5, terms=(*SIMPLE, of_angle)))
    assert "gravity_cos_nm" in nominal.names
    assert "gravity_across_2_m_s2" in nominal.names
    assert not [name for name in nominal.names if name.startswith(("next", "last"))]
    several = FittedTerm("gravity_error", (0.0,) * 9 + (0.1,) + (0.0,) * 6 + (-2.0,))
    nominal = NominalModel.build(EXACT, make_samples(EXACT), JointModel(inertia_kg_m2=0.5, terms=(*SIMPLE, several)))
    assert [name for name in nominal.names if name.startswith(("next", "last"))] == ["next_link_moment_y_kg_m"]
