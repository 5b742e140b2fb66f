"""Estimates made by hand, whose summaries are known."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.batch.work import BINS, bin_torque, session_of
from friction_audit.drift.session import JointSummary
from friction_audit.friction.history import Coefficient
from friction_audit.friction.settings import FrictionSettings
from friction_audit.joint_log import Float, JointLog
from friction_audit.pipeline import AuditSettings, Estimate, estimate_log
from friction_audit.simulation import BenchSettings, simulate
from tests.reporting.conftest import COULOMB, VISCOUS, build_estimate


def estimated(joints: int) -> Estimate:
    """Return the estimate of strokes made by hand; of seven joints the third stands still."""
    return estimate_log(build_estimate(joints, rate=250.0).log, AuditSettings())


def summaries(estimate: Estimate) -> tuple[JointSummary, ...]:
    return session_of(estimate).joints


@pytest.fixture(scope="module")
def log() -> JointLog:
    """Return one joint moved by hand for a minute."""
    return simulate(BenchSettings(duration_s=60.0, rate_hz=250.0), seed=3).log


def test_coefficients_and_reasons_are_those_of_the_estimate() -> None:
    seven = estimated(7)
    found = summaries(seven)
    assert [one.joint for one in found] == list(range(1, 8))
    assert [one.name for one in found] == list(seven.interaction.joint_names)
    assert found[0].coefficients["coulomb_nm"] == seven.friction.joints[0].coulomb
    assert found[0].coefficients["viscous_nms_per_rad"] == seven.friction.joints[0].viscous
    assert [one.reason != "" for one in found] == [False, False, True, False, False, False, False]
    assert np.isnan(found[2].coefficients["coulomb_nm"].value)
    assert (len(found[2].curve.speed_rad_s), found[0].verdict, found[0].effects) == (0, None, ())
    assert np.isnan(found[2].speed_rad_s).all()


def test_the_curve_shows_both_sides_of_the_friction() -> None:
    found = summaries(estimated(1))[0]
    speed, torque = np.array(found.curve.speed_rad_s), np.array(found.curve.torque_nm)
    assert 20 <= len(speed) <= BINS
    assert (np.diff(speed) > 0).all()
    expected = COULOMB[0] * np.sign(speed) + VISCOUS[0] * speed
    middle = (np.abs(speed) > 0.2) & (np.abs(speed) < 0.8)
    assert np.abs(torque - expected)[middle].max() < 0.05
    assert min(found.curve.spread_nm) > 0.0


def test_bins_hold_means_and_spreads() -> None:
    velocity = np.repeat([-1.0, 1.0], 100)
    torque = np.where(velocity > 0, 0.5, -0.3) + np.tile([0.1, -0.1], 100)
    curve = bin_torque(velocity, torque)
    assert list(curve.speed_rad_s) == [-1.0, 1.0]
    assert curve.torque_nm == pytest.approx((-0.3, 0.5))
    assert curve.spread_nm == pytest.approx((0.1, 0.1))


def test_a_compensator_s_torque_counts_with_the_hand_s() -> None:
    bare = estimated(1)
    help_nm = np.full_like(bare.interaction.torque, 0.1)
    helped = replace(bare, interaction=replace(bare.interaction, compensation=help_nm))
    pairs = zip(summaries(helped)[0].curve.torque_nm, summaries(bare)[0].curve.torque_nm, strict=True)
    assert all(a == pytest.approx(b + 0.1) for a, b in pairs)


def test_what_changes_within_a_session_is_told(log: JointLog) -> None:
    def within(change: Float | float) -> Coefficient:
        assert log.tau_interaction is not None
        warmed = replace(log, tau_interaction=log.tau_interaction * np.broadcast_to(change, log.t.shape)[:, None])
        return summaries(estimate_log(warmed, AuditSettings()))[0].within["coulomb_nm"]

    steady, falling = within(1.0), within(1.0 - 0.3 * log.t / log.t[-1])
    assert steady.low < 0.0 < steady.high
    # From the middle of the first third to the middle of the last one: 0.75 / 0.95 - 1.
    assert falling.low < 0.75 / 0.95 - 1.0 < falling.high < 0.0


def test_a_model_without_a_coefficient_has_no_change_of_it(log: JointLog) -> None:
    settings = AuditSettings(friction=FrictionSettings(model="coulomb"))
    within = summaries(estimate_log(log, settings))[0].within
    assert np.isfinite(within["coulomb_nm"].value)
    assert np.isnan(within["viscous_nms_per_rad"].value)
