"""Noise of any colour asks for no curve; what something missing has bent is asked for."""

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.wanted_curves import wanted_curves
from friction_audit.joint_log import Float

SAMPLES = 4000
RNG = np.random.default_rng(0)
PLACE, PACE = RNG.standard_normal((2, SAMPLES, 6))
CURVES = [Group(name="position", shapes=(PLACE,)), Group(name="speed", shapes=(PACE,))]
BASE = np.ones((SAMPLES, 1))
RUN = np.zeros(SAMPLES, np.int64)


def noise(memory: float) -> Float:
    return np.asarray(
        lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], np.random.default_rng(1).normal(size=SAMPLES))
    )


@pytest.mark.parametrize("memory", [0.0, 0.9, 0.98])
def test_noise_asks_for_none(memory: float) -> None:
    assert wanted_curves(noise(memory), BASE, CURVES, RUN).shape == (SAMPLES, 0)


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_what_is_bent_asks_for_its_own_curve(memory: float) -> None:
    wanted = wanted_curves(noise(memory) + 0.5 * PLACE[:, 2], BASE, CURVES, RUN)
    assert np.array_equal(wanted, PLACE)


def test_an_exact_model_asks_for_none() -> None:
    assert wanted_curves(np.full(SAMPLES, 2.0), BASE, CURVES, RUN).shape == (SAMPLES, 0)


def test_without_curves_there_is_none() -> None:
    assert wanted_curves(noise(0.0), BASE, [], RUN).shape == (SAMPLES, 0)
