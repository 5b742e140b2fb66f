"""The nominal model: exact on exact data, numbers of a model file."""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from friction_audit.diagnosis.prepare import prepare
from friction_audit.diagnosis.samples import least_squares, make_samples, nominal_model
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.errors import AnalysisError
from friction_audit.io.readers.read import read_log
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.preprocessing.settings import TorqueSettings
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, TRUTH, VISCOUS_NMS_PER_RAD, moved_joint

REAL = os.environ.get("FRICTION_AUDIT_REAL_LOGS")
EXACT = moved_joint(duration_s=30.0)
SAMPLES = make_samples(EXACT)
SIMPLE = (FittedTerm("coulomb", (9.0,)), FittedTerm("viscous", (9.0,)))


def test_exact_data_give_the_exact_coefficients() -> None:
    nominal = nominal_model(EXACT, SAMPLES, None)
    values = least_squares(nominal.columns, nominal.y)
    assert dict(zip(nominal.names, values, strict=True)) == pytest.approx(TRUTH, rel=1e-9)


def test_the_baseline_of_effects_is_the_fit() -> None:
    nominal = nominal_model(EXACT, SAMPLES, None)
    baseline = nominal.baseline(np.array([COULOMB_NM, VISCOUS_NMS_PER_RAD, INERTIA_KG_M2]))
    assert baseline.torque == pytest.approx(EXACT.torque)
    assert (baseline.coulomb_nm, baseline.viscous_nms_per_rad, baseline.inertia_kg_m2) == (0.3, 0.07, 0.2)
    assert baseline.declared == frozenset()


def test_a_stated_inertia_is_taken_and_friction_is_fitted_all_the_same() -> None:
    model = JointModel(inertia_kg_m2=0.5 * INERTIA_KG_M2, terms=SIMPLE)
    nominal = nominal_model(EXACT, SAMPLES, model)
    assert nominal.names == ("coulomb_nm", "viscous_nms_per_rad")
    assert nominal.stated == pytest.approx(0.1 * EXACT.ddq)
    assert nominal.y == pytest.approx(SAMPLES.y - SAMPLES.of(0.1 * EXACT.ddq))
    baseline = nominal.baseline(np.array([0.3, 0.07]))
    assert baseline.inertia_kg_m2 == 0.1
    assert baseline.declared == {"inertia_kg_m2"}


def test_a_term_that_is_held_is_stated_and_no_column() -> None:
    held = JointModel(inertia_kg_m2=INERTIA_KG_M2, terms=(FittedTerm("coulomb", (0.4,)), SIMPLE[1]), held=("coulomb",))
    nominal = nominal_model(EXACT, SAMPLES, held)
    assert nominal.names == ("viscous_nms_per_rad",)
    assert nominal.stated == pytest.approx(INERTIA_KG_M2 * EXACT.ddq + 0.4 * EXACT.motion().direction)
    baseline = nominal.baseline(np.array([0.07]))
    assert (baseline.coulomb_nm, baseline.viscous_nms_per_rad) == (0.4, 0.07)
    assert baseline.torque == pytest.approx(EXACT.torque + (0.4 - COULOMB_NM) * EXACT.motion().direction)
    assert baseline.declared == {"inertia_kg_m2", "coulomb_nm"}


def test_a_model_that_holds_everything_leaves_nothing_to_fit() -> None:
    held = JointModel(inertia_kg_m2=INERTIA_KG_M2, terms=SIMPLE, held=("coulomb", "viscous"))
    with pytest.raises(AnalysisError, match="both held"):
        nominal_model(EXACT, SAMPLES, held)


def test_columns_that_are_copies_share_the_smallest_coefficients() -> None:
    w = np.sin(np.arange(50.0))
    assert least_squares(np.column_stack([w, w, np.zeros(50)]), 2.0 * w) == pytest.approx([1.0, 1.0, 0.0])


@pytest.mark.parametrize("seed", range(5))
def test_a_column_of_zeros_has_no_coefficient_not_even_a_rounding(seed: int) -> None:
    columns = np.random.default_rng(seed).standard_normal((40, 6))
    columns[:, [2, 4]] = 0.0
    assert least_squares(columns, np.sin(np.arange(40.0)))[[2, 4]].tolist() == [0.0, 0.0]


@pytest.mark.skipif(REAL is None, reason="FRICTION_AUDIT_REAL_LOGS is not set")
def test_residual_of_a_real_arm_below_4_hz() -> None:
    path = Path(str(REAL), "marcocognetti+FrankaEmikaPandaDynModel", "panda_excitation.parquet")
    estimate = estimate_log(read_log(path), AuditSettings(torque=TorqueSettings(drive="robot", robot="panda")))
    left = []
    for data in prepare(estimate.interaction, estimate.cycles, estimate.log):
        samples = make_samples(data)
        nominal = nominal_model(data, samples, None)
        offset = np.column_stack([nominal.columns, samples.of(np.ones((len(data.t), 1)))])
        fine = data.torque - np.column_stack([nominal.fine, np.ones(len(data.t))]) @ least_squares(offset, nominal.y)
        low = sosfiltfilt(butter(4, 4.0, fs=1.0 / data.step_s, output="sos"), fine)
        left.append(float(np.sqrt(np.mean(low[data.used] ** 2))))
    # Measured: .13 .34 .20 .16 .08 .07 .06; refitting all inertias to this log leaves .12 .15 .14 .13 .07 .04 .05.
    assert np.all(np.array(left) < [0.15, 0.38, 0.23, 0.19, 0.10, 0.08, 0.07]), left


def test_numbers_that_a_model_file_lacks_are_no_columns() -> None:
    of_angle = FittedTerm("gravity_error", (0.3, 0.1, *([0.0] * 15)))
    nominal = nominal_model(EXACT, SAMPLES, JointModel(inertia_kg_m2=0.5, terms=(*SIMPLE, of_angle)))
    assert "gravity_cos_nm" in nominal.names
    assert "gravity_across_2_m_s2" in nominal.names
    assert not [name for name in nominal.names if name.startswith(("next", "last"))]
    several = FittedTerm("gravity_error", (0.0,) * 9 + (0.1,) + (0.0,) * 6 + (-2.0,))
    nominal = nominal_model(EXACT, SAMPLES, JointModel(inertia_kg_m2=0.5, terms=(*SIMPLE, several)))
    assert [name for name in nominal.names if name.startswith(("next", "last"))] == ["next_link_moment_y_kg_m"]
