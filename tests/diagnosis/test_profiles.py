"""Where a residual lies, by hand: a sentence, a share and standard errors."""

import numpy as np
import pytest
from statsmodels.api import OLS

from friction_audit.diagnosis.problem import AXES, Curve, curve, knots_of
from friction_audit.diagnosis.profiles import profile_all
from friction_audit.diagnosis.result import Profile
from friction_audit.joint_log import Float
from friction_audit.reporting.diagnosis_words import where_words

CYCLES, PER_CYCLE = 40, 120
CYCLE = np.repeat(np.arange(CYCLES), PER_CYCLE)
N = len(CYCLE)
RNG = np.random.default_rng(0)
VALUES = RNG.uniform(0.0, 1.2, N)
UP = np.repeat(np.arange(CYCLES) % 2 == 0, PER_CYCLE)
DQ = np.where(UP, 1.0, -1.0)
NOISE = 0.02 * RNG.standard_normal(N)


def over(name: str, values: Float) -> Curve:
    axis = next(axis for axis in AXES if axis.name == name)
    columns = curve(values, knots_of(values, np.ones(N, bool)), DQ)
    return Curve(axis=axis, columns=np.ascontiguousarray(columns.T), values=values)


def profile(residual: Float, name: str = "speed") -> Profile:
    (found,) = profile_all(residual, [over(name, VALUES)], DQ, CYCLE, {})
    return found


@pytest.mark.parametrize(
    ("residual", "said"),
    [
        (0.1 * (VALUES < 0.3) * DQ, "below 0.301 rad/s, against the motion"),
        (0.1 * (VALUES > 0.9), "above 0.899 rad/s, same sign in both directions"),
        (0.1 * ((VALUES > 0.4) & (VALUES < 0.7)) * UP, "from 0.4 to 0.7 rad/s, forwards only"),
        (-0.1 * (VALUES < 0.6) * ~UP, "below 0.599 rad/s, backwards only"),
        (0.1 * DQ, "over the whole range of speed, against the motion"),
    ],
)
def test_the_sentence_says_where_and_which_way(residual: Float, said: str) -> None:
    words, expected = where_words(profile(residual + NOISE)).split(), said.split()
    assert len(words) == len(expected)
    for word, wanted in zip(words, expected, strict=True):
        if wanted[0].isdigit():
            # A border of a bin: a twelfth of the samples, 0.1 rad/s.
            assert float(word) == pytest.approx(float(wanted), abs=0.03)
        else:
            assert word == wanted


def test_units_are_those_of_the_axis() -> None:
    assert " rad after a reversal, " in where_words(profile(0.1 * (VALUES < 0.3) + NOISE, "displacement"))
    assert where_words(profile(0.1 * (VALUES < 0.3) + NOISE, "time")).startswith("before 0.2")
    assert where_words(profile(0.1 * (VALUES > 0.9) + NOISE, "time")).startswith("after 0.")
    assert "range of acceleration of a neighbour, " in where_words(profile(0.1 * DQ + NOISE, "neighbour"))
    assert where_words(profile(0.1 * DQ + NOISE, "time")).startswith("over the whole log, ")
    assert " s, " in where_words(profile(0.1 * (VALUES < 0.3) + NOISE, "time"))


def test_means_and_errors_are_those_of_cluster_robust_least_squares() -> None:
    residual = NOISE + 0.05 * np.random.default_rng(1).standard_normal(CYCLES)[CYCLE]
    found = profile(residual)
    inside = UP & (found.edges[3] <= VALUES) & (found.edges[4] > VALUES)
    fit = OLS(residual[inside], np.ones(inside.sum())).fit(
        cov_type="cluster", cov_kwds={"groups": CYCLE[inside], "use_correction": False}
    )
    assert found.forwards[3] == pytest.approx(fit.params[0])
    assert found.forwards_se[3] == pytest.approx(fit.bse[0] * np.sqrt(20 / 19))
    assert found.centre[3] == pytest.approx(VALUES[(found.edges[3] <= VALUES) & (found.edges[4] > VALUES)].mean())


def test_an_empty_side_has_no_mean() -> None:
    forwards = profile_all(NOISE, [over("speed", VALUES)], np.ones(N), CYCLE, {})[0]
    assert np.isnan(forwards.backwards).all()
    assert np.isfinite(forwards.forwards).all()


def test_share_is_that_of_cycles_not_seen_and_never_below_zero() -> None:
    line = 0.1 * DQ * (VALUES - 0.6)
    explained = float(np.mean(line**2))
    assert profile(line + NOISE).share == pytest.approx(explained / (explained + 0.02**2), rel=0.02)
    assert profile(NOISE).share == 0.0
    assert profile(np.zeros(N)).share == 0.0


def test_what_takes_most_comes_first_with_its_p_value() -> None:
    time = np.linspace(0.0, 60.0, N)
    p_values = {"speed": 0.7, "time": 0.01}
    found = profile_all(0.1 * time / 60.0 + NOISE, [over("speed", VALUES), over("time", time)], DQ, CYCLE, p_values)
    assert [(one.axis, one.p_value) for one in found] == [("time", 0.01), ("speed", 0.7)]
    assert np.isnan(profile(NOISE).p_value)
