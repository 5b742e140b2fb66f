"""Fig. 6: viscous friction is estimated after a cycle, and followed."""

import pytest

from friction_audit.simulation.scenarios import NMS_PER_RAD_OF_NS_PER_MM
from tests.reproduce.conftest import Check, simulated


@pytest.mark.parametrize(
    "sentence",
    [
        "the estimate is right after the first cycle",
        "no net dissipation in cycles 2 and 3",
        "right again after the fourth cycle, friction having doubled at 6 s",
    ],
)
def test_claims_hold_to_a_thousandth(sentence: str, claims: Check) -> None:
    claim = claims("6")[sentence]
    assert claim.value < 1e-3
    assert claim.holds


def test_friction_is_that_of_the_paper() -> None:
    settings = simulated("6")["fig6"][0].truth.settings
    viscous, step = settings.joints[0].viscous_nms_per_rad, settings.hidden[0].friction_step
    assert viscous == pytest.approx(10.0 * NMS_PER_RAD_OF_NS_PER_MM)
    assert viscous * (1.0 + step.change) == pytest.approx(20.0 * NMS_PER_RAD_OF_NS_PER_MM)
    assert step.at_share * settings.duration_s == pytest.approx(6.0)
