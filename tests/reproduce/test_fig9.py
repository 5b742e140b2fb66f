"""Fig. 9: plateaus, and the ellipse that compensation leaves of them."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.one_joint import last_period, off_ellipse, plateau_nm
from friction_audit.simulation import simulate
from friction_audit.simulation.scenarios import PAPER_SCENARIOS
from tests.reproduce.conftest import Check


def made(dq: np.ndarray, interaction_nm: np.ndarray) -> Course:
    nothing = np.zeros_like(dq)
    return Course(
        t=1e-3 * np.arange(len(dq), dtype=np.float64),
        dq=dq,
        interaction_nm=interaction_nm,
        energy_j=nothing,
        ends_s=nothing[:0],
        ends_j=nothing[:0],
        coulomb_nm=nothing,
        viscous_nms_per_rad=nothing,
        damping_nms_per_rad=nothing,
    )


PHASE = np.linspace(0.001, 2.0 * np.pi, 4000)


def test_plateaus_by_hand() -> None:
    inertia, dq = 0.4 * np.cos(PHASE), np.sin(PHASE)
    assert plateau_nm(made(dq, inertia + 0.3 * np.sign(dq))) == pytest.approx(0.3, rel=1e-3)
    assert plateau_nm(made(dq, inertia)) == pytest.approx(0.0, abs=1e-3)


def test_ellipses_by_hand() -> None:
    dq = np.sin(PHASE)
    assert off_ellipse(made(dq, 0.4 * np.cos(PHASE))) == pytest.approx(0.0, abs=1e-6)
    assert off_ellipse(made(dq, 0.4 * np.cos(PHASE) + 0.3 * np.sign(dq))) > 0.2


def test_the_plateaus_are_the_coulomb_friction(claims: Check) -> None:
    claim = claims("9")["with combined friction, a pair of plateaus at plus and minus the Coulomb friction"]
    assert claim.value < 0.02
    assert claim.holds


def test_no_plateau_is_left(claims: Check) -> None:
    claim = claims("9")["perfectly compensated, no plateau is left"]
    assert claim.value < 0.02
    assert claim.holds


def test_an_ellipse_is_left(claims: Check) -> None:
    claim = claims("9")["and the curve is an ellipse"]
    assert claim.value < 30.0 * 1e-3 / (0.3 + 0.3)  # b dt / (m + B) of the scenario
    assert claim.holds


def test_without_friction_the_ellipse_is_exact() -> None:
    """What is left with a compensator is its clock's, not the measure's."""
    aided = next(scenario.settings for scenario in PAPER_SCENARIOS if scenario.name == "fig9-compensated")
    free = replace(aided.joints[0], coulomb_nm=0.0, viscous_nms_per_rad=0.0)
    assert off_ellipse(last_period(simulate(replace(aided, joints=(free,), compensator=None), 0))) < 2e-4
