"""A figure of an arm without what it does not show is the same figure."""

import pickle
from dataclasses import replace

import pytest

from friction_audit.drift.report import ArmDrift
from friction_audit.drift.session import SpeedCurve
from friction_audit.reporting.batch_drawings import TITLES, describe
from friction_audit.reporting.drawn_arm import as_drawn
from friction_audit.reporting.figures.batch import BATCH_FIGURES, BatchFigure
from friction_audit.reporting.figures.style import figure_bytes
from tests.reporting import batch_by_hand as by_hand


def late_curve() -> ArmDrift:
    """Return an arm whose first joint has no estimate, and a curve in one session of the middle alone."""
    arm = by_hand.arm(9, 2)
    still = replace(arm.joints[0], coefficients=())
    sessions = [
        replace(
            one, joints=(replace(one.joints[0], curve=one.joints[0].curve if k == 4 else SpeedCurve()), *one.joints[1:])
        )
        for k, one in enumerate(arm.sessions)
    ]
    return replace(arm, sessions=tuple(sessions), joints=(still, *arm.joints[1:]))


ARMS = (
    pytest.param(by_hand.arm(14, 2), id="a step"),
    pytest.param(by_hand.arm(), id="plain", marks=pytest.mark.thorough),
    pytest.param(by_hand.arm(3, 1), id="one joint", marks=pytest.mark.thorough),
    pytest.param(late_curve(), id="late curve"),
    pytest.param(by_hand.hostile().arms[0], id="hostile", marks=pytest.mark.thorough),
)


@pytest.mark.parametrize("kind", BATCH_FIGURES, ids=lambda kind: kind.name)
@pytest.mark.parametrize("arm", ARMS)
def test_the_figure_is_the_same(arm: ArmDrift, kind: BatchFigure) -> None:
    bare = as_drawn(arm, kind.name)
    assert describe(bare, kind.name) == describe(arm, kind.name)
    assert figure_bytes(kind.draw(bare, None), "svg") == figure_bytes(kind.draw(arm, None), "svg")


def test_most_of_an_arm_is_not_sent() -> None:
    arm = by_hand.arm(60)
    whole = len(pickle.dumps(arm))
    assert all(len(pickle.dumps(as_drawn(arm, kind))) < whole / 2 for kind in TITLES)


def test_the_kinds_are_named_in_the_order_of_the_figures() -> None:
    assert tuple(TITLES) == tuple(kind.name for kind in BATCH_FIGURES)
